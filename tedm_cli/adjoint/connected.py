"""Which grids may be joined: those that share an element, inside parts that must stay apart."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from tedm_cli.arrays import FloatArray, IntArray


def sharing_an_element(node_offset: IntArray, node_index: IntArray, part: IntArray) -> IntArray:
    """Pairs [p, 2] of grids of one part that share an element, lower row first.

    Parameters
    ----------
    node_offset, node_index : [E + 1] and [M], rows of the grids of each element. part : [N], -1: in none.
    """
    n, elements = len(part), len(node_offset) - 1
    element = np.repeat(np.arange(elements), np.diff(node_offset))
    member = coo_array((np.ones(len(node_index)), (node_index, element)), shape=(n, elements)).tocsr()
    found = (member @ member.T).tocoo()
    first, second = found.row.astype(np.int64), found.col.astype(np.int64)
    keep = (first < second) & (part[first] == part[second]) & (part[first] >= 0)
    return np.column_stack([first[keep], second[keep]])


def pieces(n: int, pairs: IntArray) -> IntArray:
    """Number of the connected piece of each of n grids, [n], by pairs [p, 2]."""
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def joining(pairs: IntArray, position: FloatArray, area: IntArray) -> IntArray:
    """More pairs [q, 2] at the shortest distances that make one piece of the grids of every area.

    An area that is held together by what is none of its elements (rigid ones, neighbours) may stay one.

    Parameters
    ----------
    position : [n, 3], m. area : [n], numbers from 0 on.
    """
    piece = pieces(len(area), pairs)
    order = np.lexsort((piece, area))
    more: list[tuple[int, int]] = []
    for members in np.split(order, np.flatnonzero(np.diff(area[order])) + 1):
        apart = np.split(members, np.flatnonzero(np.diff(piece[members])) + 1)
        joined = apart[0]
        for group in apart[1:]:
            distance, nearest = KDTree(position[joined]).query(position[group])
            at = int(distance.argmin())
            one, two = int(joined[nearest[at]]), int(group[at])
            more.append((min(one, two), max(one, two)))
            joined = np.concatenate([joined, group])
    return np.array(more, dtype=np.int64).reshape(-1, 2)
