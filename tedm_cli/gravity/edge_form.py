"""Closed form of the field of a homogeneous cuboid, free of branch and edge-line singularities outside the body.

The printed closed form (Montemurro 2004, appendix C) uses principal arctangents and corner logarithms ``ln(c + r)``:
the first jump by π, the second diverge on the extension of an edge. Here each edge contributes the logarithm of a sum
of positive terms and each face its solid angle from a single two-argument arctangent.

Logarithm and angle are written out in plain arithmetic without branches: calls of the mathematical library, one number
at a time, would keep the compiler from taking several points at once in the vector registers of the processor.
"""

from __future__ import annotations

import math

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.gravity.compiled import compiled, inlined

# Points taken together: the innermost loop runs over them, so that the compiler can use vector instructions.
_LANES = 64
# On an edge itself its logarithm is infinite; where another cuboid takes that edge away the two must cancel: for both
# the square of the distance is no less than this, m².
_ON_THE_EDGE = 1e-280
# ln 2 and π/4 in two parts each, the first of ln 2 with 20 trailing zeros: its multiples by exponents are exact.
_LN2, _LN2_REST = 0.6931471803691238, 1.9082149292705877e-10
_EIGHTH, _EIGHTH_REST = math.pi / 4.0, 3.061616997868383e-17
_TAN_1, _TAN_3 = math.tan(math.pi / 8.0), math.tan(3.0 * math.pi / 8.0)
# Of the sum in ``2 atanh s = 2 s (1 + s² Σ c_n s^2n)``, |s| < 0.2012, and ``atan t = t (1 + t² Σ c_n t^2n)``,
# |t| < tan π/8: of least largest error, 6e-19 and 5e-18 of the whole (Remez exchange in 40 digits).
_L0, _L1, _L2, _L3, _L4, _L5, _L6, _L7 = (
    *(0.3333333333333333, 0.20000000000004312, 0.14285714283489095, 0.11111111548419121),
    *(0.0909086694694781, 0.07694507188368041, 0.06603434669182968, 0.06815265964617491),
)
_A0, _A1, _A2, _A3, _A4, _A5, _A6, _A7, _A8, _A9, _A10 = (
    *(-0.3333333333333333, 0.19999999999995774, -0.14285714284714834, 0.11111111018844677),
    *(-0.09090904713574177, 0.07692186128377938, -0.06664550239803452, 0.058584660257984617),
    *(-0.05087016490852223, 0.039274519669142395, -0.01922672598500188),
)


