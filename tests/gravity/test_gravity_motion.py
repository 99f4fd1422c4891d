"""All columns of the linearised equations of motion against test masses that are really moved and turned."""

import numpy as np
import pytest
from bodies import notched, tetrahedron
from scipy.spatial.transform import Rotation

from tedm_cli.gravity.body_source import field_of_other_test_mass
from tedm_cli.gravity.compensation import CompensationMass, field_of_compensation_masses
from tedm_cli.gravity.field import self_gravity
from tedm_cli.gravity.motion import linearised_motion, motion_labels
from tedm_cli.gravity.testmass import TestMass

CUBES = [
    TestMass(name=name, position_m=np.array([x, 0.0, 0.0]), side_m=np.full(3, 0.046), mass_kg=1.96)
    for name, x in (("TM1", -0.05), ("TM2", 0.05))
]
SKEWED = [
    TestMass(
        name="TM1",
        position_m=np.array([0.05, 0.01, -0.02]),
        side_m=np.array([0.04, 0.05, 0.03]),
        mass_kg=1.9,
        axes=Rotation.from_rotvec([0.3, -0.2, 0.5]).as_matrix(),
    ),
    TestMass(
        name="TM2",
        position_m=np.array([-0.05, 0.0, 0.03]),
        side_m=np.array([0.03, 0.03, 0.06]),
        mass_kg=2.6,
        axes=Rotation.from_rotvec([-0.1, 0.4, 0.2]).as_matrix(),
    ),
]
OTHERS = [
    TestMass(name=name, position_m=tm.position_m, body=body, mass_kg=tm.mass_kg, axes=tm.axes)
    for name, tm, body in (("TM1", SKEWED[0], notched()), ("TM2", SKEWED[1], tetrahedron()))
]
POINTS = np.array([[0.12, 0.05, 0.01], [0.0, -0.09, 0.06], [-0.11, 0.02, -0.08]])
MASSES = np.array([0.4, 0.7, 0.3])
BLOCK = CompensationMass(
    name="CM", centre_m=np.array([0.0, 0.08, -0.05]), size_m=np.array([0.03, 0.01, 0.02]), mass_kg=0.2
)


def fixed_field(tm):
    return self_gravity(POINTS, MASSES, tm) + field_of_compensation_masses(tm, [BLOCK])[0]


def moved(tm, motion):
    """The test mass displaced and turned by (dr, dα) in its nominal frame."""
    turn = Rotation.from_rotvec(motion[3:]).as_matrix()
    return TestMass(
        name=tm.name,
        position_m=tm.position_m + motion[:3] @ tm.axes,
        body=tm.body,
        mass_kg=tm.mass_kg,
        # rows are the axes: turned in the nominal frame, written in the basic frame
        axes=turn.T @ tm.axes,
    )


def outputs(nominal, motions):
    """F/M and T/I of every moved test mass, in nominal axes and by nominal moments of inertia."""
    bodies = [moved(tm, motion) for tm, motion in zip(nominal, motions, strict=True)]
    rows = []
    for i, (tm, body) in enumerate(zip(nominal, bodies, strict=True)):
        field = fixed_field(body)
        for j, other in enumerate(bodies):
            if j != i:
                field = field + field_of_other_test_mass(body, other, n=10)[0]
        back = tm.axes @ body.axes.T
        rows.append(back @ field.acceleration)
        torque = back @ (body.inertia_kg_m2 @ field.angular_acceleration)
        rows.append(np.linalg.solve(tm.inertia_kg_m2, torque))
    return np.concatenate(rows)


def matrix(nominal):
    mutual = {
        (i, j): field_of_other_test_mass(nominal[i], nominal[j], n=10)[0] for i in (0, 1) for j in (0, 1) if i != j
    }
    return linearised_motion(nominal, [fixed_field(tm) for tm in nominal], mutual), mutual


