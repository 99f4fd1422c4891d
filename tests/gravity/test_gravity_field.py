"""Sums over mass distributions: frames, superposition, summation error, errors that name the node."""

import math

import numpy as np
import pytest
from bodies import notched
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from tedm_cli.errors import PhysicsError
from tedm_cli.gravity.constants import G_CODATA_2018
from tedm_cli.gravity.field import self_gravity
from tedm_cli.gravity.kernel import cuboid_field
from tedm_cli.gravity.testmass import TestMass, to_test_mass_frame

FIELDS = ("acceleration", "angular_acceleration", "gamma_lin", "omega_lin", "gamma_ang", "omega_ang")
SIDES = np.array([0.04, 0.05, 0.03])


def cuboid(position=(0.0, 0.0, 0.0), axes=None, name="TM1"):
    return TestMass(name=name, position_m=position, side_m=SIDES, mass_kg=1.9, axes=np.eye(3) if axes is None else axes)


def shell(count, rng, lower=0.05, upper=0.5):
    directions = rng.normal(size=(count, 3))
    return directions / np.linalg.norm(directions, axis=1)[:, None] * rng.uniform(lower, upper, (count, 1))


def assert_close(left, right, tolerance):
    for name in FIELDS:
        expected = getattr(right, name)
        error = np.abs(getattr(left, name) - expected).max()
        assert error <= tolerance * np.abs(expected).max(), f"{name}: {error / np.abs(expected).max():.1e}"


def test_moments_of_inertia_of_a_cube_and_a_brick():
    tm = cuboid()
    assert np.diag(tm.inertia_kg_m2) == pytest.approx(
        [1.9 / 12 * (0.05**2 + 0.03**2), 1.9 / 12 * (0.04**2 + 0.03**2), 1.9 / 12 * (0.04**2 + 0.05**2)], rel=1e-14
    )
    cube = TestMass(name="c", position_m=np.zeros(3), side_m=np.full(3, 0.046), mass_kg=1.96)
    assert np.diag(cube.inertia_kg_m2) == pytest.approx([1.96 * 0.046**2 / 6] * 3, rel=1e-14)


def test_frame_of_the_test_mass_has_its_axes_in_the_rows():
    axes = Rotation.from_euler("z", 90, degrees=True).as_matrix().T
    tm = cuboid(position=(1.0, 2.0, 3.0), axes=axes)
    # a quarter turn about z takes the first axis of the test mass to the basic y
    np.testing.assert_allclose(to_test_mass_frame(tm, [[1.0, 2.5, 3.0]]), [[0.5, 0.0, 0.0]], atol=1e-15)


def test_point_mass_limit_is_newtons_law():
    tm = cuboid(position=(1.0, 0.0, 0.0))
    gravity = self_gravity([[101.0, 0.0, 0.0]], [5.0], tm)
    assert gravity.acceleration[0] == pytest.approx(G_CODATA_2018 * 5.0 / 100.0**2, rel=1e-6)
    # moving the test mass towards the source increases the pull: 2 G m/r³
    assert gravity.gamma_lin[0, 0] == pytest.approx(2 * G_CODATA_2018 * 5.0 / 100.0**3, rel=1e-6)
    assert gravity.gamma_lin[1, 1] == pytest.approx(-G_CODATA_2018 * 5.0 / 100.0**3, rel=1e-6)


def test_normalisation_is_by_mass_and_by_each_moment_of_inertia():
    tm = cuboid()
    point, mass = np.array([[0.06, 0.02, -0.05]]), 3.0
    field, gravity = cuboid_field(point, SIDES), self_gravity(point, [mass], tm, G=2.0)
    per_inertia = 2.0 * mass * tm.mass_kg / np.diag(tm.inertia_kg_m2)
    np.testing.assert_allclose(gravity.acceleration, 6.0 * field.force[0], rtol=1e-14)
    np.testing.assert_allclose(gravity.angular_acceleration, per_inertia * field.torque[0], rtol=1e-14)
    np.testing.assert_allclose(gravity.gamma_ang, 6.0 * field.gamma_ang[0], rtol=1e-14)
    np.testing.assert_allclose(gravity.omega_lin, per_inertia[:, None] * field.omega_lin[0], rtol=1e-14)
    np.testing.assert_allclose(gravity.omega_ang, per_inertia[:, None] * field.omega_ang[0], rtol=1e-14)


