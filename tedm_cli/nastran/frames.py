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
