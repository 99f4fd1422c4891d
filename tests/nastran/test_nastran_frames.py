"""Displacements in rectangular, cylindrical and spherical frames come back in the basic frame."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from op2_records import edit, rename
from rod_model import one_load, read, write_deck

from tedm_cli.errors import InputError
from tedm_cli.nastran.displacements import unit_load_displacements
from tedm_cli.nastran.frames import local_basis
from tedm_cli.nastran.op2.writer import write_op2

Array = np.ndarray
SINGLE = 2e-7  # of the vector: three components, each rounded to 24 bits

# id: type, reference frame, three points in coordinates of the reference frame (degrees). Nested, moved and turned.
FRAMES = {
    1: ("R", 0, ((0.3, -0.2, 0.1), (0.5, 0.4, 0.9), (1.3, 0.1, 0.2))),
    2: ("C", 0, ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))),
    3: ("S", 0, ((0.1, 0.2, -0.3), (0.4, 0.2, 0.6), (0.9, -0.5, 0.2))),
    4: ("C", 1, ((0.2, 0.1, 0.4), (0.1, 0.9, 0.3), (0.8, 0.2, 0.1))),
    5: ("S", 4, ((0.5, 30.0, 0.2), (0.7, 75.0, 0.9), (0.9, -40.0, 0.1))),
    6: ("R", 5, ((0.6, 50.0, 20.0), (0.9, 80.0, 65.0), (0.4, 20.0, 140.0))),
    7: ("S", 6, ((-0.2, 0.3, 0.1), (-0.3, 0.2, 0.9), (0.5, 0.4, 0.2))),
    8: ("S", 0, ((0.5, -0.25, 0.125), (0.5, -0.25, 1.0), (0.5, 1.0, 0.125))),
    9: ("C", 0, ((0.5, -0.25, 0.125), (1.0, -0.25, 0.125), (0.5, -1.0, 0.125))),
}
CARDS = "\n".join(
    f"CORD2{kind},{cid},{rid},"
    + ",".join(f"{x}" for x in (*points[0], *points[1]))
    + "\n,"
    + ",".join(f"{x}" for x in points[2])
    for cid, (kind, rid, points) in FRAMES.items()
)


def cartesian(kind: str, q: Array) -> Array:
    """Place of the coordinates `q` (lengths and degrees) in the frame's own Cartesian axes."""
    if kind == "R":
        return np.array(q, dtype=float)
    if kind == "C":
        turn = q[0] * np.exp(1j * np.radians(q[1]))
        return np.array([turn.real, turn.imag, q[2]])
    rim = q[0] * np.sin(np.radians(q[1])) * np.exp(1j * np.radians(q[2]))
    return np.array([rim.real, rim.imag, q[0] * np.cos(np.radians(q[1]))])


@cache
def frame(cid: int) -> tuple[str, Array, Array]:
    """Type, origin and axes (columns) in the basic frame."""
    if cid == 0:
        return "R", np.zeros(3), np.eye(3)
    kind, rid, points = FRAMES[cid]
    a, b, c = (place(rid, np.array(p)) for p in points)
    z = (b - a) / np.linalg.norm(b - a)
    y = np.cross(z, c - a)
    y /= np.linalg.norm(y)
    return kind, a, np.stack([np.cross(y, z), y, z], axis=1)


def place(cid: int, q: Array) -> Array:
    kind, origin, axes = frame(cid)
    return np.asarray(origin + axes @ cartesian(kind, q))


def unit_vectors(cid: int, q: Array) -> Array:
    """Directions (columns, basic frame) in which a point moves when one of its coordinates grows; no angle formula."""
    columns = []
    for i in range(3):
        step = np.zeros(3)
        step[i] = 1e-4
        along = place(cid, q + step) - place(cid, q - step)
        columns.append(along / np.linalg.norm(along))
    return np.stack(columns, axis=1)


def coordinates(cid: int, x: Array) -> Array:
    """Coordinates of a place of the basic frame."""
    kind, origin, axes = frame(cid)
    p = axes.T @ (x - origin)
    if kind == "R":
        return p
    angle = np.degrees(np.angle(p[0] + 1j * p[1]))
    if kind == "C":
        return np.array([abs(p[0] + 1j * p[1]), angle, p[2]])
    r = np.linalg.norm(p)
    return np.array([r, np.degrees(np.arccos(p[2] / r)), angle])


def points(seed: int, count: int) -> list[tuple[int, int, tuple[float, ...], int]]:
    """Grids in frames of every kind, CP and CD mostly different, with coordinates of the nine digits of the deck."""
    random = np.random.default_rng(seed)
    out = []
    for i in range(count):
        cp, cd = int(random.integers(0, 10)), int(random.integers(0, 10))
        kind = frame(cp)[0]
        low, high = {
            "R": ((-1, -1, -1), (1, 1, 1)),
            "C": ((0.1, -180, -1), (1, 180, 1)),
            "S": ((0.1, 5, -180), (1, 175, 180)),
        }[kind]
        out.append((10 * i + 3, cp, tuple(np.round(random.uniform(low, high), 9)), cd))
    return out


def warmed_and_turned(x: Array) -> tuple[Array, Array]:
    """Free expansion by α ΔT about a point and a small rigid rotation: the analytic answer in the basic frame."""
    turn = np.array([3e-6, -7e-6, 5e-6])
    arm = x - np.array([0.05, -0.02, 0.03])
    return 2e-5 * arm + np.cross(turn, arm), np.tile(turn, (len(x), 1))


