"""Outputs and displacements by the columns of a case of the thermal network: nodes, then areas that it leaves out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.contracts import CASE, DISTORTION, OPTICS, THERMAL
from tedm_cli.errors import InputError
from tedm_cli.exports.node_terms import superposed
from tedm_cli.files.blocks import Blocks
from tedm_cli.files.build_folder import OPTICS_FILE, require_input
from tedm_cli.files.provenance import input_files
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.noise.differences import terms
from tedm_cli.results.node_displacements import NodeDisplacements, read_node_displacements
from tedm_cli.results.optics import read_bench_motion, read_read_outs
from tedm_cli.stages.exports.mesh_outputs import Output

_DOUBLE, _SINGLE = 1e-8, 1e-5  # sums over displacements against the adjoint, of the sum of the sizes


@dataclass(frozen=True, eq=False)
class NetworkColumns:
    """n thermal nodes, and the rows [m] of areas of the model behind them."""

    nodes: NodeDisplacements
    left: IntArray

    def output(self, of_areas: Output, build_dir: Path, distortion: Reader) -> Output:
        """An output by these columns. Raises `InputError` where optics.h5 is not there any more."""
        pair = terms(of_areas.label)
        whole = of_areas.label in self.nodes.file.strings(THERMAL.ROW_LABEL)
        signed = [(1.0, of_areas.label)] if whole or pair is None else [(1.0, pair[0]), (-1.0, pair[1])]
        found = [(sign, *self.nodes.output(label)) for sign, label in signed]
        g = _joined([sign * row for sign, row, _ in found], of_areas.g[self.left])
        within = _DOUBLE if self.nodes.double else _SINGLE
        if of_areas.elements is None or of_areas.elsewhere is None:
            return replace(of_areas, g=g, sums_within=within)
        by_node = [sign * self._elements(label, build_dir, distortion) for sign, label in signed]
        direct = [sign * part for sign, _, part in found]
        return replace(
            of_areas,
            g=g,
            sums_within=within,
            elements=_joined(by_node, of_areas.elements[:, self.left]),
            elsewhere=_joined(direct, of_areas.elsewhere[self.left]),
        )

    def _elements(self, label: str, build_dir: Path, distortion: Reader) -> FloatArray:
        """Terms [E, n] of a read-out by the elements that ride on grids."""
        with open_checked(build_dir / OPTICS_FILE, OPTICS) as file:
            r = read_read_outs(file)
        number, row = divmod(r.names.index(label), len(r.label))
        by_element = r.by_motion(r.sets[number], self.nodes.element)[row].sum(axis=1)
        return np.asarray(by_element[[r.element.index(name) for name in read_bench_motion(distortion).element]])

    def moved(self, weights: FloatArray, distortion: Reader) -> tuple[FloatArray, FloatArray]:
        """Displacements [N, 3] of the grids, and rotations [L, 3] of those with levers, under weights [n + m]."""
        n = len(self.nodes.node)
        by_node, by_area = weights[:n], np.zeros(distortion.dataset(DISTORTION.D_TRANSLATION).shape[0])
        by_area[self.left] = weights[n:]
        lever = self.nodes.rotation_of(distortion.array(DISTORTION.D_OFFSET_NODE))
        move = _sum(self.nodes.translation, by_node) + _sum(distortion.dataset(DISTORTION.D_TRANSLATION), by_area)
        turn = np.einsum("n,nlc->lc", by_node, lever) + _sum(distortion.dataset(DISTORTION.D_ROTATION), by_area)
        return move, turn


def network_columns(case: Reader, thermal: Reader, areas: list[str]) -> NetworkColumns:
    """The columns of an open case file, which is made of an open thermal.h5.

    Raises
    ------
    InputError : thermal.h5 is another than the case was made of, or has no displacements.
    """
    require_input(case, input_files([thermal.path])[0])
    nodes = read_node_displacements(thermal)
    names = case.strings(CASE.AREA_NAME)
    if not case.has(CASE.CONTRIBUTION_WEIGHT):
        hint = f"rebuild it with `{CASE.made_by}`, or `tedm run`"
        raise InputError("has no weights of its columns: it is of an older version", where=str(case.path), hint=hint)
    left = np.array([areas.index(name) for name in names[len(nodes.node) :]], dtype=np.int64)
    return NetworkColumns(nodes, left)


def _sum(dataset: Blocks, weights: FloatArray) -> FloatArray:
    return np.asarray(superposed(dataset, weights[None])[0])


def _joined(of_nodes: list[FloatArray], of_areas: FloatArray) -> FloatArray:
    """The sum of terms by nodes, and areas behind them."""
    return np.asarray(np.concatenate([np.sum(of_nodes, axis=0), of_areas], axis=-1))
