"""view, the thermal nodes: columns of the page behind the thermal areas, for cases and series of them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.config.project import Project
from tedm_cli.contracts import CASE
from tedm_cli.files.store import Reader
from tedm_cli.noise.areas import AreaTable
from tedm_cli.results.build_folder import Results
from tedm_cli.results.gravity.compensation import Blocks
from tedm_cli.results.node_displacements import NodeDisplacements, has_displacements, read_node_displacements
from tedm_cli.results.outputs import ModelOutputs
from tedm_cli.results.thermal.case_shares import of_network
from tedm_cli.results.thermal.nodes import node_outputs


@dataclass(frozen=True, eq=False)
class ShownNodes:
    """n thermal nodes that the page shows behind k areas.

    table : the nodes, with groups as areas. rows : [n_out, n], with the differences. left : rows of the areas that
    stand behind the nodes in cases and series of them.
    """

    displacements: NodeDisplacements
    table: AreaTable
    rows: FloatArray
    left: IntArray
    areas: int

    def columns(self, values: FloatArray) -> FloatArray:
        """The columns of the page [k + n, ...] of nodes, and of areas behind them [n + m, ...]."""
        n = len(self.table)
        out = np.zeros((self.areas + n, *values.shape[1:]))
        out[self.areas :] = values[:n]
        out[self.left] = values[n:]
        return out

    def padded(self, values: FloatArray) -> FloatArray:
        """Of the areas [k, ...] the columns of the page [k + n, ...]: nodes have nothing of their own."""
        nothing = np.zeros((len(self.table), *values.shape[1:]))
        return np.asarray(np.concatenate([values, nothing]))

    def and_nodes(self, blocks: Blocks) -> Blocks:
        """Compensation masses with their motion under the nodes behind that under the areas."""
        moved, d = self.displacements, (blocks.translation, blocks.rotation)
        return replace(
            blocks,
            translation=np.concatenate([d[0], moved.block_translation]),
            rotation=np.concatenate([d[1], moved.block_rotation]),
        )

    def on(self, row: IntArray, otherwise: IntArray) -> IntArray:
        """Columns of what is in nodes by their numbers, of its area where it is in none."""
        return np.asarray(np.where(row >= 0, row + self.areas, otherwise))


def shown_nodes(project: Project, results: Results, of_model: ModelOutputs) -> ShownNodes | None:
    """The nodes of thermal.h5, where cases or series of them were run and it has their displacements.

    Raises
    ------
    InputError : thermal.h5 is stale.
    """
    by_nodes = any(shows_nodes(file) for file in results.cases)
    by_nodes = by_nodes or any(t.of == "nodes" and t.name in results.series for t in results.config.series)
    if results.thermal is None or not by_nodes or not has_displacements(results.thermal):
        return None
    found = node_outputs(project, of_model, "the page")
    moved = read_node_displacements(results.thermal)
    n = len(moved.node)
    outputs = found.outputs.with_differences(results.config.applied_requirements())
    table = outputs.areas.only(np.arange(len(outputs.areas)) < n)
    return ShownNodes(moved, table, outputs.rows[:, :n], np.asarray(found.left), len(of_model.areas))


def shows_nodes(file: Reader) -> bool:
    """Whether an open case file is of thermal nodes, and says which temperatures go with its outputs."""
    return of_network(file) and file.has(CASE.CONTRIBUTION_WEIGHT)