@pytest.mark.parametrize("nominal", [CUBES, SKEWED, OTHERS], ids=["cubes", "skewed cuboids", "other bodies"])
def test_every_column_is_the_derivative_of_the_motion(nominal):
    found, _ = matrix(nominal)
    step = 1e-4
    for column in range(12):
        motion = np.zeros(12)
        motion[column] = step
        plus, minus = (outputs(nominal, (sign * motion).reshape(2, 6)) for sign in (1.0, -1.0))
        derivative = (plus - minus) / (2.0 * step)
        for rows in (slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 12)):
            # a block is judged by its column, or where that is all but zero by the block
            first = 6 * (rows.start // 6) + rows.start % 6
            kind = slice(6 * (column // 6) + 3 * (column % 6 // 3), 6 * (column // 6) + 3 * (column % 6 // 3) + 3)
            scale = np.abs(found[first : first + 3, kind]).max()
            assert np.abs(derivative[rows] - found[rows, column]).max() < 2e-5 * scale, (column, rows)


def test_equal_aligned_cubes_have_the_published_form():
    """F: Γ_lin (dr_i - dr_j) + Γ_ang (dα_i + dα_j); T: ... + Ω_ang (dα_i - dα_j) - Ω_lin [r_ij]x dα_j."""
    nothing = self_gravity(np.zeros((0, 3)), np.zeros(0), CUBES[0])
    _, mutual = matrix(CUBES)
    found = linearised_motion(CUBES, [nothing, nothing], mutual)
    for i, j, r in ((0, 1, 0.1), (1, 0, -0.1)):
        field, own, other = (
            mutual[i, j],
            found[6 * i : 6 * i + 6, 6 * i :][:, :6],
            found[6 * i : 6 * i + 6, 6 * j :][:, :6],
        )
        cross = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -r], [0.0, r, 0.0]])
        for value, wanted in (
            (own[:3, :3], field.gamma_lin),
            (own[:3, 3:], field.gamma_ang),
            (other[:3, :3], -field.gamma_lin),
            (other[:3, 3:], field.gamma_ang),
            (other[3:, :3], -field.omega_lin),
            (other[3:, 3:], -field.omega_ang - field.omega_lin @ cross),
        ):
            assert np.abs(value - wanted).max() < 1e-9 * np.abs(wanted).max()


def test_moving_everything_together_changes_nothing():
    """Without the structure only the relative position counts: translations of both cancel in every row."""
    nothing = self_gravity(np.zeros((0, 3)), np.zeros(0), CUBES[0])
    _, mutual = matrix(SKEWED)
    found = linearised_motion(SKEWED, [nothing, nothing], mutual)
    translation = np.concatenate([np.concatenate([tm.axes, np.zeros((3, 3))]) for tm in SKEWED])
    assert np.abs(found @ translation).max() < 1e-12 * np.abs(found).max()
    # a common rotation about the origin turns the forces with it: F/M and T/I follow as vectors
    rotation = np.concatenate(
        [np.concatenate([tm.axes @ np.cross(np.eye(3), tm.position_m).T, tm.axes]) for tm in SKEWED]
    )
    for i, tm in enumerate(SKEWED):
        field = mutual[i, 1 - i]
        force, torque = (
            tm.axes.T @ field.acceleration,
            tm.axes.T @ (field.angular_acceleration * np.diag(tm.inertia_kg_m2)),
        )
        wanted = np.concatenate(
            [
                tm.axes @ np.cross(np.eye(3), force).T,
                (tm.axes @ np.cross(np.eye(3), torque).T) / np.diag(tm.inertia_kg_m2)[:, None],
            ]
        )
        turned = found[6 * i : 6 * i + 6] @ rotation
        for rows in (slice(0, 3), slice(3, 6)):
            assert np.abs(turned[rows] - wanted[rows]).max() < 1e-9 * np.abs(found[6 * i : 6 * i + 6][rows, 3:6]).max()


def test_labels():
    rows, columns = motion_labels(CUBES)
    assert rows[3:8] == ["TM1_omegadot_x", "TM1_omegadot_y", "TM1_omegadot_z", "TM2_a_x", "TM2_a_y"]
    assert columns[3:8] == ["TM1_theta", "TM1_eta", "TM1_phi", "TM2_x", "TM2_y"]