def test_normalisation_by_a_tensor_of_inertia_with_products():
    """A notched cuboid: angular accelerations times the whole tensor are the torques."""
    body = notched()
    tm = TestMass(name="TM1", position_m=np.zeros(3), body=body, mass_kg=1.3)
    assert abs(tm.inertia_kg_m2[0, 2]) > 0.05 * tm.inertia_kg_m2[0, 0]
    point, mass = np.array([[0.03, 0.02, -0.05]]), 2.0
    field, gravity = body.field(point), self_gravity(point, [mass], tm, G=1.0)
    for name, of in (("angular_acceleration", "torque"), ("omega_lin", "omega_lin"), ("omega_ang", "omega_ang")):
        torque = tm.inertia_kg_m2 @ getattr(gravity, name)
        wanted = mass * tm.mass_kg * getattr(field, of)[0]
        np.testing.assert_allclose(torque, wanted, rtol=0, atol=1e-13 * np.abs(wanted).max())


@settings(deadline=None, max_examples=25, derandomize=True)
@given(arrays(int, 3, elements=st.integers(-300, 300)), arrays(int, 3, elements=st.integers(-500, 500)))
def test_rigid_motion_of_sources_and_test_mass_changes_nothing(rotation_vector, translation):
    rng = np.random.default_rng(5)
    points, masses = shell(200, rng), rng.uniform(0.1, 2.0, 200)
    turn = Rotation.from_rotvec(rotation_vector / 100.0).as_matrix()
    shift = translation / 1000.0
    moved = cuboid(position=shift, axes=turn.T)
    reference = self_gravity(points, masses, cuboid())
    assert_close(self_gravity(points @ turn.T + shift, masses, moved), reference, 1e-11)


def test_renaming_the_axes_of_a_cube_turns_vectors_and_tensors():
    """The same body with its axes a quarter turn on: physical vectors agree in the basic frame."""
    rng = np.random.default_rng(6)
    points, masses = shell(100, rng), rng.uniform(0.1, 2.0, 100)
    turn = Rotation.from_euler("zx", [90, 90], degrees=True).as_matrix().round()
    straight = TestMass(name="c", position_m=np.zeros(3), side_m=np.full(3, 0.046), mass_kg=2.0)
    turned = TestMass(name="c", position_m=np.zeros(3), side_m=np.full(3, 0.046), mass_kg=2.0, axes=turn)
    a, b = self_gravity(points, masses, straight), self_gravity(points, masses, turned)
    for name in FIELDS:
        value = getattr(a, name)
        image = turn @ value if value.ndim == 1 else turn @ value @ turn.T
        assert np.abs(getattr(b, name) - image).max() <= 1e-12 * np.abs(image).max()


def test_contributions_add():
    rng = np.random.default_rng(8)
    points, masses = shell(300, rng), rng.uniform(0.1, 2.0, 300)
    tm = cuboid()
    parts = self_gravity(points[:120], masses[:120], tm) + self_gravity(points[120:], masses[120:], tm)
    assert_close(parts, self_gravity(points, masses, tm), 1e-13)


