"""Closed form of the field of a homogeneous cuboid, free of branch and edge-line singularities outside the body.

The printed closed form (Montemurro 2004, appendix C) uses principal arctangents and corner logarithms ``ln(c + r)``:
the first jump by π, the second diverge on the extension of an edge. Here each edge contributes the logarithm of a sum
of positive terms and each face its solid angle from a single two-argument arctangent.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def edge_form(points: Array, half_sides: Array) -> tuple[Array, Array]:
    """Mean over the cuboid of the attraction towards a point, and its gradient.

    Parameters
    ----------
    points : [3, n], points outside the cuboid in its own frame [m].
    half_sides : [3], half edge lengths [m].

    Returns
    -------
    force : [3, n], ``(1/V) ∫ (R - r)/|R - r|³ dV`` [1/m²].
    gamma : [6, n], ``-∂force_i/∂R_j`` for xx, yy, zz, xy, xz, yz [1/m³].
    """
    # corner[axis][end]: coordinates of the two faces normal to `axis`, as seen from the point
    corner = np.stack([-half_sides[:, None] - points, half_sides[:, None] - points], axis=1)
    square = corner**2
    radius = np.sqrt(square[0, :, None, None] + square[1, None, :, None] + square[2, None, None, :])

    log_x = _edge_log(corner[0], square[1, :, None] + square[2, None, :], radius)
    log_y = _edge_log(corner[1], square[0, :, None] + square[2, None, :], radius.swapaxes(0, 1))
    log_z = _edge_log(corner[2], square[0, :, None] + square[1, None, :], radius.transpose(2, 0, 1, 3))

    volume = 8.0 * half_sides.prod()
    force = np.empty_like(points)
    gamma = np.empty((6, points.shape[1]))
    faces = (
        (corner[1], corner[2], log_z, log_y, radius),
        (corner[0], corner[2], log_z.swapaxes(0, 1), log_x, radius.swapaxes(0, 1)),
        (corner[0], corner[1], log_y.swapaxes(0, 1), log_x.swapaxes(0, 1), radius.transpose(2, 0, 1, 3)),
    )
    for axis, (u, v, log_u, log_v, r) in enumerate(faces):
        distance = corner[axis]
        angle = _solid_angle(distance, u, v, r)
        # ∫∫ dA/r over both faces; log_u[i, j]: edge of face i at u = u_j, log_v[i, k]: edge of face i at v = v_k
        potential = u[1] * log_u[:, 1] - u[0] * log_u[:, 0] + v[1] * log_v[:, 1] - v[0] * log_v[:, 0] - distance * angle
        force[axis] = potential[1] - potential[0]
        gamma[axis] = angle[0] - angle[1]
    for row, log in ((3, log_z), (4, log_y), (5, log_x)):
        gamma[row] = (log[1, 1] - log[1, 0]) - (log[0, 1] - log[0, 0])
    return force / volume, gamma / volume


def _edge_log(end: Array, distance_squared: Array, radius: Array) -> Array:
    """``∫ dt/r`` along the four edges parallel to one axis.

    Parameters
    ----------
    end : [2, n], coordinates of the lower and upper end along the edge, seen from the point.
    distance_squared : [2, 2, n], squared distance of the point from each edge line.
    radius : [2, 2, 2, n], distances of the corners, the first index running along the edge.
    """
    middle = end[0] + end[1]
    mirrored = middle < 0
    # Reflected so that the upper end is the farther one: every term below is then positive.
    near_end = np.where(mirrored, -end[1], end[0])
    near_radius = np.where(mirrored, radius[1], radius[0])
    sum_ = near_radius + np.abs(near_end)
    near_sum = np.where(near_end >= 0, sum_, distance_squared / sum_)
    length = end[1] - end[0]
    return np.asarray(np.log1p(length * (1.0 + np.abs(middle) / (radius[0] + radius[1])) / near_sum))


def _solid_angle(distance: Array, u: Array, v: Array, radius: Array) -> Array:
    """Signed solid angle ``∫∫ d/r³ dA`` of the two faces normal to one axis, [2, n].

    Parameters
    ----------
    distance : [2, n], signed distance of the two face planes from the point.
    u, v : [2, n], bounds of the faces along the other two axes, seen from the point.
    radius : [2, 2, 2, n], distances of the corners, indices face, u, v.
    """
    depth = np.abs(distance)[:, None, None] * radius
    area = u[:, None] * v[None, :]
    # The four corner angles add up in the argument of a product: one branch decision per face instead of four.
    outer = (depth[:, 0, 0] + 1j * area[0, 0]) * (depth[:, 1, 1] + 1j * area[1, 1])
    inner = (depth[:, 0, 1] - 1j * area[0, 1]) * (depth[:, 1, 0] - 1j * area[1, 0])
    angle = np.angle(outer * inner)
    return np.asarray(np.sign(distance) * np.where(angle < 0, angle + 2.0 * np.pi, angle))
