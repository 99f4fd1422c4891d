"""Closed form of the field of a homogeneous cuboid, free of branch and edge-line singularities outside the body.

The printed closed form (Montemurro 2004, appendix C) uses principal arctangents and corner logarithms ``ln(c + r)``:
the first jump by π, the second diverge on the extension of an edge. Here each edge contributes the logarithm of a sum
of positive terms and each face its solid angle from a single two-argument arctangent.
"""

from __future__ import annotations

import math

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.gravity.compiled import compiled

_ON_THE_EDGE = 1e-300


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
    # coordinates of the two faces normal to each axis, as seen from the point
    corner = np.empty((3, 2))
    # of the corner at the ends i, j, k along x, y, z, at index i + 2 j + 4 k
    radius = np.empty(8)
    # of the edge along an axis, at the ends j, k along the next two axes in cyclic order
    log = np.empty((3, 2, 2))
    volume = (high[0] - low[0]) * (high[1] - low[1]) * (high[2] - low[2])
    for n in range(points.shape[0]):
        for axis in range(3):
            corner[axis, 0] = low[axis] - points[n, axis]
            corner[axis, 1] = high[axis] - points[n, axis]
        for index in range(8):
            x, y, z = corner[0, index & 1], corner[1, index >> 1 & 1], corner[2, index >> 2]
            radius[index] = math.sqrt(x * x + y * y + z * z)
        for axis in range(3):
            u, v = (axis + 1) % 3, (axis + 2) % 3
            for j in range(2):
                for k in range(2):
                    first = (j << u) + (k << v)
                    distance_squared = corner[u, j] ** 2 + corner[v, k] ** 2
                    log[axis, j, k] = _edge_log(
                        corner[axis, 0], corner[axis, 1], distance_squared, radius[first], radius[first + (1 << axis)]
                    )
        for axis in range(3):
            u, v = (axis + 1) % 3, (axis + 2) % 3
            u0, u1, v0, v1 = corner[u, 0], corner[u, 1], corner[v, 0], corner[v, 1]
            force = gamma = 0.0
            for i in range(2):
                distance, first = corner[axis, i], i << axis
                angle = _solid_angle(
                    *(distance, u0, u1, v0, v1),
                    *(radius[first], radius[first + (1 << v)]),
                    *(radius[first + (1 << u)], radius[first + (1 << u) + (1 << v)]),
                )
                # ∫∫ dA/r over the face
                potential = u1 * log[v, i, 1] - u0 * log[v, i, 0] + v1 * log[u, 1, i] - v0 * log[u, 0, i]
                potential -= distance * angle
                force += potential if i else -potential
                gamma += -angle if i else angle
            mixed = (log[axis, 1, 1] - log[axis, 1, 0]) - (log[axis, 0, 1] - log[axis, 0, 0])
            field[n, axis] = force / volume
            field[n, 3 + axis] = gamma / volume
            field[n, 8 - axis] = mixed / volume


@compiled
def _edge_log(low: float, high: float, distance_squared: float, radius_low: float, radius_high: float) -> float:
    """``∫ dt/r`` along an edge from `low` to `high`, coordinates along it as seen from the point.

    `distance_squared` is that of the point from the line of the edge, the radii those of the two corners.
    """
    middle = low + high
    # Reflected so that the upper end is the farther one: every term below is then positive.
    near, near_radius = (-high, radius_high) if middle < 0.0 else (low, radius_low)
    near_sum = near_radius + abs(near)
    if near < 0.0:
        near_sum = distance_squared / near_sum
    # On the edge itself the logarithm is infinite; where another cuboid takes that edge away the two must cancel.
    return math.log1p((high - low) * (1.0 + abs(middle) / (radius_low + radius_high)) / max(near_sum, _ON_THE_EDGE))


@compiled
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
    angle = math.atan2(
        outer_real * inner_imag + outer_imag * inner_real, outer_real * inner_real - outer_imag * inner_imag
    )
    if angle < 0.0:
        angle += 2.0 * math.pi
    if d == 0.0:
        return 0.0
    return angle if d > 0.0 else -angle