@compiled
def edge_form(points: FloatArray, low: FloatArray, high: FloatArray, field: FloatArray) -> None:
    """Mean over the cuboid of the attraction towards each point, and its gradient.

    Parameters
    ----------
    points : [n, 3], points in axes along its edges [m]. Inside the cuboid the attraction is that of all of it, so that
        a cuboid may be taken away from a body: what it leaves is right where the body is not.
    low, high : [3], between which coordinates it lies [m]. Cuboids with a face in one plane must have one number for
        it, for a point in that plane to see both from one side.
    field : [n, 9], receives ``(1/V) ∫ (R - r)/|R - r|³ dV`` along x, y, z [1/m²], then ``-∂force_i/∂R_j`` for xx, yy,
        zz, xy, xz, yz [1/m³].
    """
    count = points.shape[0]
    position = np.empty((3, _LANES))
    result = np.empty((9, _LANES))
    low_x, low_y, low_z, high_x, high_y, high_z = low[0], low[1], low[2], high[0], high[1], high[2]
    inverse_volume = 1.0 / ((high_x - low_x) * (high_y - low_y) * (high_z - low_z))
    for start in range(0, count, _LANES):
        for p in range(_LANES):
            # the last group is filled up with its last point
            n = min(start + p, count - 1)
            position[0, p], position[1, p], position[2, p] = points[n, 0], points[n, 1], points[n, 2]
        for p in range(_LANES):
            # coordinates of the two faces normal to each axis, as seen from the point, and their squares
            x0, x1 = low_x - position[0, p], high_x - position[0, p]
            y0, y1 = low_y - position[1, p], high_y - position[1, p]
            z0, z1 = low_z - position[2, p], high_z - position[2, p]
            xx0, xx1, yy0, yy1, zz0, zz1 = x0 * x0, x1 * x1, y0 * y0, y1 * y1, z0 * z0, z1 * z1
            # of the corners, at the ends along x, y, z
            r000, r100 = math.sqrt(xx0 + yy0 + zz0), math.sqrt(xx1 + yy0 + zz0)
            r010, r110 = math.sqrt(xx0 + yy1 + zz0), math.sqrt(xx1 + yy1 + zz0)
            r001, r101 = math.sqrt(xx0 + yy0 + zz1), math.sqrt(xx1 + yy0 + zz1)
            r011, r111 = math.sqrt(xx0 + yy1 + zz1), math.sqrt(xx1 + yy1 + zz1)
            # logarithms of the edges along an axis, at the ends along the next two in cyclic order
            x00, x10 = _edge_log(x0, x1, yy0 + zz0, r000, r100), _edge_log(x0, x1, yy1 + zz0, r010, r110)
            x01, x11 = _edge_log(x0, x1, yy0 + zz1, r001, r101), _edge_log(x0, x1, yy1 + zz1, r011, r111)
            y00, y10 = _edge_log(y0, y1, zz0 + xx0, r000, r010), _edge_log(y0, y1, zz1 + xx0, r001, r011)
            y01, y11 = _edge_log(y0, y1, zz0 + xx1, r100, r110), _edge_log(y0, y1, zz1 + xx1, r101, r111)
            z00, z10 = _edge_log(z0, z1, xx0 + yy0, r000, r001), _edge_log(z0, z1, xx1 + yy0, r100, r101)
            z01, z11 = _edge_log(z0, z1, xx0 + yy1, r010, r011), _edge_log(z0, z1, xx1 + yy1, r110, r111)
            # solid angles of the faces
            ax0 = _solid_angle(x0, y0, y1, z0, z1, r000, r001, r010, r011)
            ax1 = _solid_angle(x1, y0, y1, z0, z1, r100, r101, r110, r111)
            ay0 = _solid_angle(y0, z0, z1, x0, x1, r000, r100, r001, r101)
            ay1 = _solid_angle(y1, z0, z1, x0, x1, r010, r110, r011, r111)
            az0 = _solid_angle(z0, x0, x1, y0, y1, r000, r010, r100, r110)
            az1 = _solid_angle(z1, x0, x1, y0, y1, r001, r011, r101, r111)
            # ∫∫ dA/r over the faces
            px0 = y1 * z01 - y0 * z00 + z1 * y10 - z0 * y00 - x0 * ax0
            px1 = y1 * z11 - y0 * z10 + z1 * y11 - z0 * y01 - x1 * ax1
            py0 = z1 * x01 - z0 * x00 + x1 * z10 - x0 * z00 - y0 * ay0
            py1 = z1 * x11 - z0 * x10 + x1 * z11 - x0 * z01 - y1 * ay1
            pz0 = x1 * y01 - x0 * y00 + y1 * x10 - y0 * x00 - z0 * az0
            pz1 = x1 * y11 - x0 * y10 + y1 * x11 - y0 * x01 - z1 * az1
            result[0, p] = inverse_volume * (px1 - px0)
            result[1, p] = inverse_volume * (py1 - py0)
            result[2, p] = inverse_volume * (pz1 - pz0)
            result[3, p] = inverse_volume * (ax0 - ax1)
            result[4, p] = inverse_volume * (ay0 - ay1)
            result[5, p] = inverse_volume * (az0 - az1)
            result[6, p] = inverse_volume * ((z11 - z10) - (z01 - z00))
            result[7, p] = inverse_volume * ((y11 - y10) - (y01 - y00))
            result[8, p] = inverse_volume * ((x11 - x10) - (x01 - x00))
        for p in range(min(_LANES, count - start)):
            for column in range(9):
                field[start + p, column] = result[column, p]


@inlined
def _edge_log(low: float, high: float, distance_squared: float, radius_low: float, radius_high: float) -> float:
    """``∫ dt/r`` along an edge from `low` to `high`, coordinates along it as seen from the point.

    `distance_squared` is that of the point from the line of the edge, the radii those of the two corners.
    """
    middle = low + high
    # Reflected so that the upper end is the farther one: every term below is then positive.
    near, near_radius = (-high, radius_high) if middle < 0.0 else (low, radius_low)
    near_sum, radii = near_radius + abs(near), radius_low + radius_high
    length = (high - low) * (radii + abs(middle))
    # near_radius + near, the lower end of the logarithm, is distance_squared/near_sum where near is negative
    above, below = (length * near_sum, distance_squared) if near < 0.0 else (length, near_sum)
    return log_of_one_plus(above, max(below, _ON_THE_EDGE) * radii)


