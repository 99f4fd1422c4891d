"""Small areas of connected grids on which the outputs act alike, from which larger ones are made."""

from __future__ import annotations

import warnings

import numpy as np
from scipy.sparse import coo_array

from tedm_cli.adjoint.connected import pieces
from tedm_cli.adjoint.temperature_field import FieldPoints
from tedm_cli.arrays import FloatArray, IntArray


def like_grids(points: FieldPoints, pairs: IntArray, count: int) -> IntArray:
    """Clusters of connected points of like s per volume, numbers [n] from 0 on.

    By Ward's criterion with the connectivity of the mesh. All outputs count alike: s per volume is over what a field
    without correlation makes of the output. Positions do not count: a wide area of even s per volume is exact.

    Parameters
    ----------
    points : n of them. pairs : [p, 2], which may be joined.
    count : how many; there are more where the pairs leave more pieces.
    """
    n = len(points.volume)
    per_volume = points.sensitivity / points.volume
    feature = (per_volume / np.sqrt((points.volume * per_volume**2).sum(axis=1))[:, None]).T
    piece = pieces(n, pairs)
    merges = [(rows, *_ward(feature, rows, pairs, piece)) for rows in _by_number(piece)]
    height = np.concatenate([h for _, _, h in merges])
    of_piece = np.repeat(np.arange(len(merges)), [len(h) for _, _, h in merges])
    lowest = np.argsort(height, kind="stable")[: max(n - count, 0)]
    out = np.empty(n, dtype=np.int64)
    total = 0
    for (rows, children, _), taken in zip(merges, np.bincount(of_piece[lowest], minlength=len(merges)), strict=True):
        found = _after(children[:taken], len(rows))
        out[rows] = found + total
        total += int(found.max()) + 1
    return out


def _by_number(number: IntArray) -> list[IntArray]:
    order = np.argsort(number, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(number[order])) + 1)


def _ward(feature: FloatArray, rows: IntArray, pairs: IntArray, piece: IntArray) -> tuple[IntArray, FloatArray]:
    """Merges [m - 1, 2] of the m points of a piece and their heights, none below the one before."""
    m = len(rows)
    if m == 1:
        return np.empty((0, 2), dtype=np.int64), np.empty(0)
    from sklearn.cluster import ward_tree  # takes a second to import

    mine = pairs[piece[pairs[:, 0]] == piece[rows[0]]]
    one, two = (np.searchsorted(rows, mine[:, i]) for i in (0, 1))
    graph = coo_array((np.ones(2 * len(mine)), (np.r_[one, two], np.r_[two, one])), shape=(m, m)).tocsr()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        children, _, _, _, height = ward_tree(feature[rows], connectivity=graph, return_distance=True)
    # With a connectivity a merge may be cheaper than one before it.
    return np.asarray(children, dtype=np.int64), np.maximum.accumulate(height)


def _after(children: IntArray, m: int) -> IntArray:
    """Numbers [m] from 0 on of the clusters of m points after the merges."""
    parent = np.arange(m + len(children))
    for number, (one, two) in enumerate(children):
        parent[one] = parent[two] = m + number
    for node in range(len(parent) - 1, -1, -1):
        parent[node] = parent[parent[node]]
    return np.asarray(np.unique(parent[:m], return_inverse=True)[1], dtype=np.int64)
