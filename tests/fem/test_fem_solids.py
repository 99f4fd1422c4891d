"""Solids: element matrices against an independent derivation, patch tests, expansion, materials, assembly."""

from __future__ import annotations

import numpy as np
import pytest
from fem_models import (
    ALPHA,
    KINDS,
    NU,
    YOUNG,
    bars,
    block_mesh,
    determinate,
    hexes,
    materials,
    nearest,
    rotation_matrix,
    solid_mesh,
    solids,
    solve,
    structure,
)

from tedm_cli.errors import PhysicsError
from tedm_cli.fem.assembly import assemble
from tedm_cli.fem.bars import bar_matrices
from tedm_cli.fem.constraints import rigid_body_matrix
from tedm_cli.fem.elasticity import ISOTROPIC, isotropic_stiffness, orthotropic_stiffness, rotated
from tedm_cli.fem.solids import solid_matrices
from tedm_cli.fem.structure import SolidMaterials

# Corner signs of the eight-node brick in Nastran's order.
SIGNS = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], float
)


def brick_by_hand(corners, young, nu, alpha):
    """Stiffness [24, 24] and thermal coupling [24, 8] in Voigt notation."""
    elasticity = np.zeros((6, 6))
    elasticity[:3, :3] = nu
    elasticity[range(3), range(3)] = 1.0 - nu
    elasticity[range(3, 6), range(3, 6)] = 0.5 - nu
    elasticity *= young / ((1.0 + nu) * (1.0 - 2.0 * nu))
    stiffness, coupling = np.zeros((24, 24)), np.zeros((24, 8))
    for point in SIGNS / np.sqrt(3.0):
        factors = 1.0 + point * SIGNS
        shape = factors.prod(axis=1) / 8.0
        slope = np.stack([SIGNS[:, a] * np.delete(factors, a, axis=1).prod(axis=1) / 8.0 for a in range(3)], axis=1)
        jacobian = corners.T @ slope
        gradient = slope @ np.linalg.inv(jacobian)
        strain = np.zeros((6, 24))
        for row, (a, b) in enumerate([(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)]):
            strain[row, a::3] = gradient[:, b]
            strain[row, b::3] = gradient[:, a]
        weight = np.linalg.det(jacobian)
        stiffness += weight * strain.T @ elasticity @ strain
        thermal = alpha * np.array([1.0, 1, 1, 0, 0, 0])
        coupling += weight * np.outer(strain.T @ elasticity @ thermal, shape)
    return stiffness, coupling


def distorted_cubes(number):
    rng = np.random.default_rng(3)
    cube = 0.5 * (SIGNS + 1.0)
    return cube + rng.uniform(-0.15, 0.15, (number, 8, 3)) + rng.uniform(-3, 3, (number, 1, 3))


def test_fem_element_matrices_equal_the_voigt_derivation_in_nastran_order():
    corners = distorted_cubes(5)
    young, nu, alpha = np.array([7e10, 1.1e11, 9e10, 2e11, 4e9]), np.array([0.33, 0.3, 0.24, 0.0, 0.45]), 1e-5
    block = hexes(np.arange(40).reshape(5, 8), young=young, nu=nu, alpha=alpha)
    (part,) = solid_matrices(corners.reshape(-1, 3), *block)
    for k in range(5):
        stiffness, coupling = brick_by_hand(corners[k], young[k], nu[k], alpha)
        np.testing.assert_allclose(part.stiffness[k], stiffness, atol=1e-12 * np.abs(stiffness).max())
        np.testing.assert_allclose(part.coupling[k], coupling, atol=1e-12 * np.abs(coupling).max())


BOX, CELLS = (0.3, 0.2, 0.25), (3, 3, 3)
each_kind = pytest.mark.parametrize(("card", "nodes", "bubble"), KINDS)
# A turned, fully anisotropic material: expansion differs and shears in all directions.
TURN = rotation_matrix((0.3, 1.0, -0.4), 2.0)
AXES_STIFFNESS = orthotropic_stiffness(
    np.array([1.4e11, 1.0e10, 9.0e9]), np.array([0.3, 0.28, 0.4]), np.array([5.0e9, 4.5e9, 3.5e9])
)
AXES_EXPANSION = np.array([-1.0e-6, 3.0e-5, 2.0e-5, 4.0e-6, 0.0, -7.0e-6])


