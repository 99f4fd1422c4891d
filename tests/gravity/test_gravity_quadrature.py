"""Quadrature over elements: stated tolerance, conserved mass moments, displaced elements, elements in the test mass."""

from __future__ import annotations

import numpy as np
import pytest
from mass_models import CUBE, brick, model, random_element, single
from scipy.spatial.transform import Rotation

from tedm_cli.errors import PhysicsError
from tedm_cli.fem.shapes import CARDS, Shape
from tedm_cli.gravity.field import self_gravity
from tedm_cli.gravity.mass_properties import mass_properties
from tedm_cli.gravity.masses import MassDistribution, PointMasses
from tedm_cli.gravity.quadrature import quadrature_points
from tedm_cli.gravity.structure import StructureGravity, structure_gravity
from tedm_cli.gravity.testmass import TestMass

KINDS: dict[str, tuple[str, Shape]] = {}
for _card in sorted(CARDS, reverse=True):
    for _shape in CARDS[_card]:
        KINDS[f"{_shape.family}{_shape.nodes}"] = (_card, _shape)
KIND_NAMES = sorted(KINDS)


# Inside the cube, so that what stands around the cube stands around it.
SLAB = TestMass(
    name="slab",
    position_m=np.zeros(3),
    side_m=np.array([0.03, 0.02, 0.012]),
    mass_kg=0.5,
    axes=Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix(),
)


def difference(found: StructureGravity, wanted: StructureGravity) -> tuple[float, float]:
    """Largest relative difference of the force family (a, Γ_lin, rows of G for a), and of the torque family.

    Each quantity is judged against its largest element, the torque against a tenth of a centimetre times Ω_lin where
    that is more, because it vanishes on the symmetry axes of the cube.
    """

    def relative(a: np.ndarray, b: np.ndarray, floor: float = 0.0) -> float:
        return float(np.abs(a - b).max() / max(np.abs(b).max(), floor))

    f, w = found.field, wanted.field
    force = max(
        relative(f.acceleration, w.acceleration),
        relative(f.gamma_lin, w.gamma_lin),
        relative(found.operator[0], wanted.operator[0]),
    )
    torque = max(
        relative(f.angular_acceleration, w.angular_acceleration, 1e-3 * float(np.abs(w.omega_lin).max())),
        relative(f.omega_lin, w.omega_lin),
        relative(f.gamma_ang, w.gamma_ang),
        relative(f.omega_ang, w.omega_ang),
        relative(found.operator[1], wanted.operator[1]),
    )
    return force, torque


@pytest.mark.parametrize("kind", KIND_NAMES)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
def test_stated_tolerance_is_met(kind: str, tolerance: float) -> None:
    """Turned, stretched and distorted elements of 20 mm, from a fifth of their size to fifty sizes away."""
    card, shape = KINDS[kind]
    rng = np.random.default_rng(11)
    for gap in (0.2, 0.7, 2.0, 6.0, 12.0, 25.0, 50.0):
        distribution = single(card, random_element(shape, gap * 0.02, 0.02, rng))
        fine = structure_gravity(distribution, CUBE, tolerance=1e-3 * tolerance)
        found = structure_gravity(distribution, CUBE, tolerance=tolerance)
        force, torque = difference(found, fine)
        assert force < tolerance, (gap, force)
        assert torque < 5 * tolerance, (gap, torque)


def uneven(shape: Shape, rng: np.random.Generator) -> np.ndarray:
    """Densities at the nodes: linear over the element, up to ten times as much at one end as at the other."""
    slope = rng.uniform(-1.0, 1.0, shape.dimension)
    at = 1.0 + 0.8 * (2.0 * shape.reference_nodes() - 1.0) @ slope / np.abs(slope).sum()
    return np.asarray(at / at.mean())


@pytest.mark.parametrize("kind", KIND_NAMES)
def test_stated_tolerance_is_met_where_the_density_is_uneven(kind: str) -> None:
    card, shape = KINDS[kind]
    rng, tolerance = np.random.default_rng(17), 1e-4
    for gap in (0.5, 2.0, 12.0):
        nodes = random_element(shape, gap * 0.02, 0.02, rng)
        tapered = model(nodes, [(card, list(range(len(nodes))))], weight=uneven(shape, rng))
        fine = structure_gravity(tapered, CUBE, tolerance=1e-2 * tolerance)
        force, torque = difference(structure_gravity(tapered, CUBE, tolerance=tolerance), fine)
        assert force < tolerance, (gap, force)
        assert torque < 5 * tolerance, (gap, torque)


