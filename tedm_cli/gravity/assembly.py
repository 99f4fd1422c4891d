"""From the part of the field that exerts a torque to the six quantities of the kernel, point by point."""

from __future__ import annotations

import numpy as np

from tedm_cli.arrays import FloatArray, IndexArray
from tedm_cli.gravity.compiled import compiled

GROUP = 64
"""Sources that `put_sums` adds in turn."""


@compiled
def put_sums(values: FloatArray, mass: FloatArray, sums: FloatArray) -> None:
    """Write the sums of mass [n] times values [n, k] over groups of `GROUP` sources, [k, groups]."""
    count, columns = values.shape
    for group in range(sums.shape[1]):
        for k in range(columns):
            total = 0.0
            for n in range(group * GROUP, min(count, (group + 1) * GROUP)):
                total += mass[n] * values[n, k]
            sums[k, group] = total


@compiled
def put_force_gradient(
    points: FloatArray, field: FloatArray, separate: bool, rows: IndexArray, force: FloatArray, gamma_lin: FloatArray
) -> None:
    """Write force [n, 3] and gradient [n, 3, 3] of some rows, completed by a point mass where that is `separate`.

    Parameters
    ----------
    points : [k, 3], in the frame of the cuboid [m].
    field : [k, 9], force along x, y, z and gradient xx, yy, zz, xy, xz, yz.
    separate : whether `field` lacks the point mass at the centre.
    rows : [k], where the results go.
    """
    for k in range(rows.size):
        n = rows[k]
        inverse_square = 1.0 / (points[k, 0] ** 2 + points[k, 1] ** 2 + points[k, 2] ** 2)
        slope = inverse_square * np.sqrt(inverse_square) if separate else 0.0
        for i in range(3):
            j = (i + 1) % 3
            force[n, i] = field[k, i] + points[k, i] * slope
            gamma_lin[n, i, i] = field[k, 3 + i] + (3.0 * points[k, i] ** 2 * inverse_square - 1.0) * slope
            # xy, yz, zx
            mixed = field[k, 8 - (i + 2) % 3] + 3.0 * points[k, i] * points[k, j] * inverse_square * slope
            gamma_lin[n, i, j] = gamma_lin[n, j, i] = mixed


@compiled
def put_torque(
    points: FloatArray,
    field: FloatArray,
    rows: IndexArray,
    torque: FloatArray,
    omega_lin: FloatArray,
    omega_ang: FloatArray,
) -> None:
    """Write torque [n, 3], omega_lin and omega_ang [n, 3, 3] of some rows.

    Parameters as of `put_force_gradient`; a point mass at the centre, included in `field` or not, contributes nothing.
    """
    gamma = np.empty((3, 3))
    for k in range(rows.size):
        n = rows[k]
        for i in range(3):
            gamma[i, i] = field[k, 3 + i]
            gamma[i, (i + 1) % 3] = gamma[(i + 1) % 3, i] = field[k, 8 - (i + 2) % 3]
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            torque[n, i] = points[k, a] * field[k, b] - points[k, b] * field[k, a]
            for j in range(3):
                omega_lin[n, i, j] = points[k, a] * gamma[b, j] - points[k, b] * gamma[a, j]
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            omega_lin[n, a, b] -= field[k, i]
            omega_lin[n, b, a] += field[k, i]
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            for j in range(3):
                # [R]x gamma_ang, with gamma_ang = omega_linᵀ
                omega_ang[n, i, j] = points[k, a] * omega_lin[n, j, b] - points[k, b] * omega_lin[n, j, a]
