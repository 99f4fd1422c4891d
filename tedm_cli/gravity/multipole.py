"""Multipole expansion of the field of a homogeneous cuboid beyond its monopole (moments and weights: `moments`)."""

from __future__ import annotations

import math

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.gravity.compiled import compiled

# Points taken together: the innermost loops run over them, so that the compiler can use vector instructions.
_LANES = 64
# For even and odd m, by row of the weights: real (0) or imaginary (1) part, and the component of the field.
_PART = ((0, 0, 1, 0), (0, 1, 0, 1))
_COLUMN = ((3, 4, 6, 2), (0, 1, 7, 8))


@compiled
def excess_field(points: FloatArray, scale: float, weights: FloatArray, field: FloatArray) -> None:
    """Field of the cuboid less that of a point mass at its centre.

    For fixed m, ``I_l^m = (2l-1)!! r⁻¹ [(x + iy)/r²]^m a_l`` with real a_l, ``a_m = 1`` and
    ``a_{l+1} = (z/r²) a_l - (l² - m²)/(4l² - 1) r⁻² a_{l-1}`` (Hobson 1931), lengths in units of `scale`.

    Parameters
    ----------
    points : [n, 3], points beyond the circumscribed sphere, in the frame of the cuboid [m].
    scale : half the body diagonal [m].
    weights : from `moments.field_weights`.
    field : [n, 9], receives the excess of ``(1/V) ∫ (R - r)/|R - r|³ dV`` over ``R/R³`` along x, y, z [1/m²], then
        ``-∂force_i/∂R_j`` for xx, yy, zz, xy, xz, yz [1/m³].
    """
    count, degrees = points.shape[0], weights.shape[0]
    # x/r², y/r², z/r², 1/r²; 1/r times real and imaginary part of [(x + iy)/r²]^m; a_l for two degrees
    x, y, z, square = np.empty(_LANES), np.empty(_LANES), np.empty(_LANES), np.empty(_LANES)
    azimuth = np.empty((2, _LANES))
    first, second = np.empty(_LANES), np.empty(_LANES)
    # weighted sums over the degrees for one m, and the field, in the order of the weights for even and for odd m
    column = np.empty((4, _LANES))
    sum_0, sum_1, sum_2, sum_3 = column[0], column[1], column[2], column[3]
    total = np.empty((2, 4, _LANES))
    for start in range(0, count, _LANES):
        for p in range(_LANES):
            # the last group is filled up with its last point
            n = min(start + p, count - 1)
            px, py, pz = points[n, 0] / scale, points[n, 1] / scale, points[n, 2] / scale
            square[p] = 1.0 / (px * px + py * py + pz * pz)
            x[p], y[p], z[p] = px * square[p], py * square[p], pz * square[p]
            azimuth[0, p], azimuth[1, p] = math.sqrt(square[p]), 0.0
        total[:] = 0.0
        for m in range(degrees):
            first[:] = 1.0
            second[:] = 0.0
            column[:] = 0.0
            for k in range((degrees - m + 1) // 2):
                degree = m + 2 * k
                w0, w1, w2, w3, w4 = (
                    weights[m, k, 0],
                    weights[m, k, 1],
                    weights[m, k, 2],
                    weights[m, k, 3],
                    weights[m, k, 4],
                )
                down = (degree**2 - m**2) / (4.0 * degree**2 - 1.0)
                down_next = ((degree + 1) ** 2 - m**2) / (4.0 * (degree + 1) ** 2 - 1.0)
                for p in range(_LANES):
                    a = first[p]
                    b = z[p] * a - down * square[p] * second[p]
                    sum_0[p] += w0 * a
                    sum_1[p] += w1 * a
                    sum_2[p] += w2 * a + w3 * b
                    sum_3[p] += w4 * b
                    second[p] = b
                    first[p] = z[p] * b - down_next * square[p] * a
            for row in range(4):
                part = _PART[m % 2][row]
                for p in range(_LANES):
                    total[m % 2, row, p] += azimuth[part, p] * column[row, p]
            for p in range(_LANES):
                real, imaginary = azimuth[0, p], azimuth[1, p]
                azimuth[0, p] = x[p] * real - y[p] * imaginary
                azimuth[1, p] = x[p] * imaginary + y[p] * real
        for p in range(min(_LANES, count - start)):
            for parity in range(2):
                for row in range(4):
                    target = _COLUMN[parity][row]
                    field[start + p, target] = total[parity, row, p] / scale ** (2 if target < 3 else 3)
            field[start + p, 5] = -(field[start + p, 3] + field[start + p, 4])