def turned_material() -> SolidMaterials:
    stiffness, expansion = rotated(AXES_STIFFNESS, AXES_EXPANSION, TURN)
    return SolidMaterials(stiffness=stiffness[None], expansion=expansion[None], reference_temperature=np.array([293.0]))


def strain_tensor(strain):
    xx, yy, zz, xy, yz, zx = strain
    return np.array([[xx, xy / 2, zx / 2], [xy / 2, yy, yz / 2], [zx / 2, yz / 2, zz]])


def inside(position, size):
    return ((position > 1e-9) & (position < np.array(size) - 1e-9)).all(axis=1)


@each_kind
def test_fem_element_has_six_rigid_motions_and_no_others(card, nodes, bubble):
    position, connectivity = solid_mesh(card, nodes, (1, 1, 1), (1.0, 0.8, 1.2))
    position = position + np.random.default_rng(3).uniform(-0.05, 0.05, position.shape)
    for part in solid_matrices(position, solids(card, connectivity, bubble=bubble)):
        values = np.linalg.eigvalsh(part.stiffness)
        assert np.abs(values[:, :6]).max() < 1e-13 * values[:, -1].max()
        assert (values[:, 6] > 5e-4 * values[:, -1]).all()


@each_kind
@pytest.mark.parametrize("anisotropic", [False, True])
def test_fem_patch_of_distorted_elements_carries_any_constant_strain(card, nodes, bubble, anisotropic):
    table = turned_material() if anisotropic else materials()
    position, connectivity = solid_mesh(card, nodes, CELLS, BOX, distortion=0.3)
    block = solids(card, connectivity, bubble=bubble, table=table)
    stiffness = assemble(structure(position, solids=(block,))).stiffness
    strain = np.array([1.0, -0.5, 0.4, 0.6, 1.4, -0.4]) * 1e-4
    motion = np.zeros((len(position), 6))
    motion[:, :3] = position @ strain_tensor(strain)
    force = (stiffness @ motion.reshape(-1)).reshape(-1, 6)
    inner = inside(position, BOX)
    assert inner.sum() >= 8
    assert np.abs(force[inner]).max() < 1e-12 * np.abs(force).max()
    energy = 0.5 * np.prod(BOX) * strain @ table.stiffness[0] @ strain
    assert 0.5 * motion.reshape(-1) @ force.reshape(-1) == pytest.approx(energy, rel=1e-12, abs=0)


@each_kind
@pytest.mark.parametrize("anisotropic", [False, True])
def test_fem_free_expansion_of_distorted_blocks_is_exact(card, nodes, bubble, anisotropic):
    table = turned_material() if anisotropic else materials(tref=293.0)
    position, connectivity = solid_mesh(card, nodes, CELLS, BOX, distortion=0.3)
    model = structure(
        position,
        solids=(solids(card, connectivity, bubble=bubble, table=table),),
        held=determinate(position, BOX),
    )
    (motion,), report = solve(model, 295.5)
    expected = 2.5 * position @ strain_tensor(table.expansion[0])
    gap = rigid_fit(position, motion[:, :3] - expected)
    assert np.abs(gap).max() < 1e-10 * np.abs(expected).max()
    assert (motion[:, 3:] == 0.0).all()
    assert report.expansion_residual < 1e-13
    assert report.max_relative_residual < 1e-11


def rigid_fit(position, gap):
    """What is left of displacements [N, 3] after the best rigid motion is taken away."""
    rigid = rigid_body_matrix(position - position.mean(axis=0))[:, :3].reshape(-1, 6)
    return (gap.reshape(-1) - rigid @ np.linalg.lstsq(rigid, gap.reshape(-1), rcond=None)[0]).reshape(-1, 3)


