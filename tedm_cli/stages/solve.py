"""Solve a unit-load deck with the embedded solver and write the displacements as an OP2 file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tedm_cli.config.model import load_model
from tedm_cli.config.project import Project
from tedm_cli.errors import ConfigError
from tedm_cli.fem.static import StaticReport, StaticSolution
from tedm_cli.nastran.op2_writer import write_op2
from tedm_cli.nastran.solver.deck import read_solver_deck
from tedm_cli.progress import Step


@dataclass(frozen=True, kw_only=True)
class SolveReport:
    """Size of the model and quality of its solution."""

    n_grids: int
    n_solids: int
    n_bars: int
    n_rods: int
    n_shells: int
    n_cases: int
    static: StaticReport


def solve_deck(deck: Path, op2: Path, progress: Step | None = None) -> SolveReport:
    """Read `deck`, solve its subcases and write `op2`.

    Parameters
    ----------
    deck : SOL 101 deck with one temperature load per subcase.
    op2 : file to write; replaced only when everything succeeded.
    progress : called as (done, total, what), or None.

    Raises
    ------
    InputError
        If the deck cannot be read or holds what the solver does not model.
    PhysicsError
        If the structure is not held or the solution is not accurate.
    """
    structure, cases = read_solver_deck(deck)
    labels = {case.id: case.label for case in cases}
    solution = StaticSolution(structure, progress=progress)
    motions = solution.solve(cases)
    write_op2(
        op2,
        structure.grid_id,
        ((number, labels[number], structure.in_displacement_frames(motion)) for number, motion in motions),
    )
    return SolveReport(
        n_grids=structure.n_grids,
        n_solids=len(structure.hexes.element_id),
        n_bars=len(structure.bars.element_id),
        n_rods=len(structure.rods.element_id),
        n_shells=len(structure.quads.element_id) + len(structure.trias.element_id),
        n_cases=len(cases),
        static=solution.report,
    )


def solve(project: Project, output: Path | None, step: Step) -> tuple[Path, SolveReport]:
    """Solve the configured unit-load deck; the results go where the model configuration expects them.

    Raises
    ------
    ConfigError
        If the configuration names several result files: the embedded solver writes one.
    """
    file, config = load_model(project.model)
    if output is None and len(config.model.op2) != 1:
        raise ConfigError([("model.op2", "names several files, the embedded solver writes one")], where=str(file.path))
    out = output if output is not None else project.resolve(config.model.op2[0])
    return out, solve_deck(project.resolve(config.model.deck), out, step)
