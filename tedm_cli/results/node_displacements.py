"""Displacements under each thermal node, as thermal.h5 has them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.contracts import THERMAL
from tedm_cli.errors import InputError
from tedm_cli.files.blocks import Blocks
from tedm_cli.files.store import Reader
from tedm_cli.results.thermal.nodes import REBUILD, node_rows

NO_DISPLACEMENTS = "has no displacements of the thermal nodes"


@dataclass(frozen=True, eq=False)
class NodeDisplacements:
    """Displacements of N grids and rotations of T of them per kelvin of each of n nodes; of an open thermal.h5.

    translation : a dataset [n, N, 3], m/K. turned : [T], rows of the grids whose rotations are there. rotation :
    [n, T, 3], rad/K. of_grid : [N], number of the node that most of each grid is in; -1: none. element : [6 E, n],
    motion of the optical elements, layout frame; none without optics. block_translation, block_rotation : [n, b, 3], of
    the compensation masses. double : whether they have the digits of the outputs, and not those of results of another
    solver.
    """

    file: Reader
    node: list[str]
    grid_id: IntArray
    of_grid: IntArray
    translation: Blocks
    turned: IntArray
    rotation: FloatArray
    element: FloatArray
    block_translation: FloatArray
    block_rotation: FloatArray
    double: bool

    def rotation_of(self, rows: IntArray) -> FloatArray:
        """[n, m, 3] of grids by their rows, all of them turned ones."""
        return np.asarray(self.rotation[:, np.searchsorted(self.turned, rows)])

    def motion_of(self, grid_id: IntArray) -> FloatArray:
        """Displacements and rotations [n, m, 6] of grids by their ids, m/K and rad/K; all of them turned ones."""
        rows = np.searchsorted(self.grid_id, grid_id)
        moved = np.array([np.asarray(self.translation[i, :])[rows] for i in range(len(self.node))])
        return np.concatenate([moved.reshape(len(self.node), len(rows), 3), self.rotation_of(rows)], axis=2)

    def output(self, label: str) -> tuple[FloatArray, FloatArray]:
        """An output [n] per kelvin of each node, and the part of it that is by no displacement."""
        row = self.file.strings(THERMAL.ROW_LABEL).index(label)
        return node_rows(self.file, [label])[0], self.file.array(THERMAL.DIRECT)[row]


def has_displacements(file: Reader) -> bool:
    """Whether an open thermal.h5 has them."""
    return file.has(THERMAL.D_TRANSLATION)


def read_node_displacements(file: Reader) -> NodeDisplacements:
    """Those of an open thermal.h5; `InputError` where it has none."""
    if not has_displacements(file):
        raise InputError(
            NO_DISPLACEMENTS, where=str(file.path), hint=f"{REBUILD}, makes them or says why there are none"
        )
    on_bench = file.has(THERMAL.D_ELEMENT)
    nodes = file.strings(THERMAL.MAP_NODE)
    return NodeDisplacements(
        file=file,
        node=nodes,
        grid_id=file.array(THERMAL.MAP_GRID),
        of_grid=file.array(THERMAL.MAP_OF_GRID),
        translation=file.dataset(THERMAL.D_TRANSLATION),
        turned=file.array(THERMAL.D_TURNED_NODE),
        rotation=file.array(THERMAL.D_ROTATION),
        element=file.array(THERMAL.D_ELEMENT) if on_bench else np.zeros((0, len(nodes))),
        block_translation=file.array(THERMAL.D_BLOCK_TRANSLATION),
        block_rotation=file.array(THERMAL.D_BLOCK_ROTATION),
        double=bool(np.isfinite(file.number(THERMAL.CHECK_RESIDUAL))),
    )