def test_tapered_bar_pulls_as_its_slices() -> None:
    """Linear density from 0.2 to 1.8 on 40 mm near the test mass, against 400 even bars; second order in the slices."""
    ends = np.array([[0.03, -0.02, 0.005], [0.05, 0.015, 0.01]])
    tapered = structure_gravity(model(ends, [("CBEAM", [0, 1])], weight=np.array([0.2, 1.8])), CUBE, tolerance=1e-8)
    errors = []
    for n in (20, 40):
        cut = np.linspace(0.0, 1.0, n + 1)
        share = (0.2 + 1.6 * (cut[1:] + cut[:-1]) / 2) / n
        slices = model(ends[0] + cut[:, None] * (ends[1] - ends[0]), [("CBEAM", [i, i + 1]) for i in range(n)], share)
        even = structure_gravity(slices, CUBE, tolerance=1e-8)
        errors.append(np.linalg.norm(even.field.acceleration - tapered.field.acceleration))
    assert errors[1] < 1e-4 * np.linalg.norm(tapered.field.acceleration)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.05)


@pytest.mark.parametrize(
    ("thickness", "pull", "gradient", "sensitivity"), [(0.020, 0.0011, 0.042, 0.348), (0.003, -0.076, -0.044, 0.019)]
)
def test_what_lumping_costs(thickness: float, pull: float, gradient: float, sensitivity: float) -> None:
    """Bricks of 20 x 20 mm at 4 mm from the test mass: errors of the eight lumps, and that quadrature has none.

    The sensitivity is that of the pull to the motion of the face that looks at the test mass.
    """
    nodes = brick([0.027, -0.01, -0.01], [0.027 + thickness, 0.01, 0.01])
    exact = structure_gravity(single("CHEXA", nodes), CUBE, tolerance=1e-9)
    lumped = structure_gravity(single("CHEXA", nodes, lumped=True), CUBE, tolerance=1e-9)
    found = structure_gravity(single("CHEXA", nodes), CUBE, tolerance=1e-4)
    face = nodes[:, 0] < 0.0271

    def numbers(g: StructureGravity) -> np.ndarray:
        return np.array([g.field.acceleration[0], g.field.gamma_lin[0, 0], g.operator[0, 0, face, 0].sum()])

    np.testing.assert_allclose(numbers(lumped) / numbers(exact) - 1.0, [pull, gradient, sensitivity], atol=6e-4)
    np.testing.assert_allclose(numbers(found), numbers(exact), rtol=1e-4)


def test_far_elements_are_cheap_and_near_ones_bounded() -> None:
    far = structure_gravity(single("CHEXA", brick([0.4, 0, 0], [0.42, 0.02, 0.02])), CUBE, tolerance=1e-4)
    near = structure_gravity(single("CHEXA", brick([0.027, 0, 0], [0.047, 0.02, 0.02])), CUBE, tolerance=1e-4)
    assert far.sources == 8
    assert near.sources < 5000


