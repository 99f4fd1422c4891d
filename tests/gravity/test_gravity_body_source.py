"""Two test masses: the published table, Newton's third law, and the error of the quadrature."""

import numpy as np
import pytest
from gravity_reference import cross_matrix
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from tedm_cli.errors import PhysicsError
from tedm_cli.gravity.body_source import body_sources, field_of_other_test_mass
from tedm_cli.gravity.testmass import TestMass, touch

G_1998 = 6.673e-11


def cube(name, x, side=0.04605, mass=1.935):
    return TestMass(name=name, position_m=np.array([x, 0.0, 0.0]), side_m=np.full(3, side), mass_kg=mass)


# Published: TM1 at +x of TM2, 376 mm apart (Montemurro 2004, section 6.2.3). Value, unit of its last printed digit.
TABLE = {
    "a_x": (-9.1330e-10, 1e-14),
    "gamma_lin_xx": (4.8576e-9, 1e-13),
    "gamma_lin_yy": (-2.4288e-9, 1e-13),
    "gamma_lin_zz": (-2.4288e-9, 1e-13),
    "omega_lin_yz": (8.4477e-11, 1e-15),
    "omega_lin_zy": (-8.4477e-11, 1e-15),
    "gamma_ang_yz": (-2.9857e-14, 1e-18),
    "gamma_ang_zy": (2.9857e-14, 1e-18),
    "omega_ang_xx": (-1.27e-16, 1e-18),
    "omega_ang_yy": (3.1770e-11, 1e-15),
    "omega_ang_zz": (3.1770e-11, 1e-15),
}
# The inputs (side 46.05 mm, mass 1.935 kg, 376 mm) are inferred from the table, to some five digits: with them the
# printed 3.1770 comes out as 3.17693, all else to half a digit. A side longer by 0.1 µm brings it to 0.58 of a digit.
WITHIN = {"omega_ang_yy": 0.75, "omega_ang_zz": 0.75}


def entries(gravity):
    found = {"a_x": gravity.acceleration[0]}
    for name in ("gamma_lin", "omega_lin", "gamma_ang", "omega_ang"):
        for i, row in enumerate("xyz"):
            for j, column in enumerate("xyz"):
                found[f"{name}_{row}{column}"] = getattr(gravity, name)[i, j]
    return found


def test_published_table_for_both_test_masses():
    tm1, tm2 = cube("TM1", 0.188), cube("TM2", -0.188)
    first, _ = field_of_other_test_mass(tm1, tm2, G_1998)
    second, _ = field_of_other_test_mass(tm2, tm1, G_1998)
    for name, (value, digit) in TABLE.items():
        # on the other test mass everything odd in the separation changes sign
        sign = -1 if name == "a_x" or name.startswith(("omega_lin", "gamma_ang")) else 1
        limit = WITHIN.get(name, 0.5) * digit
        assert abs(entries(first)[name] - value) <= limit, name
        assert abs(entries(second)[name] - sign * value) <= limit, name
    # what the table prints as zero vanishes by symmetry
    for gravity in (first, second):
        assert np.abs(gravity.angular_acceleration).max() < 1e-12 * np.abs(gravity.omega_ang).max()
        for name, found in entries(gravity).items():
            if name not in TABLE:
                assert abs(found) < 1e-12 * np.abs(getattr(gravity, name[:-3])).max(), name


def test_quadrature_has_the_mass_and_moments_of_the_body():
    tm = TestMass(
        name="TM1",
        position_m=np.array([0.1, 0.2, 0.3]),
        side_m=np.array([0.04, 0.05, 0.03]),
        mass_kg=1.9,
        axes=Rotation.from_rotvec([0.3, -0.2, 0.5]).as_matrix(),
    )
    points, masses = body_sources(tm, 3)
    assert masses.sum() == pytest.approx(tm.mass_kg, rel=1e-14)
    np.testing.assert_allclose(masses @ points / tm.mass_kg, tm.position_m, rtol=1e-14)
    local = (points - tm.position_m) @ tm.axes.T
    squares = np.einsum("n,ni,nj->ij", masses, local, local)
    np.testing.assert_allclose(np.trace(squares) * np.eye(3) - squares, tm.inertia_kg_m2, atol=1e-17)