def stress_free_gap(card, nodes, bubble, n):
    """Relative error under T = x: u = α (x² - y² - z², 2 x y, 2 x z) / 2 has the strain α x in all directions."""
    position, connectivity = solid_mesh(card, nodes, (n, n, n), (1.0, 1.0, 1.0))
    block = solids(card, connectivity, bubble=bubble)
    model = structure(position, solids=(block,), held=determinate(position, (1.0, 1.0, 1.0)))
    (motion,), _ = solve(model, position[:, 0])
    x, y, z = position.T
    exact = 0.5 * ALPHA * np.stack([x**2 - y**2 - z**2, 2 * x * y, 2 * x * z], axis=1)
    return np.sqrt(np.mean(rigid_fit(position, motion[:, :3] - exact) ** 2) / np.mean(exact**2))


@pytest.mark.parametrize(("card", "nodes", "bubble"), [k for k in KINDS if k[1] > 8] + [("CHEXA", 8, True)])
def test_fem_linear_temperature_leaves_elements_that_bend_free_of_stress(card, nodes, bubble):
    assert stress_free_gap(card, nodes, bubble, 2) < 1e-10


@pytest.mark.parametrize(("card", "nodes", "bubble"), [("CHEXA", 8, False), ("CPENTA", 6, False), ("CTETRA", 4, False)])
def test_fem_linear_temperature_converges_quadratically(card, nodes, bubble):
    errors = np.array([stress_free_gap(card, nodes, bubble, n) for n in (3, 6, 12)])
    orders = np.log2(errors[:-1] / errors[1:])
    assert orders[-1] > 1.8, (errors, orders)


@each_kind
def test_fem_constrained_block_keeps_still_and_presses(card, nodes, bubble):
    # Every face is held along its normal: sigma = -E alpha dT / (1 - 2 nu) in all directions.
    position, connectivity = solid_mesh(card, nodes, CELLS, BOX, distortion=0.3)
    faces = [(position[:, axis] < 1e-9) | (position[:, axis] > BOX[axis] - 1e-9) for axis in range(3)]
    held = [(row, str(axis + 1)) for axis in range(3) for row in np.flatnonzero(faces[axis])]
    model = structure(position, solids=(solids(card, connectivity, bubble=bubble),), held=held)
    (motion,), _ = solve(model, 3.0)
    assert np.abs(motion).max() < 1e-12 * ALPHA * 3.0 * BOX[0]
    force = assemble(model).thermal.forces(np.full((len(position), 1), 3.0)).reshape(-1, 6)
    for axis in range(3):
        area = np.prod(BOX) / BOX[axis]
        pressure = force[position[:, axis] > BOX[axis] - 1e-9, axis].sum() / area
        assert pressure == pytest.approx(YOUNG * ALPHA * 3.0 / (1.0 - 2.0 * NU), rel=1e-12)


@each_kind
def test_fem_solids_and_their_material_turn_with_the_coordinates(card, nodes, bubble):
    position, connectivity = solid_mesh(card, nodes, (3, 2, 1), (0.3, 0.2, 0.05), distortion=0.2)
    held = [(row, "123") for row in np.flatnonzero(position[:, 0] < 1e-9)]
    heat = np.random.default_rng(5).uniform(0.0, 1.0, len(position))
    table = SolidMaterials(
        stiffness=AXES_STIFFNESS[None], expansion=AXES_EXPANSION[None], reference_temperature=np.zeros(1)
    )
    here = structure(position, solids=(solids(card, connectivity, bubble=bubble, table=table),), held=held)
    (straight,), _ = solve(here, heat)
    # The rows of TURN are the material's axes after the turn by its transpose.
    stiffness, expansion = rotated(AXES_STIFFNESS, AXES_EXPANSION, TURN)
    table = SolidMaterials(stiffness=stiffness[None], expansion=expansion[None], reference_temperature=np.zeros(1))
    there = structure(position @ TURN, solids=(solids(card, connectivity, bubble=bubble, table=table),), held=held)
    (turned,), _ = solve(there, heat)
    assert np.abs(turned[:, :3] - straight[:, :3] @ TURN).max() < 1e-9 * np.abs(straight).max()