def moments(distribution: MassDistribution) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass, centre of gravity and inertia tensor about it of the sources."""
    parts = list(quadrature_points(distribution, CUBE, 1e-6))
    mass = np.concatenate([p.mass.ravel() for p in parts])
    x = np.concatenate([p.position.reshape(-1, 3) for p in parts])
    centre = mass @ x / mass.sum()
    second = np.einsum("p,pi,pj->ij", mass, x - centre, x - centre)
    return float(mass.sum()), centre, np.trace(second) * np.eye(3) - second


def test_moments_of_a_brick_and_what_lumping_adds() -> None:
    """Edge lengths a: I = m (b² + c²)/12 by quadrature; lumped at the corners m (b² + c²)/4, three times that."""
    edge = np.array([0.02, 0.03, 0.05])
    nodes = brick([0.1, 0.1, 0.1], list(0.1 + edge))
    mass, centre, inertia = moments(single("CHEXA", nodes))
    wanted = np.diag((edge**2).sum() - edge**2) / 12.0
    assert mass == pytest.approx(1.0, rel=1e-14)
    np.testing.assert_allclose(centre, 0.1 + edge / 2, rtol=1e-14)
    np.testing.assert_allclose(inertia, wanted, rtol=0, atol=1e-13 * wanted.max())
    lumped = moments(single("CHEXA", nodes, lumped=True))
    np.testing.assert_allclose(lumped[1], centre, rtol=1e-14)
    np.testing.assert_allclose(lumped[2], 3.0 * wanted, rtol=0, atol=1e-13 * wanted.max())


@pytest.mark.parametrize("kind", KIND_NAMES)
def test_mass_properties_are_those_of_the_sources(kind: str) -> None:
    """One rule over whole elements, the other cut by distance from the test mass; offset and of uneven density."""
    card, shape = KINDS[kind]
    rng = np.random.default_rng(4)
    nodes = random_element(shape, 0.02, 0.02, rng)
    lever = rng.uniform(0.0, 1e-3, nodes.shape)
    tapered = model(nodes, [(card, list(range(len(nodes))))], lever=lever, weight=uneven(shape, rng))
    mass, centre, inertia = moments(tapered)
    found = mass_properties(tapered)
    assert found.mass_kg == pytest.approx(mass, rel=1e-13)
    # the sources of curved solids are not exact for moments; warped plates have a root in their measure
    rough = (1e-9 if shape.edges else 1e-12) if shape.dimension == 3 else 3e-5
    np.testing.assert_allclose(found.centre_m, centre, rtol=0, atol=rough * 0.02)
    np.testing.assert_allclose(found.inertia_kg_m2, inertia, rtol=0, atol=10 * rough * np.abs(inertia).max())


def test_elements_cut_into_the_same_body_agree() -> None:
    """A brick is the sum of its tetrahedra, and of its pentahedra: field and moments, whatever the elements."""
    nodes = brick([0.03, -0.02, 0.0], [0.05, 0.02, 0.03])
    tetra = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]
    penta = [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]]
    whole = structure_gravity(single("CHEXA", nodes), CUBE, tolerance=1e-8).field
    for card, cells in (("CTETRA", tetra), ("CPENTA", penta)):
        parts = model(nodes, [(card, c) for c in cells], np.full(len(cells), 1.0 / len(cells)))
        found = structure_gravity(parts, CUBE, tolerance=1e-8).field
        np.testing.assert_allclose(found.acceleration, whole.acceleration, rtol=0, atol=1e-8 * 1e-7)
        np.testing.assert_allclose(
            found.gamma_lin, whole.gamma_lin, rtol=0, atol=2e-8 * float(np.abs(whole.gamma_lin).max())
        )


def rigid(distribution: MassDistribution, shift: np.ndarray, turn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Displacement of all grids, and rotation of the lever grids, of a small rigid motion about the origin."""
    x = distribution.position
    return shift + np.cross(turn, x), np.tile(turn, (len(distribution.lever_node), 1))


@pytest.fixture(scope="module")
def assembly() -> MassDistribution:
    """One element of every kind around the test mass, a plate and a bar offset from their grids, an offset mass."""
    rng = np.random.default_rng(5)
    nodes: list[np.ndarray] = []
    elements, lever, count = [], [], 0
    for name in KIND_NAMES:
        card, shape = KINDS[name]
        xyz = random_element(shape, 0.004, 0.02, rng)
        elements.append((card, list(range(count, count + len(xyz)))))
        count += len(xyz)
        nodes.append(xyz)
        # towards the outside, so that nothing is pushed into the test mass
        out = xyz.mean(axis=0) / np.linalg.norm(xyz.mean(axis=0)) * 0.003
        lever.append(np.tile(out if shape.dimension < 3 else np.zeros(3), (len(xyz), 1)))
    points = PointMasses(name=["CONM2 1"], mass=np.array([0.3]), node=np.array([0]), offset=np.array([[0.0, 0.1, 0.1]]))
    return model(np.concatenate(nodes), elements, lever=np.concatenate(lever), points=points)


