"""build-loads: other loads than temperature as columns beside [D], by the embedded solver; natural frequencies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.loads import INTERFACE, load_loads
from tedm_cli.config.project import Project
from tedm_cli.contracts import LOADS, UNIT_LOADS
from tedm_cli.distortion import RigidFit
from tedm_cli.errors import ConfigError, PhysicsError
from tedm_cli.fem.constraints import rigid_body_matrix
from tedm_cli.fem.modes import NaturalModes, natural_modes
from tedm_cli.fem.static import StaticSolution
from tedm_cli.fem.structure import Structure
from tedm_cli.files.build_folder import LOADS_FILE
from tedm_cli.files.store import Reader, Writer, create, open_checked
from tedm_cli.nastran.loads.loads_results import load_motions
from tedm_cli.nastran.result_files import require_whole
from tedm_cli.progress import Step
from tedm_cli.results.loads import LoadResults, read_loads
from tedm_cli.stages.common import out_path
from tedm_cli.stages.loads.model import LoadedModel, loaded_model
from tedm_cli.stages.loads.optics import Bench, write_optics
from tedm_cli.stages.output_inputs import OutputInputs, output_inputs
from tedm_cli.stages.outputs import Outputs

_PER = "{} per /load/unit"


@dataclass(frozen=True, eq=False)
class LoadsSummary:
    """What was made; `no_read_outs`: why these are not among the outputs, empty where they are."""

    path: Path
    results: LoadResults
    no_read_outs: str


def build_loads(project: Project, output: Path | None, step: Step, *, results: Sequence[Path] = ()) -> LoadsSummary:
    """Solve the loads of the project with one factorisation, and find what they do to outputs and beams.

    Parameters
    ----------
    results : of the deck of `write-deck --loads`, solved elsewhere; where none are given, the embedded solver solves.

    Raises
    ------
    ConfigError : the project names no loads, or what the deck has not; the model has no test masses.
    InputError : a file that is missing or stale; cards that the embedded solver does not model; results of other
        loads or of another model.
    PhysicsError : the structure is not held; it has no mass.
    """
    path = project.required_loads()
    file, config = load_loads(path)
    out = out_path(project, LOADS_FILE, output)
    for name in results:
        require_whole(name)
    with output_inputs(project, "the effect of loads", results, [file]) as given:
        model = loaded_model(project, config, path, given.raw)
        if not model.loads and not config.modes.number:
            raise ConfigError([("", "has no load, and asks for no modes")], where=str(path))
        outputs = given.outputs(model.structure.grid_id)
        with create(out, LOADS, given.trace) as writer:
            try:
                _write(writer, given, model, outputs, _Solved(model, results, step))
                if config.modes.number:
                    _write_modes(writer, natural_modes(model.structure, model.mass, config.modes.number))
            except PhysicsError as exc:  # the solver knows elements and grids, and no file
                raise PhysicsError(exc.fact, where=exc.where or str(given.deck), hint=exc.hint) from exc
        no_read_outs = given.no_read_outs
    with open_checked(out, LOADS) as written:
        return LoadsSummary(out, read_loads(written), no_read_outs)


def _write(writer: Writer, given: OutputInputs, model: LoadedModel, outputs: Outputs, solved: _Solved) -> None:
    structure, loads = model.structure, model.loads
    writer.write(LOADS.GRID_ID, structure.grid_id)
    writer.write(LOADS.LOAD_NAME, [c.name for c in loads])
    writer.write(LOADS.LOAD_KIND, [c.kind for c in loads])
    writer.write(LOADS.LOAD_UNIT, [c.unit for c in loads])
    writer.write(LOADS.LOAD_FOOT, [c.foot for c in loads])
    fit = _Fit(structure, given.unit)
    target = writer.allocate(
        LOADS.TRANSLATION, (len(loads), structure.n_grids, 3), units=_PER.format("m"), single=False
    )
    rigid, largest, distortion = np.zeros((len(loads), 6)), np.zeros(len(loads)), np.zeros(len(loads))
    whole, as_one = np.zeros((2, len(outputs.label), len(loads)))
    bench = None if given.read_out is None else Bench.on(given.read_out, structure)
    optical = np.zeros((len(loads), 0 if bench is None else len(bench.node), 6))
    for k, motion in solved.motions():
        rigid[k] = fit.of(motion)
        moved = fit.motion(rigid[k])
        target[k] = motion[:, :3]
        largest[k] = np.linalg.norm(motion[:, :3], axis=1).max()
        distortion[k] = np.linalg.norm((motion - moved)[:, :3], axis=1).max()
        whole[:, k] = outputs.force.T @ motion.reshape(-1)
        as_one[:, k] = outputs.force.T @ moved.reshape(-1)
        if bench is not None:
            optical[k] = motion[bench.node]
    writer.write(LOADS.RIGID_TRANSLATION, rigid[:, :3], units=_PER.format("m"))
    writer.write(LOADS.RIGID_ROTATION, rigid[:, 3:], units=_PER.format("rad"))
    writer.write(LOADS.LARGEST, largest, units=_PER.format("m"))
    writer.write(LOADS.LARGEST_DISTORTION, distortion, units=_PER.format("m"))
    writer.write(LOADS.ROW_LABEL, outputs.label)
    writer.write(LOADS.ROW_UNIT, [unit.removesuffix("/K") for unit in outputs.unit])
    if bench is not None:
        read_rigid = write_optics(writer, bench, optical, [column.kind != "motion" for column in loads])
        as_one[len(outputs.label) - len(read_rigid) :] = read_rigid
    writer.write(LOADS.OUTPUT, whole, units=_PER.format("see /row/unit,"))
    writer.write(LOADS.OUTPUT_DISTORTION, whole - as_one, units=_PER.format("see /row/unit,"))
    together = np.array([column.foot == INTERFACE for column in loads], dtype=bool)
    share = distortion[together] / largest[together]
    writer.write(LOADS.CHECK_INTERFACE, float(share.max(initial=0.0)))
    writer.write(LOADS.CHECK_RESIDUAL, solved.residual)


class _Solved:
    """Motions [N, 6] of the loads by their places: by the embedded solver, or from the results of another."""

    def __init__(self, model: LoadedModel, results: Sequence[Path], step: Step) -> None:
        self._model, self._results = model, results
        self._solution = None if results else StaticSolution(model.structure, mass=model.mass, progress=step)

    def motions(self) -> Iterator[tuple[int, FloatArray]]:
        """Raises what `load_motions` or `StaticSolution.solve` do."""
        m = self._model
        if self._solution is None:
            yield from load_motions(self._results, [c.name for c in m.loads], m.geometry, m.scalar_points)
            return
        for k, (_, motion) in enumerate(self._solution.solve([column.case for column in m.loads])):
            yield k, motion

    @property
    def residual(self) -> float:
        """Largest relative residual; NaN of another solver's results, whose stiffness is not known here."""
        return np.nan if self._solution is None else self._solution.report.max_relative_residual


