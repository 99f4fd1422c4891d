"""Displacements under each thermal node: by the embedded solver, by another, or weighted from those under the areas."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.adjoint.agreement import agreement
from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.config.project import Project
from tedm_cli.config.thermal.map import MapTable
from tedm_cli.contracts import ADJOINT, OPTICS, SENSITIVITY, UNIT_LOADS
from tedm_cli.contracts import THERMAL as KIND
from tedm_cli.distortion import ROUNDING
from tedm_cli.errors import PhysicsError
from tedm_cli.fem.adjoint import TemperatureSensitivity
from tedm_cli.fem.static import StaticSolution
from tedm_cli.fem.structure import LoadCase, Structure
from tedm_cli.files.build_folder import ADJOINT_FILE, require_input
from tedm_cli.files.store import Writer, open_checked
from tedm_cli.gravity.ties import Follower, follower
from tedm_cli.mapping.averages import NONE
from tedm_cli.nastran.loads.loads_results import load_motions
from tedm_cli.nastran.result_files import require_whole
from tedm_cli.nastran.structure.deck import solver_structure
from tedm_cli.optics.chain import element_motion
from tedm_cli.progress import Step
from tedm_cli.stages.material_changes import MaterialChanges, unit_motions
from tedm_cli.stages.output_inputs import OutputInputs, output_inputs
from tedm_cli.stages.outputs import Outputs
from tedm_cli.stages.thermal.changes import PositionChanges, changes_here, changes_of_areas, write_changes
from tedm_cli.stages.thermal.map import NodeSensitivity
from tedm_cli.stages.thermal.map_build import Mapping

LIMIT = 1e-8
"""Largest difference of both routes that is allowed, over the largest sensitivity of the block."""
_BATCH = 16  # motions that are held at a time
_DECK = "`tedm write-deck --thermal-nodes` writes the deck anew; solve it with the solver of the adjoint's results"


def node_fields(mapping: Mapping) -> FloatArray:
    """Temperatures [N, n] of the grids per kelvin of each node; 0 where the map does not reach."""
    return np.nan_to_num(mapping.through.temperatures(np.eye(len(mapping.node))))


@dataclass(frozen=True, eq=False)
class NodeLoads:
    """The thermal nodes of a map as loads of the unit-load deck.

    adjoint : where adjoint.h5 is. results : of another solver; none where the embedded solver solves.
    """

    given: OutputInputs
    mapped: NodeSensitivity
    outputs: Outputs
    adjoint: Path
    structure: Structure | None
    results: tuple[Path, ...]

    @property
    def mapping(self) -> Mapping:
        assert self.mapped.mapping is not None
        return self.mapped.mapping


@contextlib.contextmanager
def node_loads(project: Project, table: MapTable, mapped: NodeSensitivity) -> Iterator[NodeLoads | str]:
    """What the displacements are made of, or why there are none.

    Raises
    ------
    InputError : a file that is missing or stale, results that are not there or cut short.
    """
    if mapped.why or mapped.mapping is None:
        yield mapped.why or "there is no map"
        return
    if not table.displacements:
        yield "`displacements = false` in [map]"
        return
    where = project.required_thermal()
    results = tuple(project.beside(where, name) for name in table.results)
    for path in results:
        require_whole(path)
    with output_inputs(project, "displacements of the thermal nodes") as given:
        with open_checked(project.build_dir / ADJOINT_FILE, ADJOINT) as file:
            for item in given.trace.inputs:
                require_input(file, item)
        outputs = given.outputs(mapped.mapping.fem.geometry.grid_id)
        known = [outputs.label.index(label) for label in mapped.label]
        chosen = Outputs(
            label=mapped.label,
            unit=mapped.unit,
            block=[outputs.block[i] for i in known],
            force=outputs.force[:, known],
            wanted=outputs.wanted[known],
            direct=outputs.direct[known],
            rounding=outputs.rounding[known],
        )
        weighted = mapped.mapping.weights is not None
        structure = None if weighted or results else solver_structure(given.raw, given.deck)[0]
        yield NodeLoads(given, mapped, chosen, project.build_dir / ADJOINT_FILE, structure, results)


def write_displacements(writer: Writer, loads: NodeLoads, step: Step) -> str:
    """Write the displacements, and hold the outputs by them against those by the adjoint; why there are none, or "".

    Raises
    ------
    InputError : results of other loads or of another model.
    PhysicsError : outputs that differ.
    """
    solution, adjoint = None, None
    if loads.structure is not None:
        try:
            solution = StaticSolution(loads.structure, progress=step)
        except PhysicsError as exc:
            return exc.fact
        adjoint = solution.adjoint(loads.outputs.force, loads.outputs.label)
        if fact := _other_elements(loads, adjoint):
            return fact
    moved = _Moved(writer, loads)
    found = _changes(loads, adjoint, _some_at_a_time(moved, _motions(loads, solution)), step)
    if found is not None:
        write_changes(writer, *found)
    moved.finish(loads, np.nan if solution is None else solution.report.max_relative_residual)
    return ""


def _some_at_a_time(moved: _Moved, motions: Iterator[tuple[int, FloatArray]]) -> Iterator[FloatArray]:
    """The same motions, each kept by `moved`, some in one [6 N, m]; that of all nodes together left out."""
    held: list[FloatArray] = []
    for k, motion in motions:
        moved.add(k, motion)
        if k != NONE:
            held.append(motion.reshape(-1))
        if len(held) == _BATCH:
            yield np.array(held).T
            held = []
    if held:
        yield np.array(held).T


def _changes(
    loads: NodeLoads,
    adjoint: TemperatureSensitivity | None,
    motions: Iterator[FloatArray],
    step: Step,
) -> tuple[MaterialChanges, list[int], list[int]] | None:
    """What uncertain materials and thicknesses change, while the `motions` are used up; None where none is uncertain.

    Of another solver's results nothing: the adjoint of these is not here.
    """
    wanted, mapping = bool(loads.given.config.uncertainty.of_structure), loads.mapping
    if wanted and adjoint is not None and loads.structure is not None:
        fields = node_fields(mapping)
        return changes_here(loads.given, loads.structure, mapping, fields, adjoint, motions, step)
    for _ in motions:
        pass
    if not wanted or mapping.weights is None:
        return None
    with open_checked(loads.adjoint, ADJOINT) as file:
        names = file.strings(ADJOINT.AREA_NAME)
        return changes_of_areas(file, [names.index(name) for name in mapping.fem.areas], mapping.weights)


def _other_elements(loads: NodeLoads, found: TemperatureSensitivity) -> str:
    """Whether the adjoint is of other elements than those here: before anything is solved for the nodes."""
    here = found.grid @ node_fields(loads.mapping) + loads.mapped.direct
    none = np.zeros(len(loads.mapping.node), dtype=bool)
    agreed = agreement(here, loads.mapped.value, np.zeros_like(here), loads.outputs.block, none)
    row, column = agreed.worst
    if agreed.difference[row, column] <= LIMIT:
        return ""
    return (
        f"adjoint.h5 is of another solver, whose elements differ from those of `tedm solve` by"
        f" {agreed.difference[row, column]:.1g} in {loads.outputs.label[row]}: name the results of your solver in"
        f" `results` of [map] (`tedm write-deck --thermal-nodes` writes the deck)"
    )


def _motions(loads: NodeLoads, solution: StaticSolution | None) -> Iterator[tuple[int, FloatArray]]:
    """Motions [N, 6] of the grids under 1 K on each node by its number; of the embedded solver last all at once, -1."""
    mapping = loads.mapping
    if mapping.weights is not None:
        yield from enumerate(_weighted(loads, mapping.weights))
    elif solution is None:
        points = frozenset(loads.given.raw.spoints)
        yield from load_motions(loads.results, mapping.node, mapping.fem.geometry, points)
    else:
        fields = node_fields(mapping)
        together = mapping.through.mapped.astype(np.float64)
        cases = [LoadCase(id=i, label=name, temperature=fields[:, i]) for i, name in enumerate(mapping.node)]
        yield from solution.solve([*cases, LoadCase(id=NONE, label="all nodes", temperature=together)])


def _weighted(loads: NodeLoads, weights: FloatArray) -> FloatArray:
    """Motions [n, N, 6] from those under the unit loads of the areas."""
    names = [str(name) for name in loads.given.unit.strings(UNIT_LOADS.AREA_NAME)]
    by_area = np.zeros((len(names), weights.shape[1]))
    by_area[[names.index(name) for name in loads.mapping.fem.areas]] = weights
    out, start = np.zeros((weights.shape[1], len(loads.outputs.force))), 0
    for motion in unit_motions(loads.given.unit):
        out += by_area[start : start + motion.shape[1]].T @ motion.T
        start += motion.shape[1]
    return out.reshape(len(out), -1, 6)


class _Moved:
    """The datasets as they are filled, node by node."""

    def __init__(self, writer: Writer, loads: NodeLoads) -> None:
        geometry, given = loads.mapping.fem.geometry, loads.given
        n, grids = len(loads.mapping.node), len(geometry.grid_id)
        self._writer, self._force = writer, loads.outputs.force
        self._translation = writer.allocate(KIND.D_TRANSLATION, (n, grids, 3))
        turned = [given.sensitivity.array(SENSITIVITY.OPERATOR_OFFSET_NODE)]
        if given.read_out is not None:
            ids = [element.grid for element in given.read_out[1].bench]
            turned.append(np.searchsorted(geometry.grid_id, np.array(ids, dtype=np.int64)))
        self.turned = np.unique(np.concatenate(turned))
        self._layout = None if given.read_out is None else given.read_out[1]
        self._bench = turned[-1] if given.read_out is not None else np.zeros(0, dtype=np.int64)
        self.optical = np.zeros((n, len(self._bench), 6))
        self.rotation = np.zeros((n, len(self.turned), 3))
        self._follow = _followers(given, geometry.position_m)
        self.blocks = np.zeros((n, len(self._follow), 6))
        self.found, self.rounding = np.zeros((2, len(loads.outputs.label), n))
        self._size = np.linalg.norm(self._force.reshape(-1, 3, len(loads.outputs.label)), axis=1)
        self._positions = PositionChanges(given.sensitivity)
        self._sum, self._together = np.zeros((grids, 3)), None if loads.structure is None else np.zeros((grids, 3))

    def add(self, k: int, motion: FloatArray) -> None:
        """The motion [N, 6] under 1 K of node k; -1: of all nodes."""
        if k == NONE:
            self._together = motion[:, :3]
            return
        self._translation[k] = motion[:, :3]
        self._sum += motion[:, :3]
        self._positions.add(k, motion)
        self.rotation[k] = motion[self.turned, 3:]
        self.optical[k] = motion[self._bench]
        for b, (rows, fit) in enumerate(self._follow):
            if rows.size:
                self.blocks[k, b] = fit.motion(motion[None, rows, :3], motion[None, rows, 3:])[0]
        self.found[:, k] = self._force.T @ motion.reshape(-1)
        self.rounding[:, k] = ROUNDING * (self._size.T @ np.linalg.norm(motion.reshape(-1, 3), axis=1))

    def finish(self, loads: NodeLoads, residual: float) -> None:
        """Write the rest; `PhysicsError` where an output is not that of the adjoint."""
        write, wanted = self._writer.write, loads.mapped.value
        exact = loads.structure is not None
        rounding = np.zeros_like(wanted) if exact else self.rounding
        none = np.zeros(wanted.shape[1], dtype=bool)
        agreed = agreement(self.found + loads.mapped.direct, wanted, rounding, loads.outputs.block, none)
        allowed = np.full_like(wanted, LIMIT) if exact else agreed.allowed
        row, column = np.unravel_index((agreed.difference / allowed).argmax(), wanted.shape)
        if agreed.difference[row, column] > allowed[row, column]:
            raise PhysicsError(
                f"thermal node {loads.mapping.node[column]}: {loads.outputs.label[row]} by its displacements differs"
                f" from that by the adjoint by {agreed.difference[row, column]:.2g} of the largest; allowed"
                f" {allowed[row, column]:.1e}",
                where=", ".join(map(str, loads.results or [loads.given.deck])),
                hint=f"are these results of the deck as it is, and of the same solver? {_DECK}",
            )
        write(KIND.MAP_OF_GRID, _node_of_grid(loads.mapping))
        write(KIND.D_TURNED_NODE, self.turned)
        write(KIND.D_ROTATION, self.rotation)
        write(KIND.D_BLOCK_TRANSLATION, self.blocks[..., :3])
        write(KIND.D_BLOCK_ROTATION, self.blocks[..., 3:])
        if self._layout is not None and loads.given.read_out is not None:
            write(KIND.LABEL_ELEMENT_DOF, loads.given.read_out[0].strings(OPTICS.LABEL_ELEMENT_DOF))
            write(KIND.D_ELEMENT, element_motion(self._layout, self.optical))
        self._positions.write(self._writer)
        write(KIND.DIRECT, loads.mapped.direct)
        write(KIND.CHECK_DIFFERENCE, agreed.difference)
        write(KIND.CHECK_UNIFORM, self._uniform())
        write(KIND.CHECK_RESIDUAL, residual)

    def _uniform(self) -> float:
        if self._together is None:
            return np.nan
        error = np.linalg.norm(self._sum - self._together, axis=1).max()
        return float(error / (np.linalg.norm(self._together, axis=1).max() or 1.0))


def _followers(given: OutputInputs, position: FloatArray) -> list[tuple[IntArray, Follower]]:
    """Of each compensation mass the rows of the grids that it follows, none of one that stays still, and how."""
    file = given.sensitivity
    offset, index = file.array(SENSITIVITY.COMPENSATION_NODE_OFFSET), file.array(SENSITIVITY.COMPENSATION_NODE_INDEX)
    rows = [index[a:b] for a, b in itertools.pairwise(offset)]
    centre = file.array(SENSITIVITY.COMPENSATION_CENTRE)
    return [(r, follower(position[r] if r.size else position[:1], c)) for r, c in zip(rows, centre, strict=True)]


def _node_of_grid(mapping: Mapping) -> IntArray:
    """The node [N] that most of the volume at each grid is in; -1: none."""
    fem = mapping.fem
    n, grids = len(mapping.node), len(fem.geometry.grid_id)
    if mapping.weights is not None:
        area = fem.grid_area()
        most = np.where(mapping.weights.any(axis=1), mapping.weights.argmax(axis=1), NONE)
        return np.asarray(np.where(area == NONE, NONE, most[area]))
    assert mapping.association is not None
    node, of = mapping.association.place_node, fem.volumes
    taken = node != NONE
    part = np.zeros((grids, n))
    np.add.at(part, (of.node_index[taken], node[taken]), np.abs(of.volume[taken]))
    return np.where(part.any(axis=1), part.argmax(axis=1), NONE)
