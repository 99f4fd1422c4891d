"""The four matrices as derivatives of force and torque, by finite differences with their order of convergence."""

import numpy as np
import pytest
from gravity_reference import cross_matrix
from scipy.spatial.transform import Rotation

from tedm_cli.gravity.field import self_gravity
from tedm_cli.gravity.testmass import TestMass

RNG = np.random.default_rng(42)
SOURCES = np.array([[0.06, 0.01, 0.02], [-0.03, 0.045, 0.0], [0.01, -0.02, -0.06], [0.2, 0.1, -0.3]])
MASSES = np.array([0.3, 1.2, 0.7, 40.0])
G = 1.0


def cuboid(position=(0.01, -0.004, 0.002), axes=None):
    return TestMass(
        name="TM1",
        position_m=np.array(position),
        side_m=np.array([0.04, 0.05, 0.03]),
        mass_kg=1.9,
        axes=np.eye(3) if axes is None else axes,
    )


NOMINAL = Rotation.from_rotvec([0.2, -0.4, 0.3]).as_matrix()


def force_and_torque(tm, points=SOURCES):
    """Force and torque per unit test mass and moment of inertia, in the axes of the test mass."""
    gravity = self_gravity(points, MASSES, tm, G=G)
    return np.stack([gravity.acceleration, gravity.angular_acceleration * np.diag(tm.inertia_kg_m2) / tm.mass_kg])


def central_differences(function, step):
    """[2, 3, 3]: (force, torque), component, direction."""
    return np.stack([(function(step * e) - function(-step * e)) / (2 * step) for e in np.eye(3)], axis=-1)


def assert_second_order(function, exact, step):
    """Halving the step quarters the deviation from `exact`, until rounding."""
    errors = [np.abs(central_differences(function, s) - exact).max(axis=(1, 2)) for s in (step, step / 2, step / 4)]
    scale = np.abs(exact).max(axis=(1, 2))
    assert (errors[0] > 1e-9 * scale).all(), "step too small to see the order"
    np.testing.assert_allclose(np.log2(errors[0] / errors[1]), 2.0, atol=0.05)
    np.testing.assert_allclose(np.log2(errors[1] / errors[2]), 2.0, atol=0.05)


def matrices(tm):
    gravity = self_gravity(SOURCES, MASSES, tm, G=G)
    gyration = (np.diag(tm.inertia_kg_m2) / tm.mass_kg)[:, None]
    return (
        np.stack([gravity.gamma_lin, gravity.omega_lin * gyration]),
        np.stack([gravity.gamma_ang, gravity.omega_ang * gyration]),
    )


@pytest.mark.parametrize("axes", [np.eye(3), NOMINAL], ids=["aligned", "rotated"])
def test_translation_of_the_test_mass(axes):
    tm = cuboid(axes=axes)
    linear, _ = matrices(tm)
    # a displacement along the axes of the test mass
    assert_second_order(lambda d: force_and_torque(cuboid(tm.position_m + axes.T @ d, axes)), linear, 1e-3)


@pytest.mark.parametrize("axes", [np.eye(3), NOMINAL], ids=["aligned", "rotated"])
def test_translation_of_the_sources(axes):
    tm = cuboid(axes=axes)
    linear, _ = matrices(tm)
    assert_second_order(lambda d: force_and_torque(tm, SOURCES + axes.T @ d), -linear, 1e-3)


@pytest.mark.parametrize("axes", [np.eye(3), NOMINAL], ids=["aligned", "rotated"])
def test_rotation_of_the_test_mass_in_fixed_axes(axes):
    tm = cuboid(axes=axes)
    _, angular = matrices(tm)

    def rotated(angles):
        turn = Rotation.from_rotvec(angles).as_matrix()
        # the axes of the test mass turn by `turn`, given in its nominal axes; results back in the nominal axes
        turned = cuboid(tm.position_m, (axes.T @ turn).T)
        return force_and_torque(turned) @ turn.T

    assert_second_order(rotated, angular, 4e-3)


def test_rotation_of_the_test_mass_in_its_own_axes():
    """In axes that turn along, the derivatives are those of the sources turning the other way."""
    tm = cuboid()
    _, angular = matrices(tm)
    force, torque = force_and_torque(tm)
    moving = angular + np.stack([cross_matrix(force), cross_matrix(torque)])

    def rotated(angles):
        return force_and_torque(cuboid(tm.position_m, Rotation.from_rotvec(angles).as_matrix().T))

    assert_second_order(rotated, moving, 4e-3)
    # a rigid rotation of all sources about the centre is the opposite motion
    sources = SOURCES - tm.position_m
    per_source = np.zeros((2, 3, 3))
    for source, mass in zip(sources, MASSES, strict=True):
        single = self_gravity(source + tm.position_m, [mass], tm, G=G)
        gyration = (np.diag(tm.inertia_kg_m2) / tm.mass_kg)[:, None]
        per_source -= np.stack([single.gamma_lin, single.omega_lin * gyration]) @ cross_matrix(source)
    np.testing.assert_allclose(per_source, moving, rtol=0, atol=1e-11 * np.abs(moving).max())
