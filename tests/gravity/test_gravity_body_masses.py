"""Structure, compensation masses and the other test mass near bodies that are no cuboid."""

import numpy as np
import pytest
from bodies import ALL, HALF, cube_of_triangles, tetrahedron, with_pockets
from gravity_reference import cross_matrix
from mass_models import brick, lumped_operator, model, single
from scipy.spatial.transform import Rotation

from tedm_cli.errors import PhysicsError
from tedm_cli.gravity.bodies.cuboid import Sphere
from tedm_cli.gravity.body_source import body_sources, field_of_other_test_mass
from tedm_cli.gravity.compensation import CompensationMass, field_of_compensation_masses
from tedm_cli.gravity.field import self_gravity
from tedm_cli.gravity.structure import structure_gravity
from tedm_cli.gravity.testmass import TestMass

QUANTITIES = ("acceleration", "angular_acceleration", "gamma_lin", "omega_lin", "gamma_ang", "omega_ang")


def mass(body, name="TM1", place=(0.0, 0.0, 0.0), axes=None, kg=1.9):
    return TestMass(name=name, position_m=place, body=body, mass_kg=kg, axes=axes)


POCKETS = mass(with_pockets())
RECESS = np.array([0.004, -0.003, 0.0]) - POCKETS.body.centre_m  # middle of the round one, which is 5 mm deep


def above(z, x=0.0, y=0.0):
    """A place above the middle of the body's geometry, beside the axis of the recess."""
    return RECESS + np.array([x, y, z])


def plunger(half=0.003, low=0.0195, high=0.03, shift=0.0):
    """Nodes of a brick that reaches into the round recess."""
    return brick(above(low, shift - half, -half), above(high, shift + half, half))


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4])
def test_a_plunger_in_a_recess_meets_the_tolerance(tolerance):
    nodes = single("CHEXA", plunger())
    found, fine = (structure_gravity(nodes, POCKETS, tolerance=t) for t in (tolerance, 1e-2 * tolerance))
    for name in ("acceleration", "gamma_lin", "omega_lin"):
        a, b = getattr(found.field, name), getattr(fine.field, name)
        assert np.abs(a - b).max() < 3 * tolerance * np.abs(b).max(), name
    difference = np.abs(found.operator - fine.operator).max(axis=(1, 2, 3))
    assert (difference < 3 * tolerance * np.abs(fine.operator).max(axis=(1, 2, 3))).all()


def test_a_plunger_in_a_recess_is_no_source_inside_a_cuboid():
    """What a cuboid refuses, and what the recess itself does not hold."""
    cuboid = TestMass(name="TM1", position_m=np.zeros(3), side_m=np.full(3, 2 * HALF), mass_kg=1.9)
    with pytest.raises(PhysicsError, match="CHEXA 1 reaches into or touches the test mass"):
        structure_gravity(single("CHEXA", plunger()), cuboid, tolerance=1e-3)
    for nodes in (plunger(shift=0.004), plunger(low=0.0175), plunger(half=0.006)):
        with pytest.raises(PhysicsError, match="CHEXA 1 reaches into or touches the test mass"):
            structure_gravity(single("CHEXA", nodes), POCKETS, tolerance=1e-3)


