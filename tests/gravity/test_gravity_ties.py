"""Compensation masses that follow grids: the field of the block that has really moved, rigid motions, offset masses."""

import numpy as np
import pytest
from mass_models import model
from scipy.spatial.transform import Rotation

from tedm_cli.gravity.compensation import (
    CompensationMass,
    block_points,
    field_of_compensation_masses,
    graded_cells,
)
from tedm_cli.gravity.field import SelfGravity
from tedm_cli.gravity.masses import PointMasses
from tedm_cli.gravity.structure import structure_gravity
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.gravity.ties import follower, needs_rotations, tied_operator

SKEW = Rotation.from_rotvec([0.3, -0.2, 0.5]).as_matrix()
TM = TestMass(
    name="TM1",
    position_m=np.array([0.1, 0.0, 0.02]),
    side_m=np.array([0.046, 0.04, 0.05]),
    mass_kg=1.96,
    axes=Rotation.from_rotvec([-0.2, 0.4, 0.1]).as_matrix(),
)
# long, turned, and some 10 mm from the test mass
LONG = CompensationMass(
    name="CM1", centre_m=np.array([0.16, 0.02, 0.03]), size_m=np.array([0.06, 0.01, 0.012]), mass_kg=0.14, axes=SKEW
)
GRIDS = np.array([[0.2, 0.05, 0.0], [0.15, 0.1, 0.01], [0.21, -0.02, 0.07], [0.18, 0.0, -0.05]])
SETS = {"grid": [0], "line": [0, 4], "set": [0, 1, 2, 3]}
PLACES = np.vstack([GRIDS, GRIDS[0] + 1.5 * (GRIDS[1] - GRIDS[0])])


def field(block: CompensationMass, tm: TestMass = TM) -> SelfGravity:
    return field_of_compensation_masses(tm, [block], tolerance=1e-11)[2][0].field


def moved(block: CompensationMass, t: np.ndarray, turn: np.ndarray) -> CompensationMass:
    """The block shifted, and turned about its centre."""
    turned = Rotation.from_rotvec(turn).as_matrix()
    return CompensationMass(
        name=block.name,
        centre_m=block.centre_m + t,
        size_m=block.size_m,
        mass_kg=block.mass_kg,
        axes=block.axes @ turned.T,
    )


def change(block: CompensationMass, nodes: list[int], u: np.ndarray, theta: np.ndarray, tm: TestMass = TM):
    """Of acceleration and angular acceleration [6], by motions [N, 3] of the grids: -G u."""
    rows = np.array(nodes)
    g = tied_operator(tm, [(block, field(block, tm), rows)], PLACES, np.arange(len(PLACES)))
    linear = np.einsum("qrnc,nc->qr", g.operator, u[g.row])
    return -(linear + np.einsum("qrnc,nc->qr", g.rotation, theta[g.lever])).ravel()


def accelerations(gravity: SelfGravity) -> np.ndarray:
    return np.concatenate([gravity.acceleration, gravity.angular_acceleration])


@pytest.mark.parametrize("nodes", SETS.values(), ids=SETS)
def test_the_operator_is_the_derivative_of_the_field_of_the_block_that_moves(nodes):
    """Central differences, fourth order, of the exact field of a block at its moved place and in its moved attitude."""
    rng = np.random.default_rng(3)
    for _ in range(3):
        u, theta = rng.normal(size=(2, len(PLACES), 3))
        motion = follower(PLACES[nodes], LONG.centre_m).motion(u[None, nodes], theta[None, nodes])[0]
        steps = np.array([-2.0, -1.0, 1.0, 2.0]) * 2e-5
        values = [accelerations(field(moved(LONG, s * motion[:3], s * motion[3:]))) for s in steps]
        wanted = np.array([1.0, -8.0, 8.0, -1.0]) @ np.array(values) / (12.0 * 2e-5)
        found = change(LONG, nodes, u, theta)
        for part in (slice(3), slice(3, 6)):
            assert np.abs(found[part] - wanted[part]).max() < 2e-9 * np.abs(wanted[part]).max()