@inlined
def _solid_angle(
    d: float, u0: float, u1: float, v0: float, v1: float, r00: float, r01: float, r10: float, r11: float
) -> float:
    """Solid angle ``∫∫ d/r³ dA``, with the sign of d, of a rectangle at the signed distance d from the point.

    u0 to u1 and v0 to v1 bound the rectangle as seen from the point, r with two indices are the distances of its
    corners at the respective ends.
    """
    depth = abs(d)
    # The four corner angles add up in the argument of a product: one branch decision per face instead of four.
    outer_real = depth * r00 * (depth * r11) - u0 * v0 * (u1 * v1)
    outer_imag = depth * r00 * (u1 * v1) + depth * r11 * (u0 * v0)
    inner_real = depth * r01 * (depth * r10) - u0 * v1 * (u1 * v0)
    inner_imag = -depth * r01 * (u1 * v0) - depth * r10 * (u0 * v1)
    angle = angle_around(
        outer_real * inner_imag + outer_imag * inner_real, outer_real * inner_real - outer_imag * inner_imag
    )
    angle = angle if d > 0.0 else -angle
    return 0.0 if d == 0.0 else angle


@inlined
def log_of_one_plus(above: float, below: float) -> float:
    """``ln(1 + above/below)`` within 3 units of its last place, of above >= 0 and below > 0 whose sum is finite.

    Neither is smaller than the least normal number, unless `above` is 0.
    """
    total = above + below
    # what the sum has lost (Knuth, The Art of Computer Programming, 4.2.2)
    back = total - below
    rest = (below - (total - back)) + (above - back)
    # With 2^k next to the ratio: the bits of a number grow with its logarithm to base 2, which they miss by 0.09.
    bits = np.float64(total).view(np.int64) - np.float64(below).view(np.int64)
    k = (bits + (1 << 51)) >> 52
    scale = float(np.int64((1023 - k) << 52).view(np.float64))
    scaled = total * scale
    s = ((scaled - below) + rest * scale) / (scaled + below)
    s2 = s * s
    s4 = s2 * s2
    series = (_L0 + s2 * _L1) + s4 * (_L2 + s2 * _L3) + (s4 * s4) * ((_L4 + s2 * _L5) + s4 * (_L6 + s2 * _L7))
    exponent, twice = float(k), s + s
    return exponent * _LN2 + (twice + (twice * (s2 * series) + exponent * _LN2_REST))


@inlined
def angle_around(y: float, x: float) -> float:
    """Angle of the point (x, y) from the axis of x, from 0 to 2π, within 3 units of its last place; 0 of the origin."""
    a, b = abs(y), abs(x)
    # tangent of the angle less 0, 1 or 2 eighths of a half turn
    octants = 2.0 if a > _TAN_3 * b else (1.0 if a > _TAN_1 * b else 0.0)
    above = -b if a > _TAN_3 * b else (a - b if a > _TAN_1 * b else a)
    below = a if a > _TAN_3 * b else (a + b if a > _TAN_1 * b else b)
    t = above / max(below, 2.3e-308)
    t2 = t * t
    t4 = t2 * t2
    t8 = t4 * t4
    series = (_A0 + t2 * _A1) + t4 * (_A2 + t2 * _A3) + t8 * ((_A4 + t2 * _A5) + t4 * (_A6 + t2 * _A7))
    series += (t8 * t8) * (_A8 + t2 * _A9 + t4 * _A10)
    rest = t + t * (t2 * series)
    # by quadrant: a, π - a, π + a, 2π - a
    turned = (x < 0.0) != (y < 0.0)
    octants = (4.0 if x < 0.0 else (8.0 if y < 0.0 else 0.0)) + (-octants if turned else octants)
    rest = -rest if turned else rest
    return octants * _EIGHTH + (octants * _EIGHTH_REST + rest)