def test_motion_in_nested_frames_of_all_kinds(tmp_path: Path) -> None:
    grids = points(5, 120)
    _, geometry = read(write_deck(tmp_path / "model.bdf", grids, CARDS))
    x = np.array([place(cp, np.array(q)) for _, cp, q, _ in grids])
    np.testing.assert_allclose(geometry.position_m, x, rtol=0, atol=1e-12)
    u, turn = warmed_and_turned(x)
    axes = np.array([unit_vectors(cd, coordinates(cd, p)) for (_, _, _, cd), p in zip(grids, x, strict=True)])
    local = np.concatenate([np.einsum("nab,na->nb", axes, v) for v in (u, turn)], axis=1)
    write_op2(tmp_path / "model.op2", geometry.grid_id, [(1, "ALL", local)])
    loads = [one_load(geometry)]
    ((_, t, r),) = unit_load_displacements([tmp_path / "model.op2"], loads, geometry)
    assert t.dtype == r.dtype == np.float64
    assert np.max(np.linalg.norm(t - u, axis=1) / np.linalg.norm(u, axis=1)) < SINGLE
    assert np.max(np.linalg.norm(r - turn, axis=1) / np.linalg.norm(turn, axis=1)) < SINGLE
    assert {cd for *_, cd in grids} == set(range(10))

    # The same numbers in a table of the name that says "basic frame" are left as they are.
    edit(tmp_path / "model.op2", rename("BOUGV1"))
    ((_, t, _),) = unit_load_displacements([tmp_path / "model.op2"], loads, geometry)
    np.testing.assert_array_equal(t, local[:, :3].astype(np.float32))


@pytest.mark.parametrize("cd", [2, 8, 9])
def test_on_the_axis_the_frame_is_its_own_rectangular_frame(tmp_path: Path, cd: int) -> None:
    """Both ends of the axis and its origin: directions 1, 2, 3 are the frame's x, y, z."""
    _, origin, directions = frame(cd)
    grids = [(i + 1, 0, tuple(origin + d * directions[:, 2]), cd) for i, d in enumerate((-0.75, 0.0, 0.5))]
    _, geometry = read(write_deck(tmp_path / "model.bdf", grids, CARDS))
    u, turn = warmed_and_turned(geometry.position_m)
    axes = frame(cd)[2]
    write_op2(tmp_path / "model.op2", geometry.grid_id, [(1, "ALL", np.hstack([u @ axes, turn @ axes]))])
    ((_, t, r),) = unit_load_displacements([tmp_path / "model.op2"], [one_load(geometry)], geometry)
    np.testing.assert_allclose(t, u, rtol=0, atol=SINGLE * np.abs(u).max())
    np.testing.assert_allclose(r, turn, rtol=0, atol=SINGLE * np.abs(turn).max())


@pytest.mark.parametrize("cd", [4, 7])
def test_off_the_axis_by_rounding_is_refused(tmp_path: Path, cd: int) -> None:
    """The axis of a frame that is turned is met to rounding only, and what the solver made of that is unknown."""
    _, origin, directions = frame(cd)
    grids = [(i + 1, 0, (0.1 * i, 0.2, 0.0), 0) for i in range(3)]
    grids.append((77, cd, (0.0, 0.0, 0.7) if cd == 4 else (0.7, 0.0, 0.0), cd))
    _, geometry = read(write_deck(tmp_path / "model.bdf", grids, CARDS))
    np.testing.assert_allclose(geometry.position_m[3], origin + 0.7 * directions[:, 2], rtol=0, atol=1e-15)
    write_op2(tmp_path / "model.op2", geometry.grid_id, [(1, "ALL", np.ones((4, 6)))])
    with pytest.raises(InputError, match=rf"'ALL'.*axis.*: 77 \(CD {cd}\)"):
        list(unit_load_displacements([tmp_path / "model.op2"], [one_load(geometry)], geometry))


@settings(max_examples=60, deadline=None)
@given(
    st.floats(0.01, 10),
    st.floats(0.02, np.pi - 0.02),
    st.floats(-np.pi, np.pi),
)
def test_spherical_unit_vectors(r: float, theta: float, phi: float) -> None:
    """Against the textbook: e_r along the radius, e_phi horizontal towards growing phi, e_theta = e_phi × e_r."""
    p = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    e_phi = np.cross([0.0, 0.0, 1.0], p) / np.sin(theta)
    wanted = np.stack([p, np.cross(e_phi, p), e_phi], axis=1)
    np.testing.assert_allclose(local_basis("S", r * p[None])[0], wanted, rtol=0, atol=1e-13)


@pytest.mark.parametrize("kind", ["R", "C", "S"])
def test_unit_vectors_are_right_handed_everywhere(kind: str) -> None:
    local = np.random.default_rng(3).normal(size=(50, 3))
    local[:3] = [[0, 0, 1], [0, 0, -1], [0, 0, 0]]
    basis = local_basis(kind, local)
    np.testing.assert_allclose(basis @ np.swapaxes(basis, 1, 2), np.tile(np.eye(3), (50, 1, 1)), atol=1e-15)
    np.testing.assert_allclose(np.linalg.det(basis), 1.0, rtol=1e-14)
