"""Closed form of the field of a homogeneous polyhedron, free of singularities outside it (Werner and Scheeres 1997).

With the integral ``∫∫ dA/r = Σ_e h L - |d| Ω`` over a plane facet at the distance d, with h the distance of its edge e
from the foot of the perpendicular (Wilton et al. 1984), ``F = (1/V) Σ_f n ∫∫ dA/r`` and, its derivative,
``Γ = (1/V) Σ_f n (Σ_e u L - n sgn(d) Ω)`` with the outward normals u of the edges in the plane. An edge logarithm is
that of a sum of positive terms; an edge's part of the solid angle is the argument of one complex number,
``atan(h t₂/(h² + d² + |d| r₂)) - atan(h t₁/(h² + d² + |d| r₁))``, which is 0 on the extension of the edge.
"""

from __future__ import annotations

import math

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.gravity.compiled import compiled

_ON_THE_EDGE = 1e-300


@compiled
def polyhedron_form(
    points: FloatArray,
    corner: FloatArray,
    edge: IntArray,
    along: FloatArray,
    anchor: IntArray,
    normal: FloatArray,
    first: IntArray,
    side: IntArray,
    outward: FloatArray,
    volume: float,
    field: FloatArray,
) -> None:
    """Mean over the polyhedron of the attraction towards each point, and its gradient.

    Parameters
    ----------
    points : [n, 3], [m].
    corner : [v, 3], corners [m].
    edge : [e, 2], the corners of each edge; along : [e, 3], unit vector from the first to the second.
    anchor : [f], a corner of each facet; normal : [f, 3], its outward unit normal.
    first : [f + 1], where the sides of each facet start in `side` [s], its edges, and `outward` [s, 3], their unit
        normals in its plane.
    volume : of the polyhedron [m³].
    field : [n, 9], as of `edge_form`.
    """
    edges, facets = edge.shape[0], anchor.shape[0]
    radius = np.empty(corner.shape[0])
    seen = np.empty((corner.shape[0], 3))
    log, lower, upper = np.empty(edges), np.empty(edges), np.empty(edges)
    for n in range(points.shape[0]):
        for v in range(corner.shape[0]):
            x, y, z = corner[v, 0] - points[n, 0], corner[v, 1] - points[n, 1], corner[v, 2] - points[n, 2]
            seen[v, 0], seen[v, 1], seen[v, 2] = x, y, z
            radius[v] = math.sqrt(x * x + y * y + z * z)
        for e in range(edges):
            a, b = edge[e, 0], edge[e, 1]
            ex, ey, ez = along[e, 0], along[e, 1], along[e, 2]
            lower[e] = seen[a, 0] * ex + seen[a, 1] * ey + seen[a, 2] * ez
            upper[e] = seen[b, 0] * ex + seen[b, 1] * ey + seen[b, 2] * ez
            cx = seen[a, 1] * ez - seen[a, 2] * ey
            cy = seen[a, 2] * ex - seen[a, 0] * ez
            cz = seen[a, 0] * ey - seen[a, 1] * ex
            middle = lower[e] + upper[e]
            near, near_radius = (-upper[e], radius[b]) if middle < 0.0 else (lower[e], radius[a])
            near_sum = near_radius + abs(near)
            if near < 0.0:
                near_sum = (cx * cx + cy * cy + cz * cz) / near_sum
            longer = (upper[e] - lower[e]) * (1.0 + abs(middle) / (radius[a] + radius[b]))
            log[e] = math.log1p(longer / max(near_sum, _ON_THE_EDGE))
        fx = fy = fz = gxx = gyy = gzz = gxy = gxz = gyz = 0.0
        for f in range(facets):
            nx, ny, nz = normal[f, 0], normal[f, 1], normal[f, 2]
            v = anchor[f]
            d = nx * seen[v, 0] + ny * seen[v, 1] + nz * seen[v, 2]
            depth = abs(d)
            potential = angle = ux = uy = uz = 0.0
            real, imaginary = 1.0, 0.0
            for s in range(first[f], first[f + 1]):
                e = side[s]
                a, b = edge[e, 0], edge[e, 1]
                h = outward[s, 0] * seen[a, 0] + outward[s, 1] * seen[a, 1] + outward[s, 2] * seen[a, 2]
                potential += h * log[e]
                ux += outward[s, 0] * log[e]
                uy += outward[s, 1] * log[e]
                uz += outward[s, 2] * log[e]
                if d != 0.0:
                    square = h * h + d * d
                    t1, t2 = h * lower[e], h * upper[e]
                    q1, q2 = square + depth * radius[a], square + depth * radius[b]
                    c, i = q1 * q2 + t1 * t2, t2 * q1 - t1 * q2
                    size = 1.0 / (abs(c) + abs(i))
                    real, imaginary = (real * c - imaginary * i) * size, (real * i + imaginary * c) * size
            if d != 0.0:
                # the angles of the edges add up in the argument of a product, which lacks whole turns
                angle = math.atan2(imaginary, real)
                if angle < -1.0:
                    angle += 2.0 * math.pi
                elif angle < 0.0:
                    angle = _sum_of_angles(f, d, seen, radius, lower, upper, edge, first, side, outward)
            potential -= depth * angle
            solid = angle if d > 0.0 else -angle
            fx += nx * potential
            fy += ny * potential
            fz += nz * potential
            ux -= nx * solid
            uy -= ny * solid
            uz -= nz * solid
            gxx += nx * ux
            gyy += ny * uy
            gzz += nz * uz
            gxy += 0.5 * (nx * uy + ny * ux)
            gxz += 0.5 * (nx * uz + nz * ux)
            gyz += 0.5 * (ny * uz + nz * uy)
        field[n, 0], field[n, 1], field[n, 2] = fx / volume, fy / volume, fz / volume
        field[n, 3], field[n, 4], field[n, 5] = gxx / volume, gyy / volume, gzz / volume
        field[n, 6], field[n, 7], field[n, 8] = gxy / volume, gxz / volume, gyz / volume


