"""What the cutting of elements asks of each of them and of their cells, in compiled loops (estimate: `cells`)."""

from __future__ import annotations

import math

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.gravity.compiled import compiled, inlined

# Of rows of a matrix turned until they are at right angles: three rows take some five.
_SWEEPS = 30
_RIGHT_ANGLE = 1e-16


@compiled
def put_departure(basis: FloatArray, best: FloatArray, nodes: FloatArray, departure: FloatArray) -> None:
    """Write the largest departure of each element's nodes from its best affine image, relative to its extent, [E].

    In the element's own directions it counts per direction, out of a surface or off a line against the smallest extent.

    Parameters
    ----------
    basis : [n, d], reference nodes about their mean; best : [d, n], its pseudoinverse.
    nodes : [E, n, 3], m.
    """
    corners, dimension = basis.shape
    rest = np.empty((corners, 3))
    # the affine image in the first three columns, next to it the rotation that its rows have undergone
    rows = np.empty((dimension, 3 + dimension))
    square = np.empty(dimension)
    share = np.empty(dimension)
    for e in range(nodes.shape[0]):
        for i in range(3):
            mean = 0.0
            for n in range(corners):
                mean += nodes[e, n, i] / corners
            for n in range(corners):
                rest[n, i] = nodes[e, n, i] - mean
            for a in range(dimension):
                total = 0.0
                for n in range(corners):
                    total += best[a, n] * rest[n, i]
                rows[a, i] = total
            for n in range(corners):
                for a in range(dimension):
                    rest[n, i] -= basis[n, a] * rows[a, i]
        for a in range(dimension):
            for b in range(dimension):
                rows[a, 3 + b] = 1.0 if a == b else 0.0
        # Singular values by one-sided Jacobi rotations, after which the rows are at right angles (Golub & Van Loan,
        # Matrix Computations, 2013, 8.6.3).
        turned = True
        sweep = 0
        while turned and sweep < _SWEEPS:
            turned = False
            sweep += 1
            for a in range(dimension - 1):
                for b in range(a + 1, dimension):
                    aa, bb, ab = _dot(rows[a], rows[a]), _dot(rows[b], rows[b]), _dot(rows[a], rows[b])
                    if abs(ab) > _RIGHT_ANGLE * math.sqrt(aa * bb):
                        turned = True
                        half = (bb - aa) / (2.0 * ab)
                        tangent = math.copysign(1.0 / (abs(half) + math.sqrt(1.0 + half * half)), half)
                        cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
                        for i in range(3 + dimension):
                            x, y = rows[a, i], rows[b, i]
                            rows[a, i], rows[b, i] = cosine * (x - tangent * y), cosine * (tangent * x + y)
        largest, smallest = 0.0, math.inf
        for a in range(dimension):
            square[a] = _dot(rows[a], rows[a])
            largest, smallest = max(largest, square[a]), min(smallest, square[a])
        inside = outside = 0.0
        for n in range(corners):
            for a in range(dimension):
                # the pseudoinverse leaves out directions of no extent
                share[a] = _dot(rest[n], rows[a]) / square[a] if square[a] > 1e-30 * largest else 0.0
                for i in range(3):
                    rest[n, i] -= share[a] * rows[a, i]
            for b in range(dimension):
                along = 0.0
                for a in range(dimension):
                    along += share[a] * rows[a, 3 + b]
                inside = max(inside, abs(along))
            outside = max(outside, _dot(rest[n], rest[n]))
        departure[e] = 2.0 * max(inside, math.sqrt(outside / smallest) if smallest > 0.0 else 1.0)


@inlined
def _dot(first: FloatArray, second: FloatArray) -> float:
    return float(first[0] * second[0] + first[1] * second[1] + first[2] * second[2])


@compiled
def put_extent(
    net: FloatArray,
    points: FloatArray,
    low: FloatArray,
    high: FloatArray,
    lengths: FloatArray,
    gap: FloatArray,
    closest: FloatArray,
) -> None:
    """Write how long cells are along each of their directions, and how far from a cuboid they and their points are.

    Parameters
    ----------
    net, points : [c, k^d, 3], Bézier control points and points of each cell, m.
    low, high : [3], between which coordinates the cuboid lies, m.
    lengths : [c, d], receives the longest control polygon.
    gap : [c], receives the distance of the box about the net from the cuboid.
    closest : [c], receives that of the closest point; -1 where one has no finite position.
    """
    dimension, count = lengths.shape[1], net.shape[1]
    k = 3 if count == 3**dimension else 2
    for c in range(lengths.shape[0]):
        stride = count
        for axis in range(dimension):
            stride //= k
            longest = 0.0
            for first in range(count):
                if first // stride % k == 0:
                    length = 0.0
                    for n in range(first, first + (k - 1) * stride, stride):
                        x, y = net[c, n + stride, 0] - net[c, n, 0], net[c, n + stride, 1] - net[c, n, 1]
                        z = net[c, n + stride, 2] - net[c, n, 2]
                        length += math.sqrt(x * x + y * y + z * z)
                    longest = max(longest, length)
            lengths[c, axis] = longest
        square = 0.0
        for i in range(3):
            lower = upper = net[c, 0, i]
            for n in range(1, count):
                lower, upper = min(lower, net[c, n, i]), max(upper, net[c, n, i])
            square += max(0.0, lower - high[i], low[i] - upper) ** 2
        gap[c] = math.sqrt(square)
        nearest = math.inf
        finite = True
        for n in range(count):
            square = 0.0
            for i in range(3):
                square += max(0.0, low[i] - points[c, n, i], points[c, n, i] - high[i]) ** 2
                finite = finite and math.isfinite(points[c, n, i])
            nearest = min(nearest, square)
        closest[c] = math.sqrt(nearest) if finite else -1.0


@compiled
def put_wanted(
    lengths: FloatArray,
    gap: FloatArray,
    kappa: FloatArray,
    degree: int,
    jacobian_degree: int,
    needed: float,
    most: int,
    wanted: IntArray,
) -> None:
    """Write the Gauss points per direction of cells, [c, d]; `most` + 1 where it takes more.

    Parameters
    ----------
    lengths : [c, d], m; gap : [c], distance from the test mass, m; kappa : [c], departure from an affine cell.
    degree, jacobian_degree : of the shape functions and of the Jacobian in one direction.
    needed : logarithm of the factor by which the error must have fallen.
    """
    for c in range(lengths.shape[0]):
        for axis in range(lengths.shape[1]):
            rate = 50.0
            if lengths[c, axis] > 0.0:
                rate = min(math.asinh(2.0 * gap[c] / lengths[c, axis]), 50.0)
            slower = jacobian_degree * math.log1p(kappa[c] * math.exp(rate))
            wanted[c, axis] = most + 1
            for p in range(most, 0, -1):
                if (2 * p - degree) * rate - slower >= needed:
                    wanted[c, axis] = p