def test_rigid_motion_of_everything_is_the_opposite_motion_of_the_test_mass(assembly: MassDistribution) -> None:
    """Translation gives -Γ_lin and -Ω_lin. Rotation of the masses by θ about the test mass turns force and torque."""
    g = structure_gravity(assembly, CUBE, tolerance=1e-6)
    scale = np.abs(g.field.gamma_lin).max(), np.abs(g.field.omega_lin).max()
    for axis in np.eye(3):
        move, _ = rigid(assembly, axis, np.zeros(3))
        change = -np.einsum("qrnc,nc->qr", g.operator, move)
        np.testing.assert_allclose(change[0], -g.field.gamma_lin @ axis, rtol=0, atol=1e-12 * scale[0])
        np.testing.assert_allclose(change[1], -g.field.omega_lin @ axis, rtol=0, atol=1e-12 * scale[1])
        move, turn = rigid(assembly, np.zeros(3), axis)
        change = -np.einsum("qrnc,nc->qr", g.operator, move) - np.einsum("qrnc,nc->qr", g.rotation, turn)
        # dF = -Γ_lin (θ x R) = Γ_lin [R]x θ = -(Γ_ang + [F]x) θ, and dT = Ω_lin [R]x θ = -(Ω_ang + [T]x) θ
        force = -(g.field.gamma_ang @ axis + np.cross(g.field.acceleration, axis))
        np.testing.assert_allclose(change[0], force, rtol=0, atol=1e-12 * np.abs(g.field.gamma_ang).max())


@pytest.mark.parametrize("body", [CUBE, SLAB], ids=["cube", "turned slab"])
def test_displaced_assembly_by_central_differences(assembly: MassDistribution, body: TestMass) -> None:
    """All grids move at random and every piece of mass with the shape functions of its element; second order.

    The mass stays with its piece of material: it is not spread anew over the deformed element.
    """
    rng = np.random.default_rng(8)
    move = rng.normal(size=assembly.position.shape) * 1e-5
    turn = rng.normal(size=(len(assembly.position), 3)) * 1e-3
    g = structure_gravity(assembly, body, tolerance=1e-6)
    wanted = -np.einsum("qrnc,nc->qr", g.operator, move)
    wanted -= np.einsum("qrnc,nc->qr", g.rotation, turn[assembly.lever_node])
    pieces = list(quadrature_points(assembly, body, 1e-6))
    mass = np.concatenate([p.mass.ravel() for p in pieces])
    x = np.concatenate([p.position.reshape(-1, 3) for p in pieces]) @ body.axes
    u = np.concatenate([(p.values @ (move[p.nodes] + np.cross(turn[p.nodes], p.lever))).reshape(-1, 3) for p in pieces])
    errors = []
    for step in (2.0, 1.0):
        two = [self_gravity(x + s * step * u, mass, body) for s in (1, -1)]
        central = [
            (getattr(two[0], name) - getattr(two[1], name)) / (2 * step)
            for name in ("acceleration", "angular_acceleration")
        ]
        errors.append(np.abs(np.array(central) - wanted).max(axis=1) / np.abs(wanted).max(axis=1))
    np.testing.assert_allclose(np.log2(errors[0] / errors[1]), 2.0, atol=0.05)
    assert (errors[1] < 1e-4).all()


def test_shares_of_grids_sum_to_the_field(assembly: MassDistribution) -> None:
    """Of a body whose three moments of inertia differ, turned against the basic frame."""
    found = structure_gravity(assembly, SLAB, tolerance=1e-4)
    for quantity in ("acceleration", "angular_acceleration", "gamma_lin"):
        parts, whole = found.nodal(quantity), getattr(found.field, quantity)
        gross = np.abs(parts).sum(axis=0).max()
        np.testing.assert_allclose(parts.sum(axis=0), whole, rtol=0, atol=1e-12 * gross)
        assert np.abs(whole).max() > 1e-3 * gross