def test_error_estimate_bounds_the_error_and_falls_exponentially():
    tm, other = cube("TM1", 0.05), cube("TM2", -0.05)
    exact, _ = field_of_other_test_mass(tm, other, n=16)
    estimates = []
    for n in (4, 6, 8, 10):
        gravity, estimate = field_of_other_test_mass(tm, other, n=n)
        for name in ("acceleration", "gamma_lin", "omega_lin", "gamma_ang", "omega_ang"):
            reference = getattr(exact, name)
            assert np.abs(getattr(gravity, name) - reference).max() < estimate * np.abs(reference).max(), name
        estimates.append(estimate)
    assert (np.array(estimates[1:]) < 0.1 * np.array(estimates[:-1])).all()
    # at the published distance the default is at rounding
    assert field_of_other_test_mass(cube("TM1", -0.188), cube("TM2", 0.188))[1] < 1e-13


def test_action_and_reaction_of_skewed_test_masses():
    """Newton's third law: forces are opposite, and torques about one common point too."""
    first = TestMass(
        name="TM1",
        position_m=np.array([0.05, 0.01, -0.02]),
        side_m=np.array([0.04, 0.05, 0.03]),
        mass_kg=1.9,
        axes=Rotation.from_rotvec([0.3, -0.2, 0.5]).as_matrix(),
    )
    second = TestMass(
        name="TM2",
        position_m=np.array([-0.05, 0.0, 0.03]),
        side_m=np.array([0.03, 0.03, 0.06]),
        mass_kg=2.6,
        axes=Rotation.from_rotvec([-0.1, 0.4, 0.2]).as_matrix(),
    )
    forces, torques = [], []
    for tm, other in ((first, second), (second, first)):
        gravity, _ = field_of_other_test_mass(tm, other, n=14)
        force = tm.axes.T @ gravity.acceleration * tm.mass_kg
        torque = tm.axes.T @ (gravity.angular_acceleration * np.diag(tm.inertia_kg_m2))
        forces.append(force)
        torques.append(torque + np.cross(tm.position_m, force))
    assert np.abs(forces[0] + forces[1]).max() < 1e-11 * np.abs(forces[0]).max()
    own = np.abs(torques[0] - np.cross(first.position_m, forces[0])).max()
    assert np.abs(torques[0] + torques[1]).max() < 1e-9 * own


def test_motion_of_the_source_test_mass():
    """F: Γ_lin (dr1 - dr2) + Γ_ang (dα1 + dα2); T: Ω_lin (dr1 - dr2) + Ω_ang (dα1 - dα2) - Ω_lin [r]x dα2."""
    tm, other = cube("TM1", -0.1), cube("TM2", 0.1)
    gravity, _ = field_of_other_test_mass(tm, other)
    separation = other.position_m - tm.position_m
    step = 1e-4

    def moved(sign, axis, kind):
        unit = sign * step * np.eye(3)[axis]
        axes = Rotation.from_rotvec(unit).as_matrix().T if kind == "turn" else np.eye(3)
        place = other.position_m + (unit if kind == "shift" else 0.0)
        image = TestMass(name="TM2", position_m=place, side_m=other.side_m, mass_kg=other.mass_kg, axes=axes)
        result, _ = field_of_other_test_mass(tm, image)
        return np.concatenate([result.acceleration, result.angular_acceleration])

    for kind, force_matrix, torque_matrix in (
        ("shift", -gravity.gamma_lin, -gravity.omega_lin),
        ("turn", gravity.gamma_ang, -gravity.omega_ang - gravity.omega_lin @ cross_matrix(separation)),
    ):
        derivative = np.stack([(moved(1, n, kind) - moved(-1, n, kind)) / (2 * step) for n in range(3)], axis=-1)
        for found, expected in ((derivative[:3], force_matrix), (derivative[3:], torque_matrix)):
            assert np.abs(found - expected).max() < 1e-5 * np.abs(expected).max(), kind


