"""reduce: a part of a solved deck as a superelement: matrices, its areas and its masses."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.config.model.file import load_model
from tedm_cli.config.model.superelement import AREA_COLUMNS, MASS_COLUMNS
from tedm_cli.config.project import Project
from tedm_cli.deck_units import MOMENT, DeckUnits
from tedm_cli.errors import InputError, PhysicsError, UsageError
from tedm_cli.fem.condensation import condense, part_grids, part_of, warms
from tedm_cli.fem.constraints import rigid_body_matrix
from tedm_cli.fem.superelement import ReducedMatrices
from tedm_cli.files.store import replacing
from tedm_cli.nastran.geometry import ModelGeometry, model_geometry, rows_of
from tedm_cli.nastran.loads.unit_loads import UnitLoad, deck_unit_loads
from tedm_cli.nastran.reading import cross_reference, deck_files, read_deck
from tedm_cli.nastran.structure.deck import solver_structure
from tedm_cli.nastran.superelements.files import OP4, write_matrices
from tedm_cli.tables.csv_table import csv_line

SUFFIXES = (OP4, ".bdf", ".dat")
_FORCE = 1e-9  # of the largest force of any area: what is less is rounding


@dataclass(frozen=True)
class ReduceSummary:
    """What was written.

    table : lines of model.toml that name it. grids, freedoms : of the part, and of its interface. shared : areas that
    are in the rest, too. mass_kg : of the part, in `points`. grounded : whether supports hold the part.
    """

    path: Path
    areas_csv: Path
    masses_csv: Path
    grids: int
    freedoms: int
    areas: int
    shared: tuple[str, ...]
    points: int
    mass_kg: float
    grounded: bool
    table: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class _Points:
    """Masses of a part: id, row of the grid that each follows, lever to it (m), position (m), mass (kg)."""

    id: IntArray
    row: IntArray
    lever: FloatArray
    position: FloatArray
    kg: FloatArray


def reduce(project: Project, interface: list[int], inside: int, output: Path | None) -> ReduceSummary:
    """Condense the part of the unit-load deck that the interface grids cut off and that has the grid `inside`.

    Raises
    ------
    UsageError : an output of another suffix.
    InputError : grids that the deck does not have, an interface that cuts nothing off, an area under a gradient; what
        `solver_structure` and `ingest` refuse of a deck.
    PhysicsError : a part that its interface does not hold.
    """
    out = output if output is not None else project.build_dir / "superelement.op4"
    if out.suffix.lower() not in SUFFIXES:
        raise UsageError(f"{out} is no file of matrices", hint="name it .op4 for OUTPUT4, or .bdf for DMIG cards")
    table = load_model(project.model)[1].model
    deck = project.resolve(table.deck)
    model = read_deck(
        deck, cross_reference=False, allow_missing_enddata=table.allow_missing_enddata, units=table.deck_units()
    )
    structure, cases = solver_structure(model, deck)
    if structure.direct.dof.size:
        raise InputError("has a superelement already: reduce the model in one piece", where=str(deck))
    cross_reference(model, deck)
    geometry = model_geometry(model, deck_files(model, deck))
    loads = deck_unit_loads(model, geometry, table.uniform_label).areas
    wanted = np.array([*interface, inside], dtype=np.int64)
    rows = rows_of(structure.grid_id, wanted, where=str(deck), what="--interface or --part")
    try:
        of_part = part_grids(structure, rows[:-1], int(rows[-1]))
        part = part_of(structure, of_part)
        by_id = {case.id: case for case in cases}
        force = warms(part, [by_id[load.subcase] for load in loads])
        acting = [load for load, f in zip(loads, force, strict=True) if f > _FORCE * force.max()]
        _refuse_gradients(acting, str(deck))
        points = _points(geometry, of_part)
        found = condense(part, rows[:-1], points.row, [by_id[load.subcase] for load in acting])
    except PhysicsError as error:
        raise PhysicsError(error.fact, where=str(deck), hint=error.hint) from error
    except InputError as error:
        raise InputError(error.fact, where=error.where or str(deck), hint=error.hint) from error
    step = np.array([load.load_K for load in acting])
    matrices = _in_deck_units(_at_points(found, points, step), geometry.units)
    shared = tuple(load.label for load in acting if _reaches_out(load, geometry, of_part))
    beside = [out.with_name(f"{out.stem}_{what}.csv") for what in ("areas", "masses")]
    with replacing(out) as temporary:
        write_matrices(temporary, out.suffix, matrices, interface, points.id.tolist())
    _write_areas(beside[0], acting, geometry, of_part)
    _write_masses(beside[1], acting, geometry, points)
    grounded = bool(part.spc_grid.size)
    return ReduceSummary(
        path=out,
        areas_csv=beside[0],
        masses_csv=beside[1],
        grids=int(of_part.sum()),
        freedoms=6 * len(interface),
        areas=len(acting),
        shared=shared,
        points=len(points.id),
        mass_kg=float(points.kg.sum()),
        grounded=grounded,
        table=_table(out, beside, interface, shared, grounded=grounded),
    )


def _refuse_gradients(acting: list[UnitLoad], where: str) -> None:
    for load in acting:
        if load.kind == "gradient":
            raise InputError(
                f"area '{load.label}' is under a gradient, and areas of superelements have a mean temperature each",
                where=where,
            )


def _points(geometry: ModelGeometry, of_part: BoolArray) -> _Points:
    """Lumped masses of the elements of a part, and what is on its grids or at levers to them."""
    e, c = geometry.elements, geometry.concentrated
    counts = np.diff(e.node_offset)
    element = np.repeat(np.arange(len(e.id)), counts)
    inside = np.bincount(element, of_part[e.node_index], len(e.id)) > 0
    share = np.where(inside, e.mass_kg / np.maximum(counts, 1), 0.0)[element]
    n = len(geometry.grid_id)
    on_grid = of_part[c.node] & ~c.lever.any(axis=1)
    off = of_part[c.node] & c.lever.any(axis=1) & (c.kg > 0.0)
    kg = np.bincount(e.node_index, share, n) + np.bincount(c.node[on_grid], c.kg[on_grid], n)
    rows = np.flatnonzero(kg > 0.0)
    first = int(geometry.grid_id.max()) + 1
    row = np.concatenate([rows, c.node[off]])
    lever = np.concatenate([np.zeros((len(rows), 3)), c.lever[off]])
    return _Points(
        id=np.concatenate([geometry.grid_id[rows], first + np.arange(int(off.sum()))]),
        row=row,
        lever=lever,
        position=geometry.position_m[row] + lever,
        kg=np.concatenate([kg[rows], c.kg[off]]),
    )


def _at_points(found: ReducedMatrices, points: _Points, step: FloatArray) -> ReducedMatrices:
    """Recovery at the ends of the levers, and loads per kelvin."""
    arm = rigid_body_matrix(points.lever)

    def moved(matrix: FloatArray) -> FloatArray:
        return np.asarray(np.einsum("pij,pjk->pik", arm, matrix.reshape(len(arm), 6, -1))).reshape(matrix.shape)

    return ReducedMatrices(
        stiffness=found.stiffness,
        loads=found.loads / step,
        recovery=moved(found.recovery),
        thermal_recovery=moved(found.thermal_recovery) / step,
    )


def _in_deck_units(si: ReducedMatrices, units: DeckUnits) -> ReducedMatrices:
    """From SI, with the motions of each freedom in the deck's units of length, or rad."""
    size = np.array([units.length_m] * 3 + [1.0] * 3)
    a = np.tile(size, len(si.stiffness) // 6)[:, None]
    r = np.tile(size, len(si.recovery) // 6)[:, None]
    work = units.factor(MOMENT)
    return ReducedMatrices(
        stiffness=a * si.stiffness * a.T / work,
        loads=a * si.loads / work,
        recovery=si.recovery * a.T / r,
        thermal_recovery=si.thermal_recovery / r,
    )


def _reaches_out(load: UnitLoad, geometry: ModelGeometry, of_part: BoolArray) -> bool:
    """Whether an area warms something that is not of the part; its interface is not."""
    e = geometry.elements
    inside = [of_part[e.node_index[e.node_offset[i] : e.node_offset[i + 1]]].any() for i in load.elements.loaded]
    return not (of_part[load.rows].all() and all(inside))


def _write_areas(path: Path, acting: list[UnitLoad], geometry: ModelGeometry, of_part: BoolArray) -> None:
    lines = [csv_line(AREA_COLUMNS)]
    for load in acting:
        here = load.rows[of_part[load.rows]]
        at = geometry.position_m[here] if here.size else geometry.position_m[load.rows]
        if load.elements.loaded.size:
            at = np.concatenate([at, geometry.centres(load.elements.loaded)])
        lines.append(csv_line([load.label, *(repr(float(v)) for v in at.mean(axis=0))]))
    _write(path, lines)


def _write_masses(path: Path, acting: list[UnitLoad], geometry: ModelGeometry, points: _Points) -> None:
    area = {int(row): load.label for load in acting for row in load.rows.tolist()}
    lines = [csv_line([*MASS_COLUMNS, "area"])]
    for node, row, at, kg in zip(points.id, points.row, points.position, points.kg, strict=True):
        numbers = (repr(float(v)) for v in (*at, kg))
        lines.append(csv_line([node, *numbers, area.get(int(row), "")]))
    _write(path, lines)


def _write(path: Path, lines: list[str]) -> None:
    with replacing(path) as temporary:
        temporary.write_text("".join(lines), encoding="utf-8", newline="\n")


def _table(
    out: Path, beside: list[Path], interface: list[int], shared: tuple[str, ...], *, grounded: bool
) -> tuple[str, ...]:
    """What model.toml has to say, with names relative to its folder left to the user."""
    quoted = ", ".join(f'"{name}"' for name in shared)
    lines = ["[[superelement]]", f'name = "{out.stem}"', f'matrices = "{out.name}"', f"interface = {interface}"]
    lines += [f'areas = "{beside[0].name}"', f'masses = "{beside[1].name}"']
    lines += [f"shared = [{quoted}]"] if shared else []
    return (*lines, *(["grounded = true"] if grounded else []))
