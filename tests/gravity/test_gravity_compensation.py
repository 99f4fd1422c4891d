"""Compensation masses: the third law at a small gap, honest error estimates, and overlaps of any kind refused."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tedm_cli.errors import PhysicsError
from tedm_cli.gravity.compensation import CompensationMass, block_points, field_of_compensation_masses, graded_cells
from tedm_cli.gravity.field import SelfGravity, self_gravity
from tedm_cli.gravity.testmass import TestMass

SKEW = Rotation.from_rotvec([0.3, -0.2, 0.5]).as_matrix()


def cube(axes=None):
    axes = np.eye(3) if axes is None else axes
    return TestMass(
        name="TM1", position_m=np.array([0.1, 0.0, 0.02]), side_m=np.full(3, 0.046), mass_kg=1.96, axes=axes
    )


def block(centre, size, axes=None, mass=0.5):
    axes = np.eye(3) if axes is None else axes
    return CompensationMass(name="CM1", centre_m=np.array(centre), size_m=np.array(size), mass_kg=mass, axes=axes)


NEAR = block([0.1 + 0.023 + 0.003 + 0.006, 0.004, 0.02], [0.012, 0.03, 0.02])  # 3 mm from a face
TURNED = block([0.1 + 0.05, 0.03, 0.0], [0.02, 0.04, 0.01], SKEW)


@pytest.mark.parametrize("mass", [NEAR, TURNED], ids=["3 mm gap", "turned"])
def test_action_and_reaction(mass):
    """The block pulls on the test mass as the test mass on the block: two quadratures over different bodies."""
    tm = cube()
    gravity, _, _ = field_of_compensation_masses(tm, [mass])
    as_test_mass = TestMass(
        name="B", position_m=mass.centre_m, side_m=mass.size_m, mass_kg=mass.mass_kg, axes=mass.axes
    )
    as_block = CompensationMass(name="T", centre_m=tm.position_m, size_m=tm.side_m, mass_kg=tm.mass_kg)
    back, _, _ = field_of_compensation_masses(as_test_mass, [as_block])
    force = gravity.acceleration * tm.mass_kg
    force_back = mass.axes.T @ back.acceleration * mass.mass_kg
    assert np.abs(force + force_back).max() < 1e-9 * np.abs(force).max()
    torque = gravity.angular_acceleration * np.diag(tm.inertia_kg_m2) + np.cross(tm.position_m, force)
    torque_back = mass.axes.T @ (back.angular_acceleration * np.diag(as_test_mass.inertia_kg_m2))
    torque_back = torque_back + np.cross(mass.centre_m, force_back)
    assert np.abs(torque + torque_back).max() < 1e-9 * np.linalg.norm(tm.position_m) * np.abs(force).max()
    # the gradient of a body is symmetric in the two as well: moving one is moving the other back
    gamma, gamma_back = gravity.gamma_lin * tm.mass_kg, mass.axes.T @ back.gamma_lin @ mass.axes * mass.mass_kg
    assert np.abs(gamma - gamma_back).max() < 1e-9 * np.abs(gamma).max()


@pytest.mark.parametrize("mass", [NEAR, TURNED], ids=["3 mm gap", "turned"])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7])
def test_estimate_bounds_the_error_and_keeps_the_tolerance(mass, tolerance):
    tm = cube(SKEW if mass is TURNED else None)
    exact, _, _ = field_of_compensation_masses(tm, [mass], tolerance=1e-11)
    gravity, error, quadrature = field_of_compensation_masses(tm, [mass], tolerance=tolerance)
    assert quadrature[0].error == error <= tolerance
    for name in ("acceleration", "gamma_lin", "omega_lin", "gamma_ang", "omega_ang"):
        reference = getattr(exact, name)
        assert np.abs(getattr(gravity, name) - reference).max() <= error * np.abs(reference).max(), name


def test_cells_fill_the_block():
    centre, half = graded_cells(cube(), NEAR)
    assert len(centre) > 50
    points, masses = block_points(centre, half, NEAR, 3)
    assert masses.sum() == pytest.approx(NEAR.mass_kg, rel=1e-13)
    np.testing.assert_allclose(masses @ points / NEAR.mass_kg, NEAR.centre_m, rtol=1e-13)
    local = points - NEAR.centre_m
    np.testing.assert_allclose(
        np.einsum("n,ni,nj->ij", masses, local, local),
        NEAR.mass_kg / 12.0 * np.diag(NEAR.size_m**2),
        atol=1e-13 * NEAR.mass_kg * 1e-3,
    )


def test_blocks_add_up_and_opposite_blocks_cancel_at_rest():
    tm = cube()
    offset = np.array([0.032, 0.004, 0.0])
    pair = [block(tm.position_m + sign * offset, [0.012, 0.03, 0.02]) for sign in (1, -1)]
    one, _, _ = field_of_compensation_masses(tm, pair[:1])
    both, error, quadrature = field_of_compensation_masses(tm, pair)
    assert len(quadrature) == 2
    assert np.abs(both.acceleration).max() < 1e-9 * np.abs(one.acceleration).max()
    assert np.abs(both.gamma_lin - 2.0 * one.gamma_lin).max() < 1e-9 * np.abs(one.gamma_lin).max()
    assert error <= 1e-9  # of the sum of magnitudes: it does not grow where blocks cancel


def test_far_block_is_a_point():
    tm = cube()
    far = block([40.0, -30.0, 20.0], [0.05, 0.05, 0.05], SKEW)
    gravity, _, quadrature = field_of_compensation_masses(tm, [far])
    point: SelfGravity = self_gravity([far.centre_m], [far.mass_kg], tm)
    assert quadrature[0].cells == 1
    np.testing.assert_allclose(gravity.acceleration, point.acceleration, rtol=1e-11)
    np.testing.assert_allclose(gravity.gamma_lin, point.gamma_lin, rtol=1e-10)


@pytest.mark.parametrize(
    "mass",
    [
        block([0.1, 0.0, 0.02], [0.01, 0.01, 0.01]),  # inside
        block([0.1, 0.0, 0.02], [0.2, 0.001, 0.001]),  # a rod through it, no corner of either in the other
        block([0.1 + 0.023 + 0.005, 0.0, 0.02], [0.01, 0.01, 0.01]),  # face on face
        # edge across edge, no corner of either inside the other
        block(
            [0.1 + 0.0229, 0.0229, 0.02],
            [0.01, 0.01, 0.1],
            (Rotation.from_rotvec([0, 0, np.pi / 4]) * Rotation.from_rotvec([0, np.pi / 2, 0])).as_matrix().T,
        ),
    ],
    ids=["inside", "rod", "touching", "edges"],
)
def test_overlap_is_refused(mass):
    with pytest.raises(PhysicsError, match="'CM1' touches or overlaps test mass 'TM1'"):
        field_of_compensation_masses(cube(), [mass])


def test_a_block_whose_bounding_box_overlaps_is_not_refused():
    """Turned by 45 degrees, beside the edge of the cube: apart along the diagonal alone."""
    turn = Rotation.from_rotvec([0, 0, np.pi / 4]).as_matrix().T
    tm = cube()
    corner = tm.position_m + np.array([0.023, 0.023, 0.0])
    diagonal = np.array([1.0, 1.0, 0.0]) / np.sqrt(2.0)
    plate = block(corner + 0.006 * diagonal, [0.01, 0.08, 0.01], turn)
    gravity, error, _ = field_of_compensation_masses(tm, [plate], tolerance=1e-6)
    assert error <= 1e-6
    assert gravity.acceleration[0] == pytest.approx(gravity.acceleration[1], rel=1e-9)


def test_a_block_too_close_to_integrate_says_so():
    close = block([0.1 + 0.023 + 1e-5 + 0.01, 0.0, 0.02], [0.02, 0.04, 0.04])
    with pytest.raises(PhysicsError, match="1e-05 m from test mass 'TM1', too close"):
        field_of_compensation_masses(cube(), [close])