def test_fem_an_isotropic_material_does_not_know_its_axes():
    stiffness, expansion = isotropic_stiffness(YOUNG, NU), ALPHA * ISOTROPIC
    turned = rotated(stiffness, expansion, TURN)
    np.testing.assert_allclose(turned[0], stiffness, atol=1e-15 * YOUNG * 10)
    np.testing.assert_allclose(turned[1], expansion, atol=1e-20)
    shear = YOUNG / (2 * (1 + NU))
    same = orthotropic_stiffness(np.full(3, YOUNG), np.full(3, NU), np.full(3, shear))
    np.testing.assert_allclose(same, stiffness, rtol=1e-12, atol=1e-3)


def test_fem_orthotropic_strains_follow_the_engineering_constants():
    # Pulled along its second axis by 1 Pa: strain 1/E2 there and -NU12/E1 across; sheared in zx by 1 Pa: 1/G13.
    strain = np.linalg.solve(AXES_STIFFNESS, np.array([0.0, 1.0, 0.0, 0.0, 0.0, 1.0]))
    np.testing.assert_allclose(strain, [-0.3 / 1.4e11, 1e-10, -0.4 / 1e10, 0.0, 0.0, 1 / 4.5e9], rtol=1e-12, atol=1e-25)


def test_fem_assembly_is_the_sum_of_the_elements():
    position, corners = block_mesh((3, 2, 2), BOX)
    position = np.vstack([position, [0.5, 0.1, 0.1]])
    struts = bars([[5, len(position) - 1], [7, len(position) - 1]], (0.0, 0.3, 1.0))
    model = structure(position, solids=hexes(corners, bubble=True), bars=struts)
    dense, load = np.zeros((6 * len(position),) * 2), np.zeros((6 * len(position), len(position)))
    for part in (*solid_matrices(position, model.solids[0]), bar_matrices(position, struts)):
        for k, dof in enumerate(part.dof):
            dense[np.ix_(dof, dof)] += part.stiffness[k]
            load[np.ix_(dof, part.grids[k])] += part.coupling[k]
    found = assemble(model)
    np.testing.assert_allclose(found.stiffness.toarray(), dense, rtol=0, atol=1e-15 * np.abs(dense).max())
    np.testing.assert_allclose(found.thermal.coupling.toarray(), load, rtol=0, atol=1e-15 * np.abs(load).max())


def test_fem_clamped_column_of_two_materials():
    # Without lateral contraction the column is two springs in series: u = dT (k1 a1 L1 - k2 a2 L2) / (k1 + k2).
    position, corners = block_mesh((6, 2, 2), (0.6, 0.1, 0.1))
    left = position[corners].mean(axis=1)[:, 0] < 0.2
    young, alpha = np.where(left, 7e10, 1.1e11), np.where(left, 2.3e-5, 8.6e-6)
    ends = np.flatnonzero((position[:, 0] < 1e-9) | (position[:, 0] > 0.6 - 1e-9))
    sides = [(row, "23") for row in range(len(position)) if row not in ends]
    held = [(row, "123") for row in ends]
    block = hexes(corners, young=young, nu=0.0, alpha=alpha)
    (motion,), _ = solve(structure(position, solids=block, held=held + sides), 3.0)
    k1, k2 = 7e10 / 0.2, 1.1e11 / 0.4
    expected = 3.0 * (k1 * 2.3e-5 * 0.2 - k2 * 8.6e-6 * 0.4) / (k1 + k2)
    interface = nearest(position, (0.2, 0.05, 0.05))
    assert motion[interface, 0] == pytest.approx(expected, rel=1e-12)
    quarter = nearest(position, (0.1, 0.0, 0.1))
    assert motion[quarter, 0] == pytest.approx(0.5 * expected, rel=1e-12)


def test_fem_mirrored_and_collapsed_elements_are_refused_by_id():
    position, corners = block_mesh((3, 1, 1), (3.0, 1.0, 1.0))
    corners[1] = corners[1][[4, 5, 6, 7, 0, 1, 2, 3]]
    corners[2, 6] = corners[2, 0]
    with pytest.raises(PhysicsError, match=r"2 solid element\(s\).*: 2, 3\n"):
        list(solid_matrices(position, *hexes(corners)))