@compiled
def _sum_of_angles(
    f: int,
    d: float,
    seen: FloatArray,
    radius: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    edge: IntArray,
    first: IntArray,
    side: IntArray,
    outward: FloatArray,
) -> float:
    """Solid angle of a facet edge by edge: from a little less than 0, by rounding, to a whole half space."""
    angle = 0.0
    for s in range(first[f], first[f + 1]):
        e = side[s]
        a, b = edge[e, 0], edge[e, 1]
        h = outward[s, 0] * seen[a, 0] + outward[s, 1] * seen[a, 1] + outward[s, 2] * seen[a, 2]
        t1, t2 = h * lower[e], h * upper[e]
        q1, q2 = h * h + d * d + abs(d) * radius[a], h * h + d * d + abs(d) * radius[b]
        angle += math.atan2(t2 * q1 - t1 * q2, q1 * q2 + t1 * t2)
    return angle


@compiled
def enclosed_angle(points: FloatArray, triangle: FloatArray, angle: FloatArray) -> None:
    """Solid angle of a closed surface [t, 3, 3] from each point: 4π inside, 0 outside (Van Oosterom, Strackee 1983)."""
    for n in range(points.shape[0]):
        x, y, z = points[n, 0], points[n, 1], points[n, 2]
        total = 0.0
        for t in range(triangle.shape[0]):
            ax, ay, az = triangle[t, 0, 0] - x, triangle[t, 0, 1] - y, triangle[t, 0, 2] - z
            bx, by, bz = triangle[t, 1, 0] - x, triangle[t, 1, 1] - y, triangle[t, 1, 2] - z
            cx, cy, cz = triangle[t, 2, 0] - x, triangle[t, 2, 1] - y, triangle[t, 2, 2] - z
            ra = math.sqrt(ax * ax + ay * ay + az * az)
            rb = math.sqrt(bx * bx + by * by + bz * bz)
            rc = math.sqrt(cx * cx + cy * cy + cz * cz)
            volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
            below = ra * rb * rc + (ax * bx + ay * by + az * bz) * rc
            below += (ax * cx + ay * cy + az * cz) * rb + (bx * cx + by * cy + bz * cz) * ra
            total += 2.0 * math.atan2(volume, below)
        angle[n] = total


@compiled
def distance_to_surface(points: FloatArray, triangle: FloatArray, distance: FloatArray) -> None:
    """Distance of each point from the nearest of the triangles [t, 3, 3] (Ericson 2005, section 5.1.5)."""
    for n in range(points.shape[0]):
        least = np.inf
        for t in range(triangle.shape[0]):
            d1 = d2 = d3 = d4 = d5 = d6 = 0.0
            for c in range(3):
                ab, ac = triangle[t, 1, c] - triangle[t, 0, c], triangle[t, 2, c] - triangle[t, 0, c]
                ap, bp = points[n, c] - triangle[t, 0, c], points[n, c] - triangle[t, 1, c]
                cp = points[n, c] - triangle[t, 2, c]
                d1 += ab * ap
                d2 += ac * ap
                d3 += ab * bp
                d4 += ac * bp
                d5 += ab * cp
                d6 += ac * cp
            va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
            if d1 <= 0.0 and d2 <= 0.0:
                v, w = 0.0, 0.0
            elif d3 >= 0.0 and d4 <= d3:
                v, w = 1.0, 0.0
            elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
                v, w = d1 / (d1 - d3), 0.0
            elif d6 >= 0.0 and d5 <= d6:
                v, w = 0.0, 1.0
            elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
                v, w = 0.0, d2 / (d2 - d6)
            elif va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
                w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
                v = 1.0 - w
            else:
                v, w = vb / (va + vb + vc), vc / (va + vb + vc)
            square = 0.0
            for c in range(3):
                foot = triangle[t, 0, c] * (1.0 - v - w) + v * triangle[t, 1, c] + w * triangle[t, 2, c]
                square += (points[n, c] - foot) ** 2
            least = min(least, square)
        distance[n] = math.sqrt(least)
