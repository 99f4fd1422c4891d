"""Unit vectors of Nastran's rectangular, cylindrical and spherical frames."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray

Frame = tuple[str, FloatArray, FloatArray]

# A grid this near to the axis of a curvilinear frame is on it but for rounding.
_ROUNDING_M = 1e-10


def local_basis(kind: str, local: FloatArray) -> FloatArray:
    """Unit vectors [n,3,3] (columns) of a frame at points `local` [n,3] given in its own Cartesian axes.

    `kind`: R rectangular; C cylindrical (r, theta, z); S spherical (r, theta from z, phi about z). On the axis of a
    curvilinear frame, where the angle is undefined, the unit vectors are the frame's own Cartesian axes
    (OptiStruct Reference Guide, remarks on CORD1S: the defining rectangular system); on it means exactly on it.
    """
    n = len(local)
    basis = np.tile(np.eye(3), (n, 1, 1))
    if kind == "R":
        return basis
    off = np.hypot(local[:, 0], local[:, 1]) > 0.0
    x, y, z = local[off].T
    phi = np.arctan2(y, x)
    c, s = np.cos(phi), np.sin(phi)
    zero, one = np.zeros_like(c), np.ones_like(c)
    if kind == "C":
        columns = [[c, s, zero], [-s, c, zero], [zero, zero, one]]
    else:
        theta = np.arctan2(np.hypot(x, y), z)
        ct, st = np.cos(theta), np.sin(theta)
        columns = [[st * c, st * s, ct], [ct * c, ct * s, -st], [-s, c, zero]]
    basis[off] = np.stack([np.stack(col, axis=-1) for col in columns], axis=-1)
    return basis


def displacement_axes(
    position_m: FloatArray, displacement_frame: IntArray, frames: Mapping[int, Frame]
) -> FloatArray | None:
    """Unit vectors [N,3,3] (columns, basic frame) of every grid's displacement frame (CD); None when all are basic.

    Parameters
    ----------
    position_m : [N,3], basic frame.
    displacement_frame : [N], CD of each grid.
    frames : type, origin [3] and axes [3,3] (rows) in the basic frame, by id.
    """
    used = np.unique(displacement_frame)
    if list(used) == [0]:
        return None
    out = np.tile(np.eye(3), (len(position_m), 1, 1))
    for cid in used[used != 0]:
        kind, origin, axes = frames[int(cid)]
        rows = np.nonzero(displacement_frame == cid)[0]
        local = (position_m[rows] - origin) @ axes.T
        out[rows] = np.einsum("ai,nab->nib", axes, local_basis(kind, local))
    return out


def rounded_off_axis(position_m: FloatArray, displacement_frame: IntArray, frames: Mapping[int, Frame]) -> BoolArray:
    """Grids [N] that lie off the axis of their curvilinear displacement frame by no more than rounding.

    A solver that finds them off the axis by some 1e-17 takes its angle from that (seen in real results): the directions
    of their displacements are those of its rounding, which nobody else can know.
    """
    out = np.zeros(len(position_m), dtype=bool)
    for cid in np.unique(displacement_frame):
        kind, origin, axes = frames[int(cid)]
        if kind != "R":
            rows = np.nonzero(displacement_frame == cid)[0]
            distance = np.hypot(*((position_m[rows] - origin) @ axes[:2].T).T)
            out[rows] = (distance > 0.0) & (distance < _ROUNDING_M)
    return out


def local_coordinates(kind: str, local: FloatArray) -> dict[str, FloatArray]:
    """Coordinates [n] of points `local` [n,3], given in a frame's own Cartesian axes, by their name in configurations.

    R: x_m, y_m, z_m; C: r_m, theta_deg, z_m; S: r_m, theta_deg (from z), phi_deg. Angles are in degrees, as on
    Nastran's GRID cards.
    """
    x, y, z = local.T
    if kind == "R":
        return {"x_m": x, "y_m": y, "z_m": z}
    around = np.degrees(np.arctan2(y, x))
    if kind == "C":
        return {"r_m": np.hypot(x, y), "theta_deg": around, "z_m": z}
    polar = np.degrees(np.arctan2(np.hypot(x, y), z))
    return {"r_m": np.linalg.norm(local, axis=1), "theta_deg": polar, "phi_deg": around}
