"""Displacement frames: nothing depends on them but the meaning of component digits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fem_models import ALPHA, bars, rotation_matrix, solve, structure
from shell_models import sheet, shells

from tedm_cli.errors import InputError, PhysicsError
from tedm_cli.fem.structure import Mpc, Rbe2, Rbe3
from tedm_cli.nastran.frames import local_basis


def frames(position, kind):
    """Displacement frames [N, 3, 3]: turned, cylindrical or spherical about an axis beside the model."""
    axes = rotation_matrix((0.2, -0.5, 0.8), 1.1)
    local = (position - [-0.3, 0.2, 0.1]) @ axes
    return axes @ local_basis(kind, local)


def bracket():
    """A bent sheet with a bar, a hub and an interpolated grid; clamped along one side."""
    position, connectivity = sheet((4, 3), (0.2, 0.15), distortion=0.15)
    position[:, 2] = 0.5 * np.maximum(0.0, position[:, 0] - 0.1)
    n = len(position)
    position = np.vstack([position, [0.3, 0.05, 0.1], [0.35, 0.1, 0.2], [0.1, 0.08, 0.05]])
    return structure(
        position,
        quads=shells(connectivity, 2e-3),
        bars=bars([[n, n + 1]], (0.0, 1.0, 0.3), pins=(4,)),
        rbe2=(Rbe2(element_id=7, independent=n, dependents=np.array([16, 17, 18]), components="123"),),
        rbe3=(
            Rbe3(
                element_id=8,
                dependent=n + 2,
                components="123456",
                independents=np.array([4, 5, 6, 9]),
                weights=np.array([1.0, 2.0, 1.0, 0.5]),
                independent_components=("123", "123", "123", "123456"),
            ),
        ),
        held=[(row, "123456") for row in range(3)] + [(n + 1, "123")],
    )


@pytest.mark.parametrize("kind", ["R", "C", "S"])
def test_fem_displacement_frames_change_nothing_where_digits_come_in_threes(kind):
    model = bracket()
    heat = np.linspace(-1.0, 2.0, model.n_grids)
    (plain,), _ = solve(model, heat)
    (framed,), _ = solve(replace(model, displacement_frame=frames(model.position, kind)), heat)
    for part in (slice(0, 3), slice(3, 6)):
        # rounding times the condition of a thin shell
        assert np.abs(framed[:, part] - plain[:, part]).max() < 1e-10 * np.abs(plain[:, part]).max()


def test_fem_motions_are_written_in_the_displacement_frames():
    model = bracket()
    basis = frames(model.position, "C")
    framed = replace(model, displacement_frame=basis)
    motion = np.random.default_rng(1).standard_normal((model.n_grids, 6))
    local = framed.in_displacement_frames(motion)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", basis, local[:, :3]), motion[:, :3], atol=1e-14)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", basis, local[:, 3:]), motion[:, 3:], atol=1e-14)
    assert model.in_displacement_frames(motion) is motion


def test_fem_a_roller_on_a_slope_follows_it():
    # A warm bar along x, hinged at one end and rolling on a plane at an angle at the other: it grows by a T L along the
    # bar and turns until the end is on the slope again, u = (a T L, a T L tan(angle)).
    length, angle, heat = 0.5, 0.4, 3.0
    position = np.array([[0.0, 0.0, 0.0], [length, 0.0, 0.0]])
    slope = np.tile(np.eye(3), (2, 1, 1))
    slope[1] = [[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]]
    model = structure(
        position, bars=bars([[0, 1]], (0.0, 1.0, 0.0)), held=[(0, "1234"), (1, "23")], displacement_frame=slope
    )
    (motion,), _ = solve(model, heat)
    grown = ALPHA * heat * length
    np.testing.assert_allclose(motion[1, :3], [grown, grown * np.tan(angle), 0.0], rtol=1e-12, atol=1e-18)
    assert motion[1, 5] == pytest.approx(grown * np.tan(angle) / length, rel=1e-12)


def test_fem_a_warm_ring_free_to_breathe_grows_radially():
    # A hoop of shells, held against turning and sliding in its cylindrical frames at every grid: u_r = a T r.
    count, radius, heat = 24, 0.2, 2.0
    angle = 2 * np.pi * np.arange(count) / count
    circle = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle], axis=1)
    position = np.vstack([circle, circle + np.array([0.0, 0.0, 0.05])])
    following = np.roll(np.arange(count), -1)
    connectivity = np.stack([np.arange(count), following, following + count, np.arange(count) + count], axis=1)
    model = structure(
        position,
        quads=shells(connectivity, 3e-3),
        held=[(row, "2") for row in range(2 * count)] + [(row, "3") for row in range(count)],
        displacement_frame=local_basis("C", position),
    )
    (motion,), _ = solve(model, heat)
    local = model.in_displacement_frames(motion)
    np.testing.assert_allclose(local[:, 0], ALPHA * heat * radius, rtol=1e-10)
    np.testing.assert_allclose(local[count:, 2], ALPHA * heat * 0.05, rtol=1e-9)
    assert np.abs(local[:, 1]).max() < 1e-18


def test_fem_rigid_element_digits_count_along_the_dependents_frame():
    # A hub guides a grid along the grid's own second axis alone.
    position = np.array([[0.0, 0.0, 0.0], [0.3, 0.1, 0.0], [0.6, 0.0, 0.0]])
    basis = np.tile(np.eye(3), (3, 1, 1))
    basis[1] = rotation_matrix((1.0, 2.0, 0.5), 0.9)
    model = structure(
        position,
        bars=bars([[0, 1], [1, 2]], (0.0, 0.0, 1.0)),
        rbe2=(Rbe2(element_id=3, independent=0, dependents=np.array([1]), components="2"),),
        held=[(0, "123456"), (2, "123456")],
        displacement_frame=basis,
    )
    (motion,), _ = solve(model, [0.0, 5.0, 0.0])
    assert abs(model.in_displacement_frames(motion)[1, 1]) < 1e-18
    assert np.abs(motion[1, :3]).max() > 1e-6


def test_fem_an_equation_among_displacements_holds_and_its_forces_balance():
    # Two parallel rods from a wall, one warm; the equation makes the ends move alike: both by half of the free growth.
    position = np.array([[0.0, 0.0, 0.0], [0.4, 0.0, 0.0], [0.0, 0.1, 0.0], [0.4, 0.1, 0.0]])
    same = Mpc(grids=np.array([1, 3]), components=np.array([1, 1]), coefficients=np.array([2.0, -2.0]))
    model = structure(
        position,
        bars=bars([[0, 1], [2, 3]], (0.0, 0.0, 1.0)),
        mpc=(same,),
        held=[(0, "123456"), (2, "123456")],
    )
    (motion,), _ = solve(model, [0.0, 4.0, 0.0, 0.0])
    assert motion[1, 0] == motion[3, 0]
    assert motion[1, 0] == pytest.approx(ALPHA * 2.0 * 0.4 / 2.0, rel=1e-12)
    twice = replace(model, mpc=(same, same))
    with pytest.raises(InputError, match="depends on both equation 1 of the MPC set and equation 2 of the MPC set"):
        solve(twice, 1.0)


def test_fem_free_motions_are_named_in_any_displacement_frame():
    # Held at one grid in its own turned frame: what is left of the rotations are three.
    model = bracket()
    loose = replace(
        model,
        bars=type(model.bars)(),
        spc_grid=np.array([0, 0, 0]),
        spc_component=np.array([1, 2, 3]),
        displacement_frame=frames(model.position, "S"),
    )
    with pytest.raises(PhysicsError, match=r"3 of 6 rigid-body modes \(rotation about x, rotation about y, rotation"):
        solve(loose, 1.0)