@pytest.mark.parametrize(
    ("card", "nodes"),
    [
        # between its nodes, through the middle, and through a corner only
        ("CQUAD4", [[0.01, -0.1, -0.1], [0.01, 0.1, -0.1], [0.01, 0.1, 0.1], [0.01, -0.1, 0.1]]),
        ("CTRIA3", [[0.02, 0.018, -0.1], [0.02, 0.1, 0.15], [0.02, 0.018, 0.15]]),
        ("CBAR", [[-0.1, 0.005, 0.003], [0.13, 0.005, 0.003]]),
        # a face on a face of the test mass; a node within a hundredth of a millimetre
        ("CHEXA", brick([0.023, -0.01, -0.01], [0.04, 0.01, 0.01])),
        ("CTETRA", [[0.02301, 0, 0], [0.1, 0.1, 0], [0.1, -0.1, 0.1], [0.1, 0, -0.1]]),
        # the test mass wholly inside
        ("CHEXA", brick([-0.1, -0.1, -0.1], [0.2, 0.1, 0.1])),
    ],
)
def test_element_that_reaches_into_the_test_mass_is_named(card: str, nodes: np.ndarray) -> None:
    far = brick([0.2, 0.2, 0.2], [0.3, 0.3, 0.3])
    n = len(nodes)
    distribution = model(
        np.concatenate([far, np.asarray(nodes, dtype=float)]),
        [("CHEXA", list(range(8))), (card, list(range(8, 8 + n)))],
    )
    with pytest.raises(PhysicsError, match=f"'TM1'.*{card} 2 reaches into or touches"):
        structure_gravity(distribution, CUBE, tolerance=1e-3)


def test_plate_thicker_than_its_gap_touches() -> None:
    nodes = np.array([[0.024, -0.01, -0.01], [0.024, 0.01, -0.01], [0.024, 0.01, 0.01], [0.024, -0.01, 0.01]])
    structure_gravity(model(nodes, [("CQUAD4", [0, 1, 2, 3])], thickness=0.001), CUBE, tolerance=1e-3)
    with pytest.raises(PhysicsError, match="CQUAD4 1 reaches") as caught:
        structure_gravity(model(nodes, [("CQUAD4", [0, 1, 2, 3])], thickness=0.0025), CUBE, tolerance=1e-3)
    assert "thickness" in caught.value.hint


def test_a_plate_that_clears_an_edge_of_the_test_mass_is_no_error() -> None:
    """Its bounding box overlaps the test mass, the plate does not."""
    nodes = np.array([[0.06, 0.0, -0.05], [0.0, 0.06, -0.05], [0.0, 0.06, 0.05], [0.06, 0.0, 0.05]])
    assert structure_gravity(single("CQUAD4", nodes), CUBE, tolerance=1e-3).field.acceleration[0] > 0


def test_tangled_solid_is_named() -> None:
    nodes = brick([0.1, 0, 0], [0.2, 0.1, 0.1])
    with pytest.raises(PhysicsError, match="CHEXA 1 is tangled"):
        structure_gravity(single("CHEXA", nodes[[1, 0, 2, 3, 4, 5, 6, 7]]), CUBE, tolerance=1e-3)


def test_point_mass_inside_is_named() -> None:
    points = PointMasses(name=["CONM2 9"], mass=np.ones(1), node=np.array([0]), offset=np.array([[-0.1, 0.0, 0.0]]))
    distribution = model(brick([0.1, 0, 0], [0.2, 0.1, 0.1]), [("CHEXA", list(range(8)))], points=points)
    with pytest.raises(PhysicsError, match="'TM1': CONM2 9 "):
        structure_gravity(distribution, CUBE, tolerance=1e-3)


def test_massless_elements_may_be_anywhere_and_unknown_ones_are_lumped() -> None:
    nodes = np.concatenate([brick([0.1, 0, 0], [0.2, 0.1, 0.1]), brick([-0.01, -0.01, -0.01], [0.01, 0.01, 0.01])])
    elements = [("CPYRAM", [0, 1, 2, 3, 4]), ("CHEXA", list(range(8, 16)))]
    distribution = model(nodes, elements, [0.5, 0.0])
    assert not distribution.elements
    np.testing.assert_allclose(distribution.points.mass, 0.1)
    assert structure_gravity(distribution, CUBE, tolerance=1e-3).sources == 5
