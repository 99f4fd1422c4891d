"""Displacements of the unit loads from one or several result files, in the basic frame, one subcase at a time."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.errors import InputError
from tedm_cli.nastran.frames import displacement_axes, rounded_off_axis
from tedm_cli.nastran.geometry import ModelGeometry, id_list
from tedm_cli.nastran.loads.unit_loads import UnitLoad
from tedm_cli.nastran.result_files import open_result_file
from tedm_cli.nastran.subcase_table import GridMotion, SubcaseTable, clean_label

_LABEL_KEPT = 64  # Nastran writes no more than this of a LABEL


@dataclass
class Findings:
    """What was found while displacements were read.

    by_number : files without labels, whose subcases were taken by the numbers of the deck. single : whether the motion
    under any load is in single precision. taken : every load with its file and its number in it.
    """

    by_number: list[Path] = field(default_factory=list)
    single: bool = False
    taken: list[tuple[Path, int, UnitLoad]] = field(default_factory=list)


def unit_load_displacements(
    files: Sequence[Path],
    loads: Sequence[UnitLoad],
    geometry: ModelGeometry,
    subcase_table: Mapping[str, int] | None = None,
    scalar_points: Collection[int] = (),
    findings: Findings | None = None,
    *,
    whole: bool = True,
) -> Iterator[tuple[UnitLoad, FloatArray, FloatArray]]:
    """Yield (unit load, translation [N,3] m, rotation [N,3] rad) for every load, in the order of the result files.

    Which subcase is which load is settled from the headers of all files before the first displacement is read, and one
    subcase is held at a time. Subcases are matched by `subcase_table` (area name to subcase id), else by LABEL without
    regard to case, else, where a file has no labels at all, by the deck's numbers; never by order. Every area of
    `subcase_table` is among `loads`. Displacements of grids that the results leave out stay zero when those grids have
    no element, no rigid element and no mass; rows of `scalar_points` are left out. `findings` is filled on the way.
    Without `whole` the files are some of several: loads may be missing, and numbers be held against the labels later,
    by `check_numbers` of what was `taken` from all.

    Raises
    ------
    InputError : what `open_result_file` refuses, a load without result, a result without load, a result given twice,
        labels and numbers of subcases that contradict each other, missing grids, NaN or infinity.
    """
    matched: list[tuple[Path, dict[int, UnitLoad]]] = []
    seen: dict[str, Path] = {}
    find = _Matching(loads, subcase_table or {})
    findings = Findings() if findings is None else findings
    findings.by_number = []
    for path in files:
        with open_result_file(path) as (tables, _):
            mine = {}
            for table in tables:
                load = mine[table.subcase] = find.load(table, path)
                if load.label in seen:
                    raise InputError(f"area '{load.label}' was already in {seen[load.label]}", where=str(path))
                seen[load.label] = path
            matched.append((path, mine))
            if not subcase_table and not all(table.labelled for table in tables):
                findings.by_number.append(path)
    findings.taken = [(path, number, load) for path, mine in matched for number, load in mine.items()]
    if whole:
        _check_complete(loads, seen, files)
        if not subcase_table:
            check_numbers(findings.taken, loads)
    on_grids = OnGrids(geometry, scalar_points)
    for path, mine in matched:
        with open_result_file(path) as (tables, read):
            for table in tables:
                load = mine[table.subcase]
                got = read(table)
                findings.single |= not got.double
                place = f"{path}: subcase {table.subcase} (area '{load.label}')"
                motion = on_grids.motion(got, table, place, asked=load.output)
                yield load, motion[:, 0], motion[:, 1]


class OnGrids:
    """Brings the motions of subcases to the grids of a model, in m and rad, basic frame.

    Rows of `scalar_points` are left out; grids that the results leave out stay at zero when they have no element, no
    rigid element and no mass.
    """

    def __init__(self, geometry: ModelGeometry, scalar_points: Collection[int] = ()) -> None:
        self._geometry, self._scalar_points = geometry, scalar_points
        self._axes = displacement_axes(geometry.position_m, geometry.displacement_frame, geometry.frames)

    def motion(self, got: GridMotion, table: SubcaseTable, place: str, *, asked: str = "") -> FloatArray:
        """Translations and rotations [N, 2, 3] of a table that was read; `asked`: what DISPLACEMENT asks for.

        Raises
        ------
        InputError : NaN or infinity, grids that the model lacks, grids without a displacement, and grids on the axis of
            their frame but for rounding.
        """
        motion = _on_grids(_without(got, self._scalar_points), asked, self._geometry, place).reshape(-1, 2, 3)
        if self._axes is not None and not table.is_basic:
            _check_axes(self._geometry, place)
            motion = np.einsum("nij,naj->nai", self._axes, motion)
        if self._geometry.units.length_m != 1.0:
            motion[:, 0] *= self._geometry.units.length_m
        return motion


class _Matching:
    """Finds the unit load of a subcase."""

    def __init__(self, loads: Sequence[UnitLoad], table: Mapping[str, int]) -> None:
        by_name = {load.label.upper(): load for load in loads}
        self.by_subcase = {number: by_name[area.upper()] for area, number in table.items()}
        self.by_number = {load.subcase: load for load in loads}
        self.by_label: dict[str, list[UnitLoad]] = {}
        for load in loads:
            self.by_label.setdefault(_key(load.label), []).append(load)

    def load(self, table: SubcaseTable, path: Path) -> UnitLoad:
        if self.by_subcase:
            found = [self.by_subcase[table.subcase]] if table.subcase in self.by_subcase else []
        elif not table.labelled:
            found = [self.by_number[table.subcase]] if table.subcase in self.by_number else []
        else:
            found = self.by_label.get(_key(table.label), [])
            exact = [load for load in found if clean_label(load.label).upper() == table.label.upper()]
            found = exact or found
        if len(found) == 1:
            return found[0]
        name = f"label '{table.label}'" if table.label else "no label"
        fact = f"subcase {table.subcase} ({name}) belongs to no thermal area of the deck"
        if found:
            fact = (
                f"subcase {table.subcase} ({name}) may be any of {', '.join(load.label for load in found)}:"
                f" Nastran keeps {_LABEL_KEPT} characters of a LABEL"
            )
        raise InputError(
            fact,
            where=str(path),
            hint="label the subcases with the area names, or give [model.subcases] area = id",
        )


def _key(label: str) -> str:
    return clean_label(label).upper()[:_LABEL_KEPT].strip()


def _check_complete(loads: Sequence[UnitLoad], seen: Mapping[str, Path], files: Sequence[Path]) -> None:
    missing = [load for load in loads if load.label not in seen]
    if missing:
        names = ", ".join(f"'{m.label}' (subcase {m.subcase})" for m in missing[:5])
        more = f" and {len(missing) - 5} more" if len(missing) > 5 else ""
        raise InputError(
            f"no displacements for {len(missing)} of {len(loads)} unit loads: {names}{more}",
            where=", ".join(str(p) for p in files),
            hint="is a result file missing from the list, or did the solver stop before its last subcase?",
        )


def check_numbers(found: Sequence[tuple[Path, int, UnitLoad]], loads: Sequence[UnitLoad]) -> None:
    """Where the results have the deck's own numbers, these must say what the labels say.

    Two loads that have changed places add up to the same uniform load: nothing else would tell.

    Raises
    ------
    InputError : they say otherwise; names the first.
    """
    if sorted(number for _, number, _ in found) != sorted(load.subcase for load in loads):
        return  # numbered anew, in one file or in several
    of_deck = {load.subcase: load.label for load in loads}
    other = [(path, number, load) for path, number, load in found if load.subcase != number]
    if other:
        path, number, load = other[0]
        raise InputError(
            f"subcase {number} is labelled '{load.label}', and '{of_deck[number]}' in the deck"
            f" ({len(other)} of {len(found)} subcases)",
            where=str(path),
            hint="were labels changed since? assign the subcases by [model.subcases] area = id",
        )


def _check_axes(geometry: ModelGeometry, place: str) -> None:
    near = rounded_off_axis(geometry.position_m, geometry.displacement_frame, geometry.frames)
    bad = np.nonzero(near & _needed(geometry))[0]
    if bad.size:
        frame = geometry.displacement_frame[bad[0]]
        raise InputError(
            f"{bad.size} grids are on the axis of their displacement frame except for rounding:"
            f" {id_list(geometry.grid_id[bad])} (CD {frame}); there the solver took the directions from the rounding",
            where=place,
            hint="give grids on an axis a rectangular displacement frame (CD), and solve again",
        )


def _needed(geometry: ModelGeometry) -> BoolArray:
    return np.asarray(geometry.structural | geometry.in_rigid_element | (geometry.lumped_kg > 0))


def _without(got: GridMotion, scalar_points: Collection[int]) -> GridMotion:
    """The rows of grids: HDF5 does not tell scalar points from them, the deck does."""
    if not scalar_points:
        return got
    kept = ~np.isin(got.grid_id, list(scalar_points))
    return GridMotion(got.grid_id[kept], got.motion[kept], got.double)


def _on_grids(got: GridMotion, asked: str, geometry: ModelGeometry, place: str) -> FloatArray:
    """Motion [N,6] on the grids of the model, whatever the order and the number of grids in the table."""
    ids = got.grid_id
    if not np.isfinite(got.motion).all():  # row by row takes ten times as long
        bad = ids[~np.isfinite(got.motion).all(axis=1)]
        raise InputError(
            f"{bad.size} of {len(ids):,} displacements are NaN or infinite: grid {id_list(bad)}",
            where=place,
            hint="did the solver fail in this subcase?",
        )
    if np.array_equal(ids, geometry.grid_id):  # as Nastran writes them
        return got.motion
    rows = np.searchsorted(geometry.grid_id, ids)
    rows[rows == len(geometry.grid_id)] = 0
    unknown = ids[geometry.grid_id[rows] != ids]
    if unknown.size:
        raise InputError(
            f"{unknown.size} grids are not in the deck: {id_list(unknown)}",
            where=place,
            hint="are these the results of another model?",
        )
    if np.unique(ids).size != ids.size:
        raise InputError("a grid occurs twice", where=place)
    absent = _needed(geometry)
    absent[rows] = False
    if absent.any():
        limit = "" if asked in ("", "ALL") else f"; the deck limits the output by DISPLACEMENT = {asked}"
        raise InputError(
            f"{absent.sum()} grids have no displacement: {id_list(geometry.grid_id[absent])}{limit}",
            where=place,
            hint="request DISPLACEMENT(PLOT) = ALL",
        )
    motion = np.zeros((len(geometry.grid_id), 6))
    motion[rows] = got.motion
    return motion