@pytest.mark.parametrize("kind", ["tetrahedron", "skew cylinder", "tube", "chamfered", "sphere"])
def test_elements_around_any_body_meet_the_tolerance(kind):
    tm = mass(ALL[kind], axes=Rotation.from_rotvec([0.2, -0.4, 0.1]).as_matrix())
    rng = np.random.default_rng(3)
    way = rng.normal(size=(5, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    for n, distance in enumerate((0.07, 0.075, 0.09, 0.12, 0.3)):
        nodes = single("CHEXA", way[n] * distance + brick([-0.01] * 3, [0.01, 0.008, 0.012]))
        found, fine = (structure_gravity(nodes, tm, tolerance=t).field for t in (1e-4, 1e-8))
        for name in ("acceleration", "gamma_lin"):
            a, b = getattr(found, name), getattr(fine, name)
            assert np.abs(a - b).max() < 2e-4 * np.abs(b).max(), (name, distance)


def test_operator_is_the_derivative_of_the_accelerations_also_with_products_of_inertia():
    tm = mass(ALL["notched"], axes=Rotation.from_rotvec([0.2, -0.4, 0.1]).as_matrix())
    points, masses = np.array([[0.05, 0.01, -0.02], [-0.03, 0.04, 0.05]]), np.array([0.4, 0.7])
    found = lumped_operator(points, masses, [tm])
    step = 1e-6
    for n in range(2):
        for k in range(3):
            move = np.zeros((2, 3))
            move[n, k] = step
            plus, minus = (self_gravity(points + s * move, masses, tm) for s in (1, -1))
            rows = [
                (getattr(plus, name) - getattr(minus, name)) / (2 * step) for name in QUANTITIES[:2]
            ]  # accelerations of a test mass that stays, by what moves: minus the operator
            for part, row in ((slice(0, 3), rows[0]), (slice(3, 6), rows[1])):
                assert np.abs(found[part, n, k] + row).max() < 1e-6 * np.abs(found[part]).max()


def test_a_block_in_a_recess_is_a_compensation_mass():
    block = CompensationMass(name="CM", centre_m=above(0.0225), size_m=np.array([0.006, 0.006, 0.005]), mass_kg=0.01)
    found, _, _ = field_of_compensation_masses(POCKETS, [block], tolerance=1e-6)
    nodes = brick(list(block.centre_m - block.size_m / 2), list(block.centre_m + block.size_m / 2))
    distribution = model(nodes, [("CHEXA", list(range(8)))], [0.01])
    same = structure_gravity(distribution, POCKETS, tolerance=1e-5).field
    for name in QUANTITIES:
        a, b = getattr(found, name), getattr(same, name)
        assert np.abs(a - b).max() < 1e-4 * np.abs(b).max(), name
    low = CompensationMass(name="CM", centre_m=above(0.019), size_m=block.size_m, mass_kg=0.01)
    with pytest.raises(PhysicsError, match="compensation mass 'CM' touches or overlaps test mass 'TM1'"):
        field_of_compensation_masses(POCKETS, [low])


PAIRS = [("pockets", "tetrahedron"), ("notched", "skew cylinder"), ("tube", "sphere"), ("chamfered", "cuboid")]


@pytest.mark.parametrize(("first", "second"), PAIRS)
def test_action_and_reaction_of_two_bodies(first, second):
    one = mass(ALL[first], "TM1", [0.07, 0.01, -0.02], Rotation.from_rotvec([0.2, -0.4, 0.1]).as_matrix(), 1.9)
    two = mass(ALL[second], "TM2", [-0.07, 0.0, 0.01], Rotation.from_rotvec([-0.5, 0.1, 0.3]).as_matrix(), 1.4)
    total = np.zeros((2, 3))
    size = 0.0
    for tm, other in ((one, two), (two, one)):
        field, error = field_of_other_test_mass(tm, other, n=12)
        assert error < 1e-6
        force = tm.axes.T @ field.acceleration * tm.mass_kg
        torque = tm.axes.T @ tm.inertia_kg_m2 @ field.angular_acceleration + np.cross(tm.position_m, force)
        total += [force, torque]
        size = float(np.linalg.norm(force))
    assert np.abs(total[0]).max() < 1e-9 * size
    assert np.abs(total[1]).max() < 1e-10 * size


def test_two_spheres_are_two_points():
    one, two = mass(Sphere(0.03), "TM1"), mass(Sphere(0.02), "TM2", [0.2, 0.0, 0.0], kg=2.0)
    field, error = field_of_other_test_mass(one, two, G=1.0)
    assert error == 0.0
    np.testing.assert_allclose(field.acceleration, [2.0 / 0.04, 0.0, 0.0], rtol=1e-15)
    assert not field.angular_acceleration.any()


def test_a_cube_of_triangles_pulls_on_another_as_cubes_do():
    """The published table of two cubes (test_gravity_body_source) holds for their polyhedra."""
    fields = []
    for body in (cube_of_triangles(), ALL["eight cuboids"]):
        pair = [mass(body, name, [x, 0.0, 0.0]) for name, x in (("TM1", 0.188), ("TM2", -0.188))]
        fields.append(field_of_other_test_mass(pair[0], pair[1])[0])
    cubes = [
        TestMass(name=name, position_m=[x, 0.0, 0.0], side_m=[2 * HALF] * 3, mass_kg=1.9)
        for name, x in (("TM1", 0.188), ("TM2", -0.188))
    ]
    wanted = field_of_other_test_mass(cubes[0], cubes[1])[0]
    for field in fields:
        for name in QUANTITIES:
            a, b = getattr(field, name), getattr(wanted, name)
            scale = max(np.abs(b).max(), np.abs(wanted.omega_ang).max() if "angular" in name else 0.0)
            assert np.abs(a - b).max() < 1e-9 * scale, name


def test_sources_of_a_body_keep_its_mass_and_place():
    place, axes = np.array([0.3, -0.1, 0.2]), Rotation.from_rotvec([0.5, 0.2, 0.1]).as_matrix()
    tm = mass(with_pockets(), place=place, axes=axes)
    points, parts = body_sources(tm, 6)
    assert parts.sum() == pytest.approx(tm.mass_kg, rel=1e-13)
    assert (parts < 0).any()
    np.testing.assert_allclose(parts @ points / tm.mass_kg, place, rtol=1e-12)


def test_torque_about_another_point_is_that_of_the_moved_body():
    """Moving sources and body together, turned or not, changes nothing in the frame of the test mass."""
    axes = Rotation.from_rotvec([0.5, 0.2, 0.1]).as_matrix()
    point, kg = np.array([[0.05, 0.01, -0.03]]), [0.7]
    here = self_gravity(point, kg, mass(tetrahedron()))
    there = self_gravity(point @ axes + [1.0, 2.0, 3.0], kg, mass(tetrahedron(), place=[1.0, 2.0, 3.0], axes=axes))
    for name in QUANTITIES:
        a, b = getattr(here, name), getattr(there, name)
        assert np.abs(a - b).max() < 1e-11 * np.abs(a).max(), name
    field = here.omega_ang
    torque = mass(tetrahedron()).inertia_kg_m2 @ here.angular_acceleration
    whole = mass(tetrahedron()).inertia_kg_m2 @ field
    np.testing.assert_allclose(whole - whole.T, -cross_matrix(torque), rtol=0, atol=1e-13 * np.abs(whole).max())


def test_bodies_that_hold_each_other_are_refused():
    one, two = mass(tetrahedron(), "TM1"), mass(Sphere(0.02), "TM2", [0.03, 0.0, 0.0])
    with pytest.raises(PhysicsError, match="'TM1' and 'TM2' overlap or touch"):
        field_of_other_test_mass(one, two)


def test_a_point_in_a_recess_has_a_field_and_one_in_the_body_a_name():
    inside = above(0.0185)
    field = self_gravity([inside], [1.0], POCKETS)
    assert np.isfinite(field.gamma_lin).all()
    with pytest.raises(PhysicsError, match=r"node 42 \(1 kg\) lies inside or on the test mass"):
        self_gravity([above(0.0175)], [1.0], POCKETS, node_ids=[42])