class _Fit:
    """Motion of the whole structure as one: the best fit of the grids weighted by their mass."""

    def __init__(self, structure: Structure, unit: Reader) -> None:
        centre = unit.array(UNIT_LOADS.MASS_CENTRE_OF_GRAVITY)
        self._fit = RigidFit(structure.position, unit.array(UNIT_LOADS.MASS_LUMPED), centre)
        self._motions = rigid_body_matrix(structure.position - centre)

    def of(self, motion: FloatArray) -> FloatArray:
        """Translation at the centre of gravity and rotation, [6], of motions [N, 6]."""
        moments = self._fit.moments(slice(None), motion[:, :3])
        return np.asarray(np.concatenate(self._fit.motions(moments[None]), axis=1)[0])

    def motion(self, rigid: FloatArray) -> FloatArray:
        """Motions [N, 6] of all grids by a rigid one [6]."""
        return np.asarray(self._motions @ rigid)


def _write_modes(writer: Writer, modes: NaturalModes) -> None:
    writer.write(LOADS.MODE_FREQUENCY, modes.frequency_hz)
    writer.write(LOADS.MODE_EFFECTIVE_MASS, modes.effective_mass)
    writer.write(LOADS.MODE_MASS, modes.mass)
    writer.write(LOADS.MODE_RIGID, list(modes.rigid))
