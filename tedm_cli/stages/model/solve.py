"""Solve a deck with the embedded solver and write the displacements as an OP2 file."""

from __future__ import annotations

import resource
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tedm_cli.config.model.file import ModelConfig, load_model
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.config.project import Project
from tedm_cli.deck_units import SI, DeckUnits
from tedm_cli.errors import ConfigError, MemoryShortError, PhysicsError, UsageError
from tedm_cli.fem.drilling import DrillingChange
from tedm_cli.fem.linear import MemoryNeed
from tedm_cli.fem.static import StaticReport, StaticSolution
from tedm_cli.fem.structure import LoadCase, SolidBlock, Structure
from tedm_cli.nastran.geometry import ModelGeometry, model_geometry
from tedm_cli.nastran.loads.unit_load_control import check_unit_load_control
from tedm_cli.nastran.op2.writer import write_op2
from tedm_cli.nastran.reading import cross_reference, passed_over, read_deck
from tedm_cli.nastran.run import OP2, results_suffix, run_nastran
from tedm_cli.nastran.structure.deck import solver_structure
from tedm_cli.nastran.structure.masses import model_mass
from tedm_cli.progress import Step
from tedm_cli.stages.common import refuse_own_place
from tedm_cli.stages.layout_match import require_layout_fits


@dataclass(frozen=True, kw_only=True)
class OwnTemperatures:
    """Elements that do not follow their grids in some load case: their number, that of those with gradients, and the
    ids of those whose gradients do nothing, because they do not bend."""

    elements: int
    gradients: int
    idle: tuple[int, ...]


@dataclass(frozen=True, kw_only=True)
class SolveReport:
    """Size of the model and quality of its solution.

    Attributes
    ----------
    n_grids, n_cases : numbers.
    solids : number of solids by kind, such as "CHEXA8 with bubbles".
    others : number of bars, rods, CQUAD4 and CTRIA3.
    bending_change : relative change of the displacements if all linear hexahedra and pentahedra had bubble functions;
        None where they all have them.
    drilling_change : how far a larger K6ROT would move the grids; None without shells, or with K6ROT of zero.
    linear_tetrahedra : number of tetrahedra of four grids.
    peak_bytes : largest memory that the process has held.
    own_temperatures : elements with temperatures of their own.
    notes : what of the deck was not read.
    turned_element : the optical element whose rotation changes most with K6ROT, and by how much of the largest rotation
        of any grid; None where no elements are known.
    """

    n_grids: int
    solids: dict[str, int]
    others: dict[str, int]
    n_cases: int
    bending_change: float | None
    drilling_change: DrillingChange | None
    linear_tetrahedra: int
    peak_bytes: int
    static: StaticReport
    own_temperatures: OwnTemperatures
    notes: list[str]
    turned_element: tuple[str, float] | None = None


def solve_deck(
    deck: Path,
    op2: Path,
    progress: Step | None = None,
    *,
    allow_missing_enddata: bool = False,
    units: DeckUnits = SI,
    fits: Callable[[ModelGeometry], None] | None = None,
    unit_loads: bool = False,
    superelements: bool = False,
    told: Callable[[MemoryNeed], None] | None = None,
) -> SolveReport:
    """Read `deck`, solve its subcases in SI and write `op2` in the units of the deck, as any Nastran would.

    Parameters
    ----------
    deck : SOL 101 deck.
    op2 : file to write; replaced only when everything succeeded.
    progress : called as (done, total, what), or None.
    units : those of the deck.
    fits : raises where the results of this model would be refused later, or None.
    unit_loads : whether temperature has to be its one load, as `ingest` wants it; with `superelements` also as the
        forces of P2G.
    told : called with the memory that the factors need, before they are computed, or None.

    Raises
    ------
    InputError
        If the deck cannot be read, holds what the solver does not model, or is one whose results `ingest` would refuse
        for its units or masses.
    PhysicsError
        If the structure is not held or the solution is not accurate.
    """
    model = read_deck(deck, cross_reference=False, allow_missing_enddata=allow_missing_enddata, units=units)
    notes = passed_over(model)
    if unit_loads:
        check_unit_load_control(model, deck, superelements=superelements)
    structure, cases = solver_structure(model, deck)
    cross_reference(model, deck)
    geometry = model_geometry(model, [deck])  # a wrong unit is said before anything is solved
    if fits is not None:
        fits(geometry)
    mass = None if all(case.acceleration is None for case in cases) else model_mass(geometry)
    del model, geometry
    labels = {case.id: case.label for case in cases}
    in_deck_units = np.repeat([1.0 / units.length_m, 1.0], 3)  # angles are in rad
    try:
        solution = StaticSolution(structure, mass=mass, progress=progress, told=told)
        motions = solution.solve(cases)
        write_op2(
            op2,
            structure.grid_id,
            (
                (number, labels[number], in_deck_units * structure.in_displacement_frames(motion))
                for number, motion in motions
            ),
        )
    except (PhysicsError, MemoryShortError) as exc:  # the solver knows elements and grids, and no file
        raise type(exc)(exc.fact, where=exc.where or str(deck), hint=exc.hint) from exc
    solids = {_kind(block): len(block.element_id) for block in structure.solids}
    return SolveReport(
        n_grids=structure.n_grids,
        solids=solids,
        others={
            "bars": len(structure.bars.element_id),
            "rods": len(structure.rods.element_id),
            "CQUAD4": len(structure.quads.element_id),
            "CTRIA3": len(structure.trias.element_id),
        },
        n_cases=len(cases),
        bending_change=solution.bending_change(),
        drilling_change=solution.drilling_change(),
        linear_tetrahedra=solids.get("CTETRA4", 0),
        peak_bytes=_peak_bytes(),
        static=solution.report,
        own_temperatures=_own_temperatures(structure, cases),
        notes=notes,
    )


