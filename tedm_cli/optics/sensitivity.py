"""Analytic derivative of every path's output by the six motions of every element (the matrix called S_BW).

Montemurro 2004, eq. 10.2, took this matrix from a ray tracer; here it follows from differentiating the trace surface by
surface. Each surface maps the variations (dp, dd, dopl) of point, direction and optical path of the ray linearly; the
five outputs are carried back through these maps, from the photodiode to the injector.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.optics.layout import N_MOTIONS, N_OUTPUTS, BeamPath, OpticalLayout
from tedm_cli.optics.trace import Hit, Poses, nominal_poses, photodiode_axes, trace_path

POINT, DIRECTION, OPL = slice(0, 3), slice(3, 6), 6  # places in the state of a ray
_GENERATORS = np.cross(np.eye(3)[:, None], np.eye(3)).swapaxes(1, 2).reshape(3, 9)  # [e_k]x, one per row
SHIFT, TURN = slice(0, 3), slice(3, 6)  # places in the motion of an element


def optical_sensitivity(layout: OpticalLayout) -> FloatArray:
    """S_BW, [5 * n_paths, 6 * n_elements]: outputs x, y, opl (m), z1, z2 (rad) by motions ux uy uz (m), rx ry rz (rad).

    Motions are along and about the layout axes, rotations about the layout's reference points.

    Raises
    ------
    PhysicsError : a nominal ray misses an element.
    """
    normal = np.array([e.normal for e in layout.elements])
    matrix = np.zeros((N_OUTPUTS * len(layout.paths), N_MOTIONS * len(layout.elements)))
    for path in linearised_paths(layout):
        rows = matrix[layout.rows(path.path)].reshape(N_OUTPUTS, len(layout.elements), N_MOTIONS)  # a view
        rows[:, path.hits[-1].element] = path.by_photodiode
        for hit, outputs, B in zip(path.hits[::-1], path.outputs[::-1], path.by_motion[::-1], strict=True):
            rows[:, hit.element] += outputs @ B
        source = layout.index(path.path.steps[0].element)
        rows[:, source, SHIFT] += path.from_source[:, POINT]
        rows[:, source, TURN] -= path.from_source[:, DIRECTION] @ cross_matrix(normal[source])
    return matrix


@dataclass(frozen=True, eq=False)
class LinearisedPath:
    """One traced path with h hits, and what its five outputs are of a small change anywhere on it.

    outputs : [h, 5, 7], by the state of the ray (point, direction, optical path) behind each hit; from_source : [5, 7],
    by that before the first. by_motion : [h, 7, 6], state behind each hit by the motion of its element. by_photodiode :
    [5, 6], by the photodiode's own motion, beside that.
    """

    path: BeamPath
    hits: tuple[Hit, ...]
    outputs: list[FloatArray]
    by_motion: FloatArray
    from_source: FloatArray
    by_photodiode: FloatArray


def linearised_paths(layout: OpticalLayout) -> list[LinearisedPath]:
    """All paths of a layout; the outputs are carried back from the photodiode to the injector.

    Raises
    ------
    PhysicsError : a nominal ray misses an element.
    """
    poses = nominal_poses(layout)
    traces = [trace_path(layout, path, poses) for path in layout.paths]
    by_state, by_motion = _linearised([hit for trace in traces for hit in trace.hits], poses)
    found, end = [], 0
    for path, trace in zip(layout.paths, traces, strict=True):
        begin, end = end, end + len(trace.hits)
        outputs, by_photodiode = _at_photodiode(trace.hits[-1], poses)
        behind = []
        for A in by_state[begin:end][::-1]:
            behind.append(outputs)
            outputs = outputs @ A
        found.append(LinearisedPath(path, trace.hits, behind[::-1], by_motion[begin:end], outputs, by_photodiode))
    return found


def reference_offsets(layout: OpticalLayout, node_positions_m: FloatArray) -> FloatArray:
    """Reference point minus finite-element node of each bench element in layout order, [n_bench, 3] m, layout frame.

    Parameters
    ----------
    node_positions_m : [n_bench, 3] m, basic frame.
    """
    places = [layout.index(e.name) for e in layout.bench]
    return np.asarray((layout.refs_m - layout.pivots_m(node_positions_m))[places])


def move_reference_points(S_BW: FloatArray, layout: OpticalLayout, node_positions_m: FloatArray) -> FloatArray:
    """S_BW for motions of the finite-element nodes instead of the layout's reference points.

    A node and the reference point of its element are taken as rigidly joined: `u_ref = u_node + theta x (ref - node)`,
    so that `S_node = S_ref [[I, -[ref - node]x], [0, I]]`. Test-mass columns do not change.

    Parameters
    ----------
    S_BW : [5 * n_paths, 6 * n_elements], rotations about the layout's reference points.
    node_positions_m : nodes of the bench elements in layout order, [n_bench, 3] m, basic frame.

    Raises
    ------
    InputError : an array does not fit the layout.
    """
    check_shape(S_BW, layout)
    return turned_about(S_BW, layout.refs_m - layout.pivots_m(node_positions_m))


def turned_about(S_BW: FloatArray, offsets_m: FloatArray) -> FloatArray:
    """S_BW [rows, 6 * n_elements] for rotations about new points; `offsets_m` [n_elements, 3]: old minus new point."""
    moved = S_BW.copy()
    columns = moved.reshape(len(moved), -1, 2, 3)  # a view: row, element, translation or rotation, axis
    columns[:, :, 1] -= np.einsum("rei,eij->rej", columns[:, :, 0], cross_matrix(offsets_m))
    return moved


def check_shape(S_BW: FloatArray, layout: OpticalLayout) -> None:
    """Raise `InputError` unless S_BW is finite and has five rows per path and six columns per element."""
    shape = (N_OUTPUTS * len(layout.paths), N_MOTIONS * len(layout.elements))
    if S_BW.shape != shape:
        raise InputError(f"the optical sensitivity matrix is {S_BW.shape}, the layout needs {shape}", where="S_BW")
    bad = np.count_nonzero(~np.isfinite(S_BW))
    if bad:
        raise InputError(f"{bad} entries of the optical sensitivity matrix are not finite", where="S_BW")


def cross_matrix(vector: FloatArray) -> FloatArray:
    """[v]x, the matrix of `v x`, [..., 3, 3]."""
    return np.asarray((vector @ _GENERATORS).reshape(*vector.shape, 3))


def _at_photodiode(hit: Hit, poses: Poses) -> tuple[FloatArray, FloatArray]:
    """Outputs by the state of the ray on the photodiode [5, 7], and by the photodiode's own motion [5, 6].

    With `s = u + theta x (p - ref)`: `dx = ex.(dp - s)`, `dz1 = ex.(dd - theta x d)`, and the same along ey.
    """
    axes = np.stack(photodiode_axes(poses, hit.element))
    by_state, by_motion = np.zeros((N_OUTPUTS, 7)), np.zeros((N_OUTPUTS, N_MOTIONS))
    by_state[:2, POINT] = by_state[3:, DIRECTION] = axes
    by_state[2, OPL] = 1.0
    by_motion[:2, SHIFT] = -axes
    by_motion[:2, TURN] = axes @ cross_matrix(hit.point - poses.ref[hit.element])
    by_motion[3:, TURN] = axes @ cross_matrix(hit.direction)
    return by_state, by_motion


def _linearised(hits: list[Hit], poses: Poses) -> tuple[FloatArray, FloatArray]:
    """State of the ray behind each hit by the state before it [n, 7, 7], and by the motion of the element [n, 7, 6].

    At the hit point p with normal n against the ray, N the index before, `s = u + theta x (p - ref)`, `dn = theta x n`:

        hit      dt = n.(s - dp - t dd) / (n.d),  dp' = dp + t dd + d dt,  dopl' = dopl + N dt
        mirror   dd' = dd - 2 n (n.dd + d.dn) - 2 (d.n) dn
        refract  dd' = mu dd - (mu - mu^2 c1 / c2) n (n.dd + d.dn) + (mu c1 - c2) dn

    with mu the ratio of the indices and c1 = -d.n, c2 the cosines before and behind.
    """
    n, d, p = (np.stack([getattr(hit, name) for hit in hits]) for name in ("normal", "direction", "point"))
    t, index = (np.array([getattr(hit, name) for hit in hits]) for name in ("distance", "index_in"))
    ref = poses.ref[[hit.element for hit in hits]]
    c1 = -np.einsum("hi,hi->h", n, d)
    along, across, turning = _coefficients(hits, c1)

    identity = np.eye(3)
    dt = -n / c1[:, None]  # of the surface's displacement at p along the ray, as a row
    to_surface = identity - d[:, :, None] * dt[:, None, :]
    by_theta = -cross_matrix(p - ref)  # of s
    dn_by_theta = -cross_matrix(n)
    bent = across[:, None, None] * n[:, :, None]

    by_state = np.zeros((len(hits), 7, 7))
    by_state[:, POINT, POINT] = to_surface
    by_state[:, POINT, DIRECTION] = t[:, None, None] * to_surface
    by_state[:, DIRECTION, DIRECTION] = along[:, None, None] * identity - bent * n[:, None, :]
    by_state[:, OPL, POINT] = -index[:, None] * dt
    by_state[:, OPL, DIRECTION] = -(index * t)[:, None] * dt
    by_state[:, OPL, OPL] = 1.0

    s_to_ray = d[:, :, None] * dt[:, None, :]
    by_motion = np.zeros((len(hits), 7, N_MOTIONS))
    by_motion[:, POINT, SHIFT] = s_to_ray
    by_motion[:, POINT, TURN] = s_to_ray @ by_theta
    by_motion[:, DIRECTION, TURN] = turning[:, None, None] * dn_by_theta - bent * (d[:, None, :] @ dn_by_theta)
    by_motion[:, OPL, SHIFT] = index[:, None] * dt
    by_motion[:, OPL, TURN] = index[:, None] * np.einsum("hi,hij->hj", dt, by_theta)
    return by_state, by_motion


def _coefficients(hits: list[Hit], c1: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Factors a, b, c, each [n], of `dd' = a dd - b n (n.dd + d.dn) + c dn`, from the cosines of incidence."""
    kind = np.array([hit.kind for hit in hits])
    mu = np.array([hit.index_in / hit.index_out for hit in hits])
    c2 = np.sqrt(1 - mu**2 * (1 - c1**2))
    choices = [kind == "reflect", kind == "refract"]
    return (
        np.where(choices[1], mu, 1.0),
        np.select(choices, [np.full_like(c1, 2.0), mu - mu**2 * c1 / c2], 0.0),
        np.select(choices, [2 * c1, mu * c1 - c2], 0.0),
    )
