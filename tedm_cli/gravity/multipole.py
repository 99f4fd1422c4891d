"""Multipole expansion of the field of a homogeneous cuboid beyond its monopole (moments and weights: `moments`)."""

from __future__ import annotations

import math

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.gravity.compiled import compiled, inlined

# Points taken together: the innermost loops run over them, so that the compiler can use vector instructions.
_LANES = 64
# Pairs of degrees from which a group of points is kept in registers.
_PAIRS = 4
_State = tuple[float, float, float, float, float, float]


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
    per_length = 1.0 / scale
    per_square = per_length**2
    per_cube = per_length**3
    # the coefficients of the recurrence for two degrees, next to their weights: [m, k, 7], k filled up with zeros
    pairs = weights.shape[1] + (-weights.shape[1]) % _PAIRS
    terms = np.zeros((degrees, pairs, 7))
    for m in range(degrees):
        for k in range((degrees - m + 1) // 2):
            for column in range(5):
                terms[m, k, column] = weights[m, k, column]
        for k in range(pairs):
            degree = m + 2 * k
            terms[m, k, 5] = (degree**2 - m**2) / (4.0 * degree**2 - 1.0)
            terms[m, k, 6] = ((degree + 1) ** 2 - m**2) / (4.0 * (degree + 1) ** 2 - 1.0)
    # One array for all, which the compiler need not suspect to overlap. Rows: x/r², y/r², z/r², 1/r²; 1/r times real
    # and imaginary part of [(x + iy)/r²]^m; a_l for two degrees; weighted sums over the degrees for one m.
    work = np.empty((12, _LANES))
    total = np.empty((9, _LANES))
    for start in range(0, count, _LANES):
        for p in range(_LANES):
            # the last group is filled up with its last point
            n = min(start + p, count - 1)
            work[0, p], work[1, p], work[2, p] = points[n, 0], points[n, 1], points[n, 2]
        for p in range(_LANES):
            x, y, z = work[0, p] * per_length, work[1, p] * per_length, work[2, p] * per_length
            square = 1.0 / (x * x + y * y + z * z)
            work[0, p], work[1, p], work[2, p], work[3, p] = x * square, y * square, z * square, square
            work[4, p], work[5, p] = math.sqrt(square), 0.0
            for column in range(9):
                total[column, p] = 0.0
        for m in range(degrees):
            for p in range(_LANES):
                work[6, p], work[7, p] = 1.0, 0.0
                work[8, p] = work[9, p] = work[10, p] = work[11, p] = 0.0
            for k in range(0, (degrees - m + 1) // 2, _PAIRS):
                term_0, term_1, term_2, term_3 = terms[m, k], terms[m, k + 1], terms[m, k + 2], terms[m, k + 3]
                for p in range(_LANES):
                    z, square = work[2, p], work[3, p]
                    state = work[6, p], work[7, p], work[8, p], work[9, p], work[10, p], work[11, p]
                    state = _two_degrees(term_0, z, square, state)
                    state = _two_degrees(term_1, z, square, state)
                    state = _two_degrees(term_2, z, square, state)
                    state = _two_degrees(term_3, z, square, state)
                    work[6, p], work[7, p], work[8, p], work[9, p], work[10, p], work[11, p] = state
            for p in range(_LANES):
                real, imaginary = work[4, p], work[5, p]
                if m % 2 == 0:
                    total[3, p] += real * work[8, p]
                    total[4, p] += real * work[9, p]
                    total[6, p] += imaginary * work[10, p]
                    total[2, p] += real * work[11, p]
                else:
                    total[0, p] += real * work[8, p]
                    total[1, p] += imaginary * work[9, p]
                    total[7, p] += real * work[10, p]
                    total[8, p] += imaginary * work[11, p]
                work[4, p] = work[0, p] * real - work[1, p] * imaginary
                work[5, p] = work[0, p] * imaginary + work[1, p] * real
        for p in range(_LANES):
            total[5, p] = -(total[3, p] + total[4, p])
        for p in range(min(_LANES, count - start)):
            for column in range(9):
                field[start + p, column] = total[column, p] * (per_square if column < 3 else per_cube)


@inlined
def _two_degrees(term: FloatArray, z: float, square: float, state: _State) -> _State:
    """The sums, and the a of a degree and of the one before it, two degrees farther on."""
    a, before, sum_0, sum_1, sum_2, sum_3 = state
    b = z * a - term[5] * square * before
    return (
        z * b - term[6] * square * a,
        b,
        sum_0 + term[0] * a,
        sum_1 + term[1] * a,
        sum_2 + (term[2] * a + term[3] * b),
        sum_3 + term[4] * b,
    )