def test_one_grid_moves_its_block_by_its_translation_and_its_rotation_about_it():
    rng = np.random.default_rng(5)
    u, theta = rng.normal(size=(2, 7, 1, 3))
    found = follower(PLACES[:1], LONG.centre_m).motion(u, theta)
    np.testing.assert_allclose(found[:, :3], u[:, 0] + np.cross(theta[:, 0], LONG.centre_m - PLACES[0]), atol=1e-15)
    np.testing.assert_array_equal(found[:, 3:], theta[:, 0])


def test_the_own_rotation_of_a_long_block_is_seen_and_that_of_a_far_cube_is_not():
    """About its centre: a block of another shape at the same place feels it, and a cube has no quadrupole to turn."""
    turn = np.zeros((len(PLACES), 3))
    turn[0] = [0.2, -1.0, 0.7]
    still = np.cross(turn[0], PLACES[0] - LONG.centre_m)  # the grid moves so that the centre does not
    u = np.zeros_like(turn)
    u[0] = still
    place = np.array([1.1, 0.2, 0.3])
    u_far = np.zeros_like(turn)
    u_far[0] = np.cross(turn[0], PLACES[0] - place)
    long_far = CompensationMass(name="L", centre_m=place, size_m=np.array([0.1, 0.02, 0.02]), mass_kg=0.14)
    cube_far = CompensationMass(name="C", centre_m=place, size_m=np.full(3, 0.02 * 5 ** (1 / 3)), mass_kg=0.14)
    shifted = np.abs(change(LONG, [0], u + 0.01, 0.0 * turn)[:3]).max()
    assert np.abs(change(LONG, [0], u, turn)[:3]).max() > 0.1 * shifted
    long, cube = (np.abs(change(b, [0], u_far, turn)[:3]).max() for b in (long_far, cube_far))
    assert cube < 1e-3 * long


@pytest.mark.parametrize("nodes", SETS.values(), ids=SETS)
def test_a_rigid_motion_of_the_grids_is_that_of_the_block(nodes):
    rng = np.random.default_rng(7)
    t, turn = rng.normal(size=(2, 3))
    u = t + np.cross(turn, PLACES)
    found = follower(PLACES[nodes], LONG.centre_m).motion(u[None, nodes], np.tile(turn, (1, len(nodes), 1)))[0]
    wanted = np.concatenate([t + np.cross(turn, LONG.centre_m), turn])
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-12)
    assert needs_rotations(PLACES[nodes]) == (len(nodes) < 3)
    # and so all ties agree
    theta = np.tile(turn, (len(PLACES), 1))
    np.testing.assert_allclose(change(LONG, nodes, u, theta), change(LONG, [0], u, theta), rtol=1e-11)


def test_the_fit_of_a_set_is_the_least_squares_one():
    """Against a general solver, for displacements that are no rigid motion; rotations of the grids do not matter."""
    rng = np.random.default_rng(9)
    u = rng.normal(size=(4, 3))
    arm = GRIDS - LONG.centre_m
    rows = [np.hstack([np.eye(3), np.cross(np.eye(3), r).T]) for r in arm]  # θ x r = sum of θ_i e_i x r
    wanted = np.linalg.lstsq(np.vstack(rows), u.ravel(), rcond=None)[0]
    found = follower(GRIDS, LONG.centre_m).motion(u[None], rng.normal(size=(1, 4, 3)))[0]
    np.testing.assert_allclose(found, wanted, rtol=1e-12)


@pytest.mark.parametrize(
    ("places", "needs"),
    [
        (GRIDS[:1], True),
        (GRIDS[:2], True),
        (np.outer([0.0, 1.0, 2.5], [0.3, 0.4, 0.1]), True),
        (GRIDS[:3], False),
        (np.repeat(GRIDS[:1], 3, axis=0), True),  # three grids at one place
        (np.array([[0.0, 0, 0], [1.0, 0, 0], [0.5, 1e-5, 0]]), True),  # 10 um off a line of a metre
        (np.array([[0.0, 0, 0], [1.0, 0, 0], [0.5, 1e-2, 0]]), False),
    ],
)
def test_which_sets_define_their_rotation(places, needs):
    assert needs_rotations(places + 5.0) == needs