def test_summation_error_does_not_grow_with_the_number_of_sources():
    """Antipodal pairs cancel in the force of a cuboid: what is left is one small source and the rounding of the sum."""
    rng = np.random.default_rng(9)
    half = shell(30_000, rng, 0.2, 0.9)
    masses = rng.uniform(0.5, 1.5, half.shape[0])
    small = np.array([[0.3, 0.2, -0.1]])
    points = np.concatenate([half, small, -half[::-1]])
    tm = cuboid()
    gravity = self_gravity(points, np.concatenate([masses, [1e-3], masses[::-1]]), tm)
    alone = self_gravity(small, [1e-3], tm)
    gross = G_CODATA_2018 * np.sum(masses * np.abs(cuboid_field(half, SIDES).force[:, 0])) * 2
    assert np.abs(gravity.acceleration - alone.acceleration).max() < 4e-16 * gross
    exact = G_CODATA_2018 * np.array(
        [math.fsum(2 * masses * column) for column in cuboid_field(half, SIDES).gamma_lin.reshape(-1, 9).T]
    ).reshape(3, 3)
    np.testing.assert_allclose(
        gravity.gamma_lin - alone.gamma_lin, exact, rtol=0, atol=4e-16 * np.abs(exact).max() * np.sqrt(half.shape[0])
    )


def test_massless_nodes_may_be_anywhere():
    rng = np.random.default_rng(10)
    points, masses = shell(50, rng), rng.uniform(0.1, 2.0, 50)
    with_massless = np.concatenate([points, [[0.0, 0.0, 0.0], [0.02, 0.0, 0.0], [np.nan, 0.0, 0.0]]])
    gravity = self_gravity(with_massless, np.concatenate([masses, np.zeros(3)]), cuboid())
    assert_close(gravity, self_gravity(points, masses, cuboid()), 0.0)
    empty = self_gravity(np.zeros((4, 3)), np.zeros(4), cuboid())
    assert all((getattr(empty, name) == 0).all() and getattr(empty, name).shape in ((3,), (3, 3)) for name in FIELDS)


def test_source_inside_names_node_and_test_mass():
    points = np.array([[0.5, 0.0, 0.0], [1.0, 1.0, 1.0], [0.51, 0.01, 0.0]])
    tm = cuboid(position=(0.5, 0.0, 0.0), name="TM2")
    with pytest.raises(PhysicsError, match=r"'TM2': node 9003 \(2 kg\) lies inside or on .* 0\.0141421 m"):
        self_gravity(points, [0.0, 1.0, 2.0], tm, node_ids=[9001, 9002, 9003])
    with pytest.raises(PhysicsError, match="source 2"):
        self_gravity(points, [0.0, 1.0, 2.0], tm)


@pytest.mark.parametrize(
    ("points", "masses", "fact"),
    [
        ([[1.0, np.nan, 0.0]], [1.0], "node 7 .* no finite position"),
        ([[1.0, 0.0, 0.0]], [np.nan], "mass of node 7 is not finite"),
    ],
)
def test_values_that_are_not_finite_name_the_node(points, masses, fact):
    with pytest.raises(PhysicsError, match=fact):
        self_gravity(points, masses, cuboid(), node_ids=[7])


@pytest.mark.parametrize(
    ("changes", "fact"),
    [
        ({"side_m": [0.1, 0.0, 0.1]}, "edge lengths"),
        ({"mass_kg": 0.0}, "mass"),
        ({"mass_kg": -1.0}, "mass"),
        ({"mass_kg": math.inf}, "mass"),
        ({"mass_kg": math.nan}, "mass"),
        ({"position_m": [0.0, math.nan, 0.0]}, "position_m"),
        ({"axes": np.diag([1.0, 1.0, -1.0])}, "right-handed"),
        ({"axes": np.eye(3) + 1e-6}, "orthonormal"),
    ],
)
def test_impossible_test_mass(changes, fact):
    arguments = {"name": "TM1", "position_m": [0.0, 0.0, 0.0], "side_m": [0.1, 0.1, 0.1], "mass_kg": 1.0}
    with pytest.raises(PhysicsError, match=fact):
        TestMass(**(arguments | changes))
