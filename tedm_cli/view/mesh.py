"""What is drawn of a finite-element mesh: its outer surface, and of a large one a coarser surface on fewer grids.

A coarser surface stands on grids of the model, so that what moves is what was solved. Grids are put together that lie
in one cell of a lattice, belong to one thermal area, and look the same way (Rossignac and Borrel 1993, with the
direction of the faces added, so that the two sides of a wall stay apart and edges stay edges).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.fem.surface import Surface

_STEPS = 24  # of the search for the size of the cells
_SIDEWAYS = 0.3  # component of a face's normal from which on it looks along that axis


@dataclass(frozen=True, eq=False)
class DrawnMesh:
    """Faces and lines on some of the N grids of a model.

    Parameters
    ----------
    grid : [n], rows of the grid table, ascending.
    face, face_area : [F, 4] places in `grid`, a triangle repeats its last corner; [F] thermal area, -1: none.
    line, line_area : [L, 2] and [L], the same of bars and rods.
    cell_m : size of the cells in which grids were put together, m; 0: every grid of the surface is drawn.
    """

    grid: IntArray
    face: IntArray
    face_area: IntArray
    line: IntArray
    line_area: IntArray
    cell_m: float


def drawn_mesh(
    position: FloatArray, surface: Surface, face_area: IntArray, line_area: IntArray, area: IntArray, most: int
) -> DrawnMesh:
    """The outer surface and the lines of a model on at most `most` of its grids, as far as lines and areas allow.

    Parameters
    ----------
    position : [N, 3], m. surface : of the model, by rows of its grids.
    face_area, line_area, area : thermal area of each face, line and grid [N]; -1: none.
    """
    face, line, cell = surface.face, surface.line, 0.0
    used = np.unique(np.concatenate([face.reshape(-1), line.reshape(-1)]))
    if len(used) > most:
        stands_for, cell = _clustered(position, face, line, area, most)
        face, line = stands_for[face], stands_for[line]
        face, kept = _tidy(face)
        face_area = face_area[kept]
        apart = line[:, 0] != line[:, 1]
        line, line_area = line[apart], line_area[apart]
        used = np.unique(np.concatenate([face.reshape(-1), line.reshape(-1)]))
    place: IntArray = np.full(len(position), -1, dtype=np.int64)
    place[used] = np.arange(len(used))
    return DrawnMesh(used, place[face], face_area, place[line], line_area, cell)


def _clustered(
    position: FloatArray, face: IntArray, line: IntArray, area: IntArray, most: int
) -> tuple[IntArray, float]:
    """For every grid the one it is drawn at [N], and the size of the cells that leave at most `most`."""
    used = np.unique(np.concatenate([face.reshape(-1), line.reshape(-1)]))
    look = _directions(position, face)[used]
    low = position[used].min(axis=0)
    size = float(np.ptp(position[used], axis=0).max())
    ends = np.isin(used, line)  # ends of bars keep their places: a bar is nothing but them

    def clusters(cell: float) -> IntArray:
        key = np.floor((position[used] - low) / cell).astype(np.int64)
        own = np.where(ends, np.arange(len(used)) + 1, 0)
        _, number = np.unique(np.column_stack([key, look, area[used], own]), axis=0, return_inverse=True)
        return np.asarray(number.reshape(-1), dtype=np.int64)

    small, large = 0.0, size  # too many, few enough
    for _ in range(_STEPS):
        middle = size * 1e-3 if small == 0.0 and large == size else (small + large) / 2.0
        if clusters(middle).max() + 1 > most:
            small = middle
        else:
            large = middle
    cluster = clusters(large)
    count = np.bincount(cluster)
    mean = np.stack([np.bincount(cluster, position[used, c]) / count for c in range(3)], axis=1)
    away = np.linalg.norm(position[used] - mean[cluster], axis=1)
    order = np.lexsort((away, cluster))
    first = np.concatenate([[0], np.cumsum(count)[:-1]])
    stands_for = np.arange(len(position))
    stands_for[used] = used[order[first]][cluster]
    return stands_for, large


def _directions(position: FloatArray, face: IntArray) -> IntArray:
    """Which of the six directions along the axes the faces at each grid [N] look in, as bits."""
    normal = np.cross(position[face[:, 2]] - position[face[:, 0]], position[face[:, 3]] - position[face[:, 1]])
    flat = face[:, 2] == face[:, 3]
    corner = position[face[flat]]
    normal[flat] = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.divide(normal, length, out=np.zeros_like(normal), where=length > 0.0)
    bits = np.zeros(len(position), dtype=np.int64)
    for c in range(3):
        for sign, bit in ((1.0, 1 << 2 * c), (-1.0, 2 << 2 * c)):
            seen = sign * normal[:, c] > _SIDEWAYS
            bits[np.unique(face[seen])] |= bit
    return bits


def _tidy(face: IntArray) -> tuple[IntArray, IntArray]:
    """Faces [F, 4] that still have an area, each once and with its corners in a row; and the rows they come from."""
    # A corner that equals the one before it is moved to the end by sorting those that are new to the front, stably.
    before = np.roll(face, 1, axis=1)
    new = face != before
    order = np.argsort(~new, axis=1, kind="stable")
    moved = np.take_along_axis(face, order, axis=1)
    count = new.sum(axis=1)
    moved[count == 3, 3] = moved[count == 3, 2]
    crossed = (moved[:, 0] == moved[:, 2]) | (moved[:, 1] == moved[:, 3])
    rows = np.flatnonzero((count >= 3) & ~crossed)
    _, first = np.unique(np.sort(moved[rows], axis=1), axis=0, return_index=True)
    rows = rows[np.sort(first)]
    return moved[rows], rows
