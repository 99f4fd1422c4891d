"""The solutions of the adjoint: by the embedded solver, or from the results of another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.adjoint.rounding import sizes_of_terms
from tedm_cli.arrays import FloatArray
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.distortion import ROUNDING
from tedm_cli.errors import InputError
from tedm_cli.fem.adjoint import TemperatureSensitivity, ThermalForces
from tedm_cli.fem.static import StaticReport, StaticSolution
from tedm_cli.nastran.loads.adjoint_results import adjoint_motions
from tedm_cli.nastran.loads.adjoint_rows import adjoint_rows
from tedm_cli.nastran.result_files import require_whole
from tedm_cli.progress import Step
from tedm_cli.stages.adjoint.model import WarmedModel
from tedm_cli.stages.output_inputs import OutputInputs
from tedm_cli.stages.outputs import Outputs


@dataclass(frozen=True, eq=False)
class Solved:
    """What every temperature does to r outputs, and who has solved it.

    rounding : [r, k], how far sums over the k areas may be off because the solutions are in single precision.
    report : of the embedded solver; None where `results` are those of another.
    """

    sensitivity: TemperatureSensitivity
    rounding: FloatArray
    report: StaticReport | None = None
    results: tuple[Path, ...] = ()

    @property
    def residual(self) -> float:
        """Largest relative residual of the solutions; NaN of another solver's, whose stiffness is not known here."""
        return np.nan if self.report is None else self.report.max_relative_residual


def adjoint_results(project: Project, given: Sequence[Path], target: Path) -> list[Path]:
    """The results that are to be read: those given, else those of the configuration; none where it names none.

    Raises
    ------
    InputError : a file that is not there, is the `target`, or what else `require_whole` refuses.
    """
    files = list(given) or [project.resolve(name) for name in load_model(project.model)[1].model.adjoint_op2]
    for path in files:
        if not path.exists():
            hint = "`tedm write-deck --adjoint` writes the deck, and your Nastran makes its results"
            raise InputError("no such results of the adjoint", where=str(path), hint=hint)
        if path.resolve() == target.resolve():
            raise InputError("results are where build-adjoint writes its own file", where=str(path), hint="rename them")
        require_whole(path)
    return files


def solved_here(outputs: Outputs, model: WarmedModel, step: Step) -> Solved:
    """By the embedded solver. Raises what it does."""
    solution = StaticSolution(model.structure, progress=step)
    found = solution.adjoint(outputs.force, outputs.label)
    return Solved(found, np.zeros_like(outputs.wanted), solution.report)


def solved_elsewhere(
    results: Sequence[Path], outputs: Outputs, model: WarmedModel, given: OutputInputs, step: Step
) -> Solved:
    """From the results of the deck of `write-deck --adjoint`, with the thermal forces of the elements here.

    Raises
    ------
    InputError : what `adjoint_motions` refuses.
    PhysicsError : elements with an impossible shape.
    """
    geometry = model.geometry
    rows = adjoint_rows(outputs.label, outputs.force, geometry.units, str(given.deck))
    step(0, 2, "reading displacements")
    solved, double = adjoint_motions(results, rows, geometry, given.raw.spoints)
    motion, single = np.zeros_like(outputs.force), np.zeros(len(outputs.label))
    place = [outputs.label.index(row.output) for row in rows]  # what nothing acts on has no subcase, and stays zero
    motion[:, place], single[place] = solved, ~double
    step(1, 2, "thermal forces")
    forces = ThermalForces.assembled(model.structure)
    rounding = ROUNDING * single[:, None] * sizes_of_terms(forces, model.own, model.areas, motion)
    step(2, 2, "thermal forces")
    return Solved(forces.sensitivity(motion), rounding, results=tuple(results))
