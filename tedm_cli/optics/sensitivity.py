"""Analytic derivative of every path's output by the six motions of every element (the matrix called S_BW).

Montemurro 2004, eq. 10.2, took this matrix from a ray tracer; here it follows from differentiating the trace surface by
surface, carrying the tangents of hit point, direction and optical path for all motions of a path at once.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tedm_cli.errors import InputError
from tedm_cli.optics.layout import N_MOTIONS, N_OUTPUTS, BeamPath, OpticalLayout
from tedm_cli.optics.trace import Hit, Poses, nominal_poses, trace_path

Matrix = NDArray[np.float64]


def sensitivity_matrix(layout: OpticalLayout) -> Matrix:
    """S_BW, [5 * n_paths, 6 * n_elements]: outputs x, y, opl (m), z1, z2 (rad) by motions ux uy uz (m), rx ry rz (rad).

    Motions are along and about the layout axes, rotations about the layout's reference points.

    Raises
    ------
    PhysicsError : a nominal ray misses an element.
    """
    poses = nominal_poses(layout)
    matrix = np.zeros((N_OUTPUTS * len(layout.paths), N_MOTIONS * len(layout.elements)))
    for path in layout.paths:
        names = tuple(dict.fromkeys(step.element for step in path.steps))
        columns = layout.columns_of(tuple(layout.elements[layout.index(name)] for name in names))
        matrix[layout.rows(path), columns] = _path_jacobian(layout, path, poses, names)
    return matrix


def reference_offsets(layout: OpticalLayout, node_positions_m: Matrix) -> Matrix:
    """Reference point minus finite-element node of each bench element in layout order, [n_bench, 3] m, layout frame.

    Parameters
    ----------
    node_positions_m : [n_bench, 3] m, basic frame.
    """
    places = [layout.index(e.name) for e in layout.bench]
    return np.asarray((layout.refs_m - layout.pivots_m(node_positions_m))[places])


def move_reference_points(S_BW: Matrix, layout: OpticalLayout, node_positions_m: Matrix) -> Matrix:
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
    moved = S_BW.copy()
    for element, offset in zip(layout.bench, reference_offsets(layout, node_positions_m), strict=True):
        columns = layout.columns(element.name)
        moved[:, columns][:, 3:] -= S_BW[:, columns][:, :3] @ cross_matrix(offset)
    return moved


def check_shape(S_BW: Matrix, layout: OpticalLayout) -> None:
    """Raise `InputError` unless S_BW is finite and has five rows per path and six columns per element."""
    shape = (N_OUTPUTS * len(layout.paths), N_MOTIONS * len(layout.elements))
    if S_BW.shape != shape:
        raise InputError(f"the optical sensitivity matrix is {S_BW.shape}, the layout needs {shape}", where="S_BW")
    bad = np.count_nonzero(~np.isfinite(S_BW))
    if bad:
        raise InputError(f"{bad} entries of the optical sensitivity matrix are not finite", where="S_BW")


def cross_matrix(vector: Matrix) -> Matrix:
    """[v]x, the matrix of `v x`, [..., 3, 3]."""
    return np.asarray(np.cross(np.eye(3), vector[..., None, :])).swapaxes(-1, -2) * -1.0


def _path_jacobian(layout: OpticalLayout, path: BeamPath, poses: Poses, names: tuple[str, ...]) -> Matrix:
    """Derivative [5, 6 * len(names)] of one path's output by the motions of the elements it meets.

    Along the ray `d' = d + ...` the tangents obey, at hit point p with normal n against the ray, N the index before,
    `s = u + theta x (p - ref)` and `dn = theta x n`:

        hit      dt = n.(s - dp - t dd) / (n.d),  dp += t dd + d dt,  dopl += N dt
        mirror   dd' = dd - 2 (dd.n + d.dn) n - 2 (d.n) dn
        refract  dc1 = -(dd.n + d.dn),  dc2 = mu^2 c1 dc1 / c2,
                 dd' = mu dd + (mu dc1 - dc2) n + (mu c1 - c2) dn
        diode    dx = ex.(dp - s),  dz1 = ex.(dd - theta x d)
    """
    width = N_MOTIONS * len(names)
    block = {layout.index(name): N_MOTIONS * i for i, name in enumerate(names)}
    dp, dd, dopl = np.zeros((3, width)), np.zeros((3, width)), np.zeros(width)
    source = layout.index(path.steps[0].element)
    at = block[source]
    dp[:, at : at + 3] = np.eye(3)
    dd[:, at + 3 : at + 6] = -cross_matrix(poses.normal[source])

    ray = trace_path(layout, path, poses)
    for hit in ray.hits:
        at = block[hit.element]
        n, d = hit.normal, hit.direction
        s, dn = np.zeros((3, width)), np.zeros((3, width))
        s[:, at : at + 3] = np.eye(3)
        s[:, at + 3 : at + 6] = -cross_matrix(hit.point - poses.ref[hit.element])
        dn[:, at + 3 : at + 6] = -cross_matrix(n)
        dt = n @ (s - dp - hit.distance * dd) / (n @ d)
        dp = dp + hit.distance * dd + np.outer(d, dt)
        dopl = dopl + hit.index_in * dt
        if hit.kind == "reflect":
            dd = dd - 2 * np.outer(n, n @ dd + d @ dn) - 2 * (d @ n) * dn
        elif hit.kind == "refract":
            dd = _refracted_tangent(hit, dd, dn)

    diode = ray.hits[-1].element
    at = block[diode]
    turned = np.zeros((3, width))
    turned[:, at + 3 : at + 6] = -cross_matrix(ray.hits[-1].direction)
    ey = poses.local_y[diode]
    ex = np.cross(ey, poses.normal[diode])
    return np.stack([ex @ (dp - s), ey @ (dp - s), dopl, ex @ (dd - turned), ey @ (dd - turned)])


def _refracted_tangent(hit: Hit, dd: Matrix, dn: Matrix) -> Matrix:
    n, d = hit.normal, hit.direction
    mu = hit.index_in / hit.index_out
    c1 = -(d @ n)
    c2 = np.sqrt(1 - mu**2 * (1 - c1**2))
    dc1 = -(n @ dd + d @ dn)
    dc2 = mu**2 * c1 * dc1 / c2
    return np.asarray(mu * dd + np.outer(n, mu * dc1 - dc2) + (mu * c1 - c2) * dn)