def test_everything_moved_together_changes_nothing():
    """Block, grids and test mass by one rigid motion: what the block's motion does, the test mass's undoes."""
    rng = np.random.default_rng(11)
    t, turn = 1e-6 * rng.normal(size=(2, 3))
    by_block = change(LONG, [0, 1, 2, 3], t + np.cross(turn, PLACES), np.zeros_like(PLACES))
    gravity = field(LONG)
    at = TM.axes @ (t + np.cross(turn, TM.position_m))
    about = TM.axes @ turn
    by_mass = np.concatenate(
        [gravity.gamma_lin @ at + gravity.gamma_ang @ about, gravity.omega_lin @ at + gravity.omega_ang @ about]
    )
    # both in axes that stay: force and torque have turned with everything
    inertia = TM.inertia_kg_m2
    turned = np.concatenate(
        [
            np.cross(about, gravity.acceleration),
            np.linalg.solve(inertia, np.cross(about, inertia @ gravity.angular_acceleration)),
        ]
    )
    rest = by_block + by_mass - turned
    for part in (slice(3), slice(3, 6)):
        assert np.abs(rest[part]).max() < 1e-8 * np.abs(by_block[part]).max()


def by_offset_masses(points: np.ndarray, masses: np.ndarray, u: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """-G u [6] of concentrated masses on levers of the first grid, by the way of the structure's own masses."""
    riders = PointMasses(
        name=[f"CONM2 {i}" for i in range(len(masses))],
        mass=masses,
        node=np.zeros(len(masses), dtype=np.int64),
        offset=points - PLACES[0],
    )
    g = structure_gravity(model(PLACES, [], points=riders), TM, tolerance=1e-9)
    turned = np.einsum("qrnc,nc->qr", g.rotation, theta[[0]])
    return -(np.einsum("qrnc,nc->qr", g.operator, u) + turned).ravel()


def test_a_tied_block_is_many_offset_masses_at_its_quadrature_points():
    u, theta = np.random.default_rng(13).normal(size=(2, len(PLACES), 3))
    offset = by_offset_masses(*block_points(*graded_cells(TM, LONG), LONG, 10), u, theta)
    block = change(LONG, [0], u, theta)
    for part in (slice(3), slice(3, 6)):
        assert np.abs(offset[part] - block[part]).max() < 1e-10 * np.abs(block[part]).max()


def test_blocks_on_the_same_grids_add_up():
    """One on a set, one on a grid of it, one on a line through it: rows of the sum are those of each, summed."""
    u, theta = np.random.default_rng(19).normal(size=(2, len(PLACES), 3))
    other = moved(LONG, np.array([0.0, 0.05, 0.02]), np.array([0.3, 0.0, 0.0]))
    tied = [(LONG, [0, 1, 2, 3]), (other, [0]), (LONG, [0, 4])]
    g = tied_operator(TM, [(b, field(b), np.array(nodes)) for b, nodes in tied], PLACES, np.arange(len(PLACES)))
    assert (g.row.tolist(), g.lever.tolist()) == ([0, 1, 2, 3, 4], [0, 4])
    found = np.einsum("qrnc,nc->qr", g.operator, u[g.row]) + np.einsum("qrnc,nc->qr", g.rotation, theta[g.lever])
    wanted = sum(change(b, nodes, u, theta) for b, nodes in tied)
    np.testing.assert_allclose(-found.ravel(), wanted, rtol=1e-12)


@pytest.mark.parametrize(("shape", "order"), [([1.0, 1.0, 1.0], 4), ([2.0, 1.0, 0.5], 2)], ids=["cube", "brick"])
def test_a_tied_block_that_shrinks_becomes_an_offset_mass(shape, order):
    """The difference is the block's quadrupole, of second order in its size; a cube has none, and fourth is left."""
    rng = np.random.default_rng(17)
    u, theta = rng.normal(size=(2, len(PLACES), 3))
    place = np.array([0.2, 0.06, 0.05])
    point = by_offset_masses(place[None], np.array([0.1]), u, theta)[:3]
    errors = []
    for size in (0.04, 0.02, 0.01):
        block = CompensationMass(name="B", centre_m=place, size_m=size * np.array(shape), mass_kg=0.1, axes=SKEW)
        errors.append(np.abs(change(block, [0], u, theta)[:3] - point).max() / np.abs(point).max())
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(slopes, order, atol=0.35)
    assert errors[-1] < 1e-2
