"""Where temperatures act: connected elements of one area that act on an output in one direction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Place:
    """Connected elements of one area whose sensitivities have one sign.

    area : its row, -1: none. elements : their rows. value : sum of their sensitivities. share : its size over that of
    all elements, with no sign: the shares of all places are 1 together. volume : m³. position : [3], m, the centre of
    their sizes.
    """

    area: int
    elements: IntArray
    value: float
    share: float
    volume: float
    position: FloatArray


def places_of(
    value: FloatArray, volume: FloatArray, area: IntArray, centre: FloatArray, offset: IntArray, node: IntArray
) -> list[Place]:
    """All places of an output, those with the largest shares first.

    Parameters
    ----------
    value : [E], sensitivity to 1 K of each element. volume : [E], m³. area : [E]. centre : [E, 3], m.
    offset, node : [E + 1] and [M], rows of the grids of each element; elements that share one are connected.
    """
    acting = np.flatnonzero(value)
    total = float(np.abs(value).sum())
    if not acting.size:
        return []
    piece = _pieces(2 * area + (value > 0.0), offset, node)[acting]
    order = np.argsort(piece, kind="stable")
    found = []
    for members in np.split(acting[order], np.flatnonzero(np.diff(piece[order])) + 1):
        size = np.abs(value[members])
        found.append(
            Place(
                area=int(area[members[0]]),
                elements=members,
                value=float(value[members].sum()),
                share=float(size.sum()) / total,
                volume=float(volume[members].sum()),
                position=np.asarray(size @ centre[members] / size.sum()),
            )
        )
    return sorted(found, key=lambda place: -place.share)


def _pieces(kind: IntArray, offset: IntArray, node: IntArray) -> IntArray:
    """Number of the connected piece of each element [E], of elements of one kind that share grids."""
    from scipy.sparse import coo_array  # here, for who imports this room may have no places to find
    from scipy.sparse.csgraph import connected_components

    elements = len(kind)
    member = np.repeat(np.arange(elements), np.diff(offset))
    _, corner = np.unique(np.column_stack([node, kind[member]]), axis=0, return_inverse=True)
    corner = elements + corner.reshape(-1)
    count = int(corner.max(initial=elements - 1)) + 1
    graph = coo_array((np.ones(len(member)), (member, corner)), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1][:elements], dtype=np.int64)


def density_bound(value: FloatArray, volume: FloatArray, left_out: float = 0.05) -> float:
    """Sensitivity per volume that scales a map: elements with more of it have at most `left_out` of all sizes.

    So no single small element sets it. 0 where nothing acts. Arrays as of `places_of`.
    """
    size, there = np.abs(value), volume > 0.0
    density = size[there] / volume[there]
    order = np.argsort(-density, kind="stable")
    above = np.cumsum(size[there][order])
    if not above.size:
        return 0.0
    return float(density[order[min(int(np.searchsorted(above, left_out * above[-1], side="right")), len(order) - 1)]])