def brick(name, position, side, rotation=(0.0, 0.0, 0.0)):
    axes = Rotation.from_rotvec(rotation).as_matrix()
    return TestMass(name=name, position_m=np.array(position), side_m=np.array(side), mass_kg=1.0, axes=axes)


def test_overlapping_test_masses_are_an_error():
    with pytest.raises(PhysicsError, match=r"'TM1' and 'TM2' overlap or touch: their centres are 0.04 m apart"):
        field_of_other_test_mass(cube("TM1", 0.0), cube("TM2", 0.04))
    # a needle through the body between the Gauss points of both
    needle = brick("N", [0.0, 0.0, 0.0], [1.0, 1e-6, 1e-6])
    with pytest.raises(PhysicsError, match="'TM1' and 'N'"):
        field_of_other_test_mass(cube("TM1", 0.0), needle)
    with pytest.raises(PhysicsError, match="'N' and 'TM1'"):
        field_of_other_test_mass(needle, cube("TM1", 0.0))


@pytest.mark.parametrize("gap", [-1e-6, 1e-6])
@pytest.mark.parametrize(
    ("direction", "rotation", "distance"),
    [
        # face on face; a cube turned by 45 degrees, edge on face; corner on face
        ([1.0, 0.0, 0.0], [0.0, 0.0, 0.0], 1.0),
        ([1.0, 0.0, 0.0], [0.0, 0.0, np.pi / 4], 0.5 + np.sqrt(0.5)),
        ([0.0, 0.0, 1.0], np.arctan(np.sqrt(2.0)) * np.array([1.0, -1.0, 0.0]) / np.sqrt(2.0), 0.5 + np.sqrt(0.75)),
    ],
)
def test_overlap_begins_at_contact(direction, rotation, distance, gap):
    first, second = (
        brick("A", [0, 0, 0], [1, 1, 1]),
        brick("B", (distance + gap) * np.array(direction), [1, 1, 1], rotation),
    )
    assert touch(first, second) == touch(second, first) == (gap < 0)


@pytest.mark.parametrize("gap", [-1e-6, 1e-6])
def test_crossed_edges_are_separated_by_their_common_normal_alone(gap):
    """Two cubes edge against edge: no face of either separates them."""
    # a vertical edge of the first at x = √½, a horizontal one of the second facing it
    first = brick("A", [0, 0, 0], [1, 1, 1], [0.0, 0.0, np.pi / 4])
    second = brick("B", [np.sqrt(2.0) + gap, 0, 0], [1, 1, 1], [0.0, np.pi / 4, 0.0])
    assert touch(first, second) == touch(second, first) == (gap < 0)


@settings(deadline=None, max_examples=60, derandomize=True)
@given(st.integers(0, 10_000))
def test_overlap_against_linear_programming(seed):
    """Two convex bodies share a point if and only if a convex combination of the corners of each meets the other's."""
    rng = np.random.default_rng(seed)
    pair = [brick(name, rng.normal(size=3) * 0.5, rng.uniform(0.1, 1.2, 3), rng.normal(size=3)) for name in ("A", "B")]
    signs = np.array(list(np.ndindex(2, 2, 2))) - 0.5
    corners = [tm.position_m + (signs * tm.side_m) @ tm.axes for tm in pair]
    equal = np.vstack([np.hstack([corners[0].T, -corners[1].T]), np.repeat(np.eye(2), 8, axis=1)])
    program = linprog(np.zeros(16), A_eq=equal, b_eq=[0.0, 0.0, 0.0, 1.0, 1.0])
    assert touch(*pair) == (program.status == 0)
