"""The outer surface of a finite-element model: free faces of its solids, its plates, and its line elements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, IntArray
from tedm_cli.fem.shapes import CARDS, corner_count

# Corners of the faces by card, seen from outside counter-clockwise; a triangle repeats its last corner.
_HEXA = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
_PENTA = [(0, 2, 1, 1), (3, 4, 5, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)]
_TETRA = [(0, 2, 1, 1), (0, 1, 3, 3), (1, 2, 3, 3), (2, 0, 3, 3)]
_PYRAM = [(0, 3, 2, 1), (0, 1, 4, 4), (1, 2, 4, 4), (2, 3, 4, 4), (3, 0, 4, 4)]
_SOLID = {"CHEXA": _HEXA, "CPENTA": _PENTA, "CTETRA": _TETRA, "CPYRAM": _PYRAM}
_PLATE = {3: [(0, 1, 2, 2)], 4: [(0, 1, 2, 3)]}


@dataclass(frozen=True, eq=False)
class Surface:
    """Faces and lines by rows of the grid table.

    face : [F, 4], corners in order; a triangle repeats its last. Faces of solids are counter-clockwise from outside.
    solid : [F], whether a face is of a solid (else of a plate). line : [L, 2].
    rim : [R, 2], edges that only one plate has.
    face_at, line_at, rim_at : where each corner of these stands in the ragged connectivity, and so in which element.
    """

    face: IntArray
    solid: BoolArray
    line: IntArray
    rim: IntArray
    face_at: IntArray
    line_at: IntArray
    rim_at: IntArray


def outer_surface(card: Sequence[str], node_offset: IntArray, node_index: IntArray) -> Surface:
    """Outer surface of a mesh by its corners; faces that two solids share, whatever their cards, are inside.

    Parameters
    ----------
    card : [E], Nastran card names; other cards with two nodes count as lines, others still are left out.
    node_offset, node_index : ragged connectivity, [E + 1] and [M] rows of the grid table, corners first.
    """
    names, kind = np.unique(np.array(card, dtype=object).astype(str), return_inverse=True)
    counts = np.diff(node_offset)
    solid, plate, line = [], [], []
    for number, name in enumerate(names):
        members = np.flatnonzero(kind.reshape(-1) == number)
        corners = corner_count(str(name))
        shape = CARDS[str(name)][0].dimension if corners is not None else 0
        if name in _SOLID:
            solid.append(_faces(_SOLID[str(name)], members, node_offset))
        elif shape == 2 and corners is not None:
            plate.append(_faces(_PLATE[corners], members, node_offset))
        else:
            line.append(_faces([(0, 1)], members[counts[members] == 2], node_offset))
    face_at = _joined(solid, 4)
    key = _keys(node_index[face_at])
    _, index, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    free = (count[index.reshape(-1)] == 1) & (key[:, 2] != _NONE)  # a face collapsed to an edge has no area
    shells, lines = _joined(plate, 4), _joined(line, 2)
    faces, rim = np.concatenate([face_at[free], shells]), _rim(shells, node_index)
    return Surface(
        face=node_index[faces],
        solid=np.arange(len(faces)) < free.sum(),
        line=node_index[lines],
        rim=node_index[rim],
        face_at=faces,
        line_at=lines,
        rim_at=rim,
    )


_NONE = np.iinfo(np.int64).max


def _faces(pattern: Sequence[tuple[int, ...]], members: IntArray, offset: IntArray) -> IntArray:
    """Places in the ragged connectivity of the corners of all faces of some elements."""
    table = np.array(pattern, dtype=np.int64)
    return np.asarray((offset[members][:, None, None] + table).reshape(-1, table.shape[1]))


def _joined(parts: list[IntArray], width: int) -> IntArray:
    return np.concatenate([np.zeros((0, width), dtype=np.int64), *parts])


def _rim(face_at: IntArray, node_index: IntArray) -> IntArray:
    """Edges that only one plate has, by places, the lower row of the grid table first."""
    places = np.stack([face_at, np.roll(face_at, -1, axis=1)], axis=2).reshape(-1, 2)
    places = np.take_along_axis(places, np.argsort(node_index[places], axis=1), axis=1)
    edges = node_index[places]
    real = edges[:, 0] != edges[:, 1]
    _, first, count = np.unique(edges[real], axis=0, return_index=True, return_counts=True)
    return np.asarray(places[real][first[count == 1]])


def _keys(face: IntArray) -> IntArray:
    """Distinct corners in ascending order, so that a triangle and a quadrilateral collapsed to it are the same."""
    key = np.sort(face, axis=1)
    key[:, 1:][key[:, 1:] == key[:, :-1]] = _NONE
    return np.sort(key, axis=1)
