"""A closed surface of triangles as plane facets between edges, as the closed form takes it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray, IntArray

_COPLANAR = 1e-12  # of unit normals, and of distances from the plane over the extent of the body
_FLAT = 1e-14  # area over the square of the longest side below which a triangle has no normal


@dataclass(frozen=True, eq=False)
class Facets:
    """Arguments of `polyhedron_form`, in its order."""

    corner: FloatArray
    edge: IntArray
    along: FloatArray
    anchor: IntArray
    normal: FloatArray
    first: IntArray
    side: IntArray
    outward: FloatArray


def facets_of(corner: FloatArray, triangle: IntArray) -> Facets:
    """Facets of a closed, oriented surface: corners [v, 3], triangles [t, 3] counter-clockwise seen from outside.

    Triangles in one plane that meet at an edge are one facet: that edge contributes nothing, and near it a sum over
    both would lose digits. Triangles without area have no normal and contribute nothing.
    """
    normal = _normals(corner[triangle])
    directed = triangle[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    owner = np.repeat(np.arange(len(triangle)), 3)
    edge, which = np.unique(np.sort(directed, axis=1), axis=0, return_inverse=True)
    which = which.reshape(-1)
    pair = owner[np.argsort(which, kind="stable")].reshape(-1, 2)  # the two triangles of each edge
    facet = _coplanar(corner, triangle, normal, pair)
    inner = facet[pair[:, 0]] == facet[pair[:, 1]]
    used = np.flatnonzero(~inner)
    number = np.full(len(edge), -1)
    number[used] = np.arange(used.size)
    edge = edge[used].astype(np.int64)
    along = corner[edge[:, 1]] - corner[edge[:, 0]]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    area = np.linalg.norm(np.cross(corner[triangle[:, 1]] - corner[triangle[:, 0]],
                                   corner[triangle[:, 2]] - corner[triangle[:, 0]]), axis=1)  # fmt: skip
    largest = np.zeros(facet.max() + 1, dtype=np.int64)
    for t in np.argsort(area, kind="stable"):
        largest[facet[t]] = t
    of_facet = normal[largest]
    outer = np.flatnonzero(number[which] >= 0)
    outer = outer[np.argsort(facet[owner[outer]], kind="stable")]
    side, holder = number[which[outer]], facet[owner[outer]]
    forward = np.where(directed[outer, 0] == edge[side, 0], 1.0, -1.0)
    outward = np.cross(forward[:, None] * along[side], of_facet[holder])
    first = np.searchsorted(holder, np.arange(len(largest) + 1))
    return Facets(
        np.ascontiguousarray(corner), edge, along, triangle[largest, 0].astype(np.int64), of_facet,
        first.astype(np.int64), side.astype(np.int64), np.ascontiguousarray(outward),
    )  # fmt: skip


def _normals(corners: FloatArray) -> FloatArray:
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(cross, axis=1, keepdims=True)
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1, keepdims=True)
    flat = size <= _FLAT * longest**2
    return np.asarray(np.where(flat, 0.0, cross / np.where(flat, 1.0, size)))


def _coplanar(corner: FloatArray, triangle: IntArray, normal: FloatArray, pair: IntArray) -> IntArray:
    """Facet of each triangle, [t]: those in one plane that hang together have one number."""
    count, extent = len(triangle), float(np.ptp(corner, axis=0).max())
    joined = (np.abs(normal[pair[:, 0]] - normal[pair[:, 1]]).max(axis=1) < _COPLANAR) & normal[pair[:, 0]].any(axis=1)
    graph = scipy.sparse.coo_array((np.ones(joined.sum()), (pair[joined, 0], pair[joined, 1])), shape=(count, count))
    parts, facet = scipy.sparse.csgraph.connected_components(graph, directed=False)
    # a chain of almost coplanar triangles may bend: such a part is taken apart again
    start = np.zeros(parts, dtype=np.int64)
    start[facet[::-1]] = np.arange(count)[::-1]
    n = normal[start[facet]]
    off = np.einsum("tc,tkc->tk", n, corner[triangle] - corner[triangle[start[facet], 0]][:, None])
    bad = (np.abs(off).max(axis=1) > _COPLANAR * extent) | (np.abs(n - normal).max(axis=1) > _COPLANAR)
    again = np.isin(facet, facet[bad])
    facet[again] = parts + np.arange(int(again.sum()))
    return np.asarray(np.unique(facet, return_inverse=True)[1].reshape(-1), dtype=np.int64)