def _own_temperatures(structure: Structure, cases: Sequence[LoadCase]) -> OwnTemperatures:
    every, bent = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    for case in cases:
        if case.elements is not None:
            every.append(case.elements.element_id)
            bent.append(case.elements.element_id[case.elements.gradient.any(axis=(1, 2))])
    straight = [structure.rods.element_id]
    for shells in (structure.quads, structure.trias):
        straight.append(shells.element_id[~shells.bending_stiffness.any(axis=(1, 2))])
    gradients = np.unique(np.concatenate(bent))
    idle = np.intersect1d(gradients, np.concatenate(straight))
    return OwnTemperatures(
        elements=len(np.unique(np.concatenate(every))), gradients=len(gradients), idle=tuple(int(i) for i in idle)
    )


def _peak_bytes() -> int:
    """Largest resident memory of the process; the system counts it in kilobytes, macOS in bytes."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak


def _kind(block: SolidBlock) -> str:
    return f"{block.card}{block.connectivity.shape[1]}" + (" with bubbles" if block.bubble else "")


def solve(
    project: Project, output: Path | None, step: Step, told: Callable[[MemoryNeed], None] | None = None
) -> tuple[Path, SolveReport]:
    """Solve the configured unit-load deck; the results go where the model configuration expects them.

    Raises
    ------
    ConfigError
        If the configuration names several result files: a run makes one; the place of a file of ours; or HDF5, which
        is for MSC Nastran to write.
    """
    deck, out, config = _deck_and_op2(project, output)
    table = config.model
    if results_suffix(out) != OP2:
        fact = f"{out} is to be MSC Nastran's HDF5, and the embedded solver writes an OP2"
        hint = "name an OP2, or run MSC Nastran with --run"
        if output is not None:
            raise UsageError(fact, hint=hint)
        raise ConfigError([("model.op2", fact)], where=str(project.model), hint=hint)
    report = solve_deck(
        deck,
        out,
        step,
        allow_missing_enddata=table.allow_missing_enddata,
        units=table.deck_units(),
        fits=lambda geometry: require_layout_fits(project, config, geometry.grid_id, geometry.position_m),
        unit_loads=True,
        superelements=bool(config.superelement),
        told=told,
    )
    return out, replace(report, turned_element=_turned_element(project, report.drilling_change))


def solve_other(
    project: Project,
    deck: Path,
    output: Path | None,
    step: Step,
    told: Callable[[MemoryNeed], None] | None = None,
) -> tuple[Path, SolveReport]:
    """Solve another deck than the configured one, with any loads of its own, in the units of the model configuration.

    The results go beside the deck. Raises what `solve_deck` does, and `UsageError` for results that are no OP2.
    """
    table = load_model(project.model)[1].model
    out = output if output is not None else deck.with_suffix(OP2)
    if results_suffix(out) != OP2:
        raise UsageError(f"{out} is no OP2, which is what the embedded solver writes", hint="name it with .op2")
    refuse_own_place(project, [out])
    units = table.deck_units()
    report = solve_deck(deck, out, step, allow_missing_enddata=table.allow_missing_enddata, units=units, told=told)
    return out, replace(report, turned_element=_turned_element(project, report.drilling_change))


def _turned_element(project: Project, change: DrillingChange | None) -> tuple[str, float] | None:
    if change is None or project.optics is None:
        return None
    turn = dict(zip(change.grid_id.tolist(), change.turn.tolist(), strict=True))
    layout = load_layout(project.optics, needs_grids=False)[1]
    found = [(e.name, turn[e.grid]) for e in layout.bench if e.grid in turn]
    return max(found, key=lambda item: item[1], default=None)


def solve_elsewhere(
    project: Project, output: Path | None, command: str, say: Callable[[str], None]
) -> tuple[Path, int]:
    """Solve the configured unit-load deck with the user's own Nastran; the results go where they are expected.

    Returns
    -------
    The OP2 and the number of its subcases. Raises what `solve` and `run_nastran` do.
    """
    deck, out, config = _deck_and_op2(project, output)
    table = config.model
    units = table.deck_units()
    model = read_deck(deck, allow_missing_enddata=table.allow_missing_enddata, units=units)
    geometry = model_geometry(model, [deck])  # a wrong unit is said before anything is solved
    require_layout_fits(project, config, geometry.grid_id, geometry.position_m)
    return out, run_nastran(command, deck, out, say, allow_missing_enddata=table.allow_missing_enddata, units=units)


def _deck_and_op2(project: Project, output: Path | None) -> tuple[Path, Path, ModelConfig]:
    file, config = load_model(project.model)
    if output is None and len(config.model.op2) != 1:
        raise ConfigError([("model.op2", "names several files, a run makes one")], where=str(file.path))
    out = output if output is not None else project.resolve(config.model.op2[0])
    refuse_own_place(project, [out])
    return project.resolve(config.model.deck), out, config
