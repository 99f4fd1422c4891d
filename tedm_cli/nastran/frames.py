"""Unit vectors of Nastran's rectangular, cylindrical and spherical frames."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def local_basis(kind: str, local: FloatArray) -> FloatArray:
    """Unit vectors [n,3,3] (columns) of a frame at points `local` [n,3] given in its own Cartesian axes.

    `kind`: R rectangular; C cylindrical (r, theta, z); S spherical (r, theta from z, phi about z). On the axis of a
    curvilinear frame the angle is undefined and taken as zero, as Nastran does.
    """
    n = len(local)
    basis = np.tile(np.eye(3), (n, 1, 1))
    if kind == "R":
        return basis
    phi = np.arctan2(local[:, 1], local[:, 0])
    c, s = np.cos(phi), np.sin(phi)
    zero, one = np.zeros(n), np.ones(n)
    if kind == "C":
        columns = [[c, s, zero], [-s, c, zero], [zero, zero, one]]
    else:
        theta = np.arctan2(np.hypot(local[:, 0], local[:, 1]), local[:, 2])
        ct, st = np.cos(theta), np.sin(theta)
        columns = [[st * c, st * s, ct], [ct * c, ct * s, -st], [-s, c, zero]]
    return np.stack([np.stack(col, axis=-1) for col in columns], axis=-1)


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
