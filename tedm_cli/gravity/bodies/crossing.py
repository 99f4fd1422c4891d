"""Triangles of a surface that cut through each other."""

from __future__ import annotations

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.gravity.compiled import compiled

_ROUNDING = 1e-14  # of six times a volume, over the cube of the extent


def crossing_pairs(corner: FloatArray, triangle: IntArray, most: int = 5) -> list[tuple[int, int]]:
    """The first pairs of triangles that an edge of one of which passes through the other; shared corners do not count.

    Parameters
    ----------
    corner : [v, 3], m; triangle : [t, 3].
    most : how many pairs to look for.
    """
    some = corner[triangle]
    order = np.argsort(some[:, :, 0].min(axis=1), kind="stable")
    found = np.empty((most, 2), dtype=np.int64)
    extent = float(np.ptp(corner, axis=0).max())
    count = _sweep(corner / extent, triangle, order, _ROUNDING, found)
    return [(int(a), int(b)) for a, b in np.sort(found[:count], axis=1)]


@compiled
def _sweep(corner: FloatArray, triangle: IntArray, order: IntArray, rounding: float, found: IntArray) -> int:
    count, size = 0, order.shape[0]
    low, high = np.empty((size, 3)), np.empty((size, 3))
    for t in range(size):
        for c in range(3):
            a, b, d = corner[triangle[t, 0], c], corner[triangle[t, 1], c], corner[triangle[t, 2], c]
            low[t, c], high[t, c] = min(a, b, d), max(a, b, d)
    for i in range(size):
        s = order[i]
        for j in range(i + 1, size):
            t = order[j]
            if low[t, 0] > high[s, 0]:
                break
            if low[t, 1] > high[s, 1] or low[s, 1] > high[t, 1] or low[t, 2] > high[s, 2] or low[s, 2] > high[t, 2]:
                continue
            if _pierces(corner, triangle, s, t, rounding) or _pierces(corner, triangle, t, s, rounding):
                found[count, 0], found[count, 1] = s, t
                count += 1
                if count == found.shape[0]:
                    return count
    return count


@compiled
def _pierces(corner: FloatArray, triangle: IntArray, s: int, t: int, rounding: float) -> bool:
    """Whether an edge of triangle s goes through triangle t from one side to the other."""
    a, b, c = corner[triangle[t, 0]], corner[triangle[t, 1]], corner[triangle[t, 2]]
    for k in range(3):
        p, q = corner[triangle[s, k]], corner[triangle[s, (k + 1) % 3]]
        first, second = _volume(p, a, b, c), _volume(q, a, b, c)
        if not ((first > rounding and second < -rounding) or (first < -rounding and second > rounding)):
            continue
        u, v, w = _volume(p, q, a, b), _volume(p, q, b, c), _volume(p, q, c, a)
        if (u >= 0.0 and v >= 0.0 and w >= 0.0) or (u <= 0.0 and v <= 0.0 and w <= 0.0):
            return True
    return False


@compiled
def _volume(p: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray) -> float:
    """Six times the signed volume of a tetrahedron; exactly 0 where p is one of the other corners."""
    ax, ay, az = a[0] - p[0], a[1] - p[1], a[2] - p[2]
    bx, by, bz = b[0] - p[0], b[1] - p[1], b[2] - p[2]
    cx, cy, cz = c[0] - p[0], c[1] - p[1], c[2] - p[2]
    volume: float = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return volume
