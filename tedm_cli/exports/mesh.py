"""A finite-element mesh as VTK's cells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tedm_cli.arrays import IntArray
from tedm_cli.fem.shapes import shape_of
from tedm_cli.files.blocks import node_blocks

VERTEX, LINE, PYRAMID = 1, 3, 14
# Numbers of vtkCellType.h by family and number of nodes. Linear wedges stand as Nastran has them, as VTK's own shape
# functions and integrals (Cell Size, Integrate Variables) do; the documentation of vtkWedge has them the other way
# round, and such wedges have negative volumes there.
_CELLS = {
    ("line", 2): LINE,
    ("triangle", 3): 5,
    ("triangle", 6): 22,
    ("quadrilateral", 4): 9,
    ("quadrilateral", 8): 23,
    ("tetrahedron", 4): 10,
    ("tetrahedron", 10): 24,
    ("pentahedron", 6): 13,
    ("pentahedron", 15): 26,
    ("hexahedron", 8): 12,
    ("hexahedron", 20): 25,
}
# Nastran numbers midside nodes bottom, uprights, top; VTK bottom, top, uprights.
_ORDER = {25: [*range(12), *range(16, 20), *range(12, 16)], 26: [*range(9), *range(12, 15), *range(9, 12)]}


@dataclass(frozen=True, eq=False)
class Cells:
    """Cells of one kind. `kind`: number of VTK; `nodes`: [c, n], rows of the points, in VTK's order; `row`: [c], of the
    elements."""

    kind: int
    nodes: IntArray
    row: IntArray


def element_cells(
    card: Sequence[str] | NDArray[np.str_], node_offset: IntArray, node_index: IntArray
) -> tuple[list[Cells], IntArray]:
    """Elements as cells, those of one card and number of nodes together; and the rows of those that have no cell.

    Cards without a shape are points or lines where they have one node or two (springs, dampers, bushes); with more
    (GENEL, CFAST, ...) or none (between scalar points) they are left out; none of these has mass.

    Parameters
    ----------
    card : [E], Nastran card names.
    node_offset, node_index : ragged connectivity, [E + 1] and [M] rows of the points, in Nastran's order.
    """
    names, name = np.unique(np.asarray(card, dtype=str), return_inverse=True)
    count = np.diff(node_offset)
    pairs, group = np.unique(np.column_stack([name.reshape(-1), count]), axis=0, return_inverse=True)
    cells, left = [], [np.zeros(0, dtype=np.int64)]
    for number, (which, nodes) in enumerate(pairs.tolist()):
        row = np.flatnonzero(group.reshape(-1) == number)
        kind = _kind(str(names[which]), nodes)
        if kind is None:
            left.append(row)
            continue
        order = np.array(_ORDER.get(kind, range(nodes)), dtype=np.int64)
        cells.append(Cells(kind, node_index[node_offset[row][:, None] + order], row))
    return cells, np.sort(np.concatenate(left))


def vertices(node: IntArray) -> Cells:
    """One cell for each of the points `node` [c]."""
    return Cells(VERTEX, node[:, None], np.arange(len(node)))


def bricks(first: int, count: int) -> Cells:
    """One cell for every eight points, in VTK's order, from the point `first` on."""
    return Cells(_CELLS["hexahedron", 8], first + np.arange(8 * count).reshape(count, 8), np.arange(count))


def label_of_cells(nodes: IntArray, label: IntArray) -> IntArray:
    """The label [c] that most nodes [c, n] of each cell have, the lowest of several; `label` [N] of all points."""
    out = np.empty(len(nodes), dtype=np.int64)
    for part in node_blocks(len(nodes)):
        of_node = np.sort(label[nodes[part]], axis=1)
        votes = (of_node[:, :, None] == of_node[:, None, :]).sum(axis=2)
        out[part] = np.take_along_axis(of_node, votes.argmax(axis=1)[:, None], axis=1)[:, 0]
    return out


def _kind(card: str, nodes: int) -> int | None:
    if card == "CPYRAM":
        return PYRAMID  # stored by its corners
    shape = shape_of(card, nodes)
    if shape is not None:
        return _CELLS[shape.family, shape.nodes]
    return {1: VERTEX, 2: LINE}.get(nodes)
