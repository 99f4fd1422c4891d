"""Case control and loads of a deck, for the embedded solver."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.fem.structure import ElementTemperatures, LoadCase
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.control_words import LOADS, NOT_LINEAR, check_selections, read_statements
from tedm_cli.nastran.deck_lines import read_head
from tedm_cli.nastran.loads.element_temperatures import element_temperatures
from tedm_cli.nastran.loads.unit_load_control import check_parameters
from tedm_cli.nastran.structure.mechanical_loads import MechanicalLoads
from tedm_cli.nastran.superelements.selected import direct_matrices

# Case control that selects a load, a constraint or a matrix that is not modelled.
_REFUSED = (*(word for word in LOADS if word not in ("LOAD", "P2G")), *NOT_LINEAR, "SUPORT1", "SUPORT", "BGSET")
_REFUSED_SUBCASES = ("SUBCOM", "SUBSEQ", "SYM", "SYMCOM", "REPCASE")


@dataclass(frozen=True)
class SelectedLoads:
    """A subcase with its set of temperatures (TEMPERATURE) and that of forces, accelerations and motions (LOAD); None
    where it selects none."""

    id: int
    label: str
    temperature: int | None
    load: int | None


@dataclass(frozen=True)
class SelectedSets:
    """Set numbers that the case control selects.

    `constraint` (SPC), `equations` (MPC) and `initial` are common to all subcases (None where not selected).
    `stiffness` (K2GG) and `forces` (P2G, a column for each subcase) are names of matrices.
    """

    constraint: int | None
    equations: int | None
    initial: int | None
    subcases: tuple[SelectedLoads, ...]
    stiffness: tuple[str, ...] = ()
    forces: str | None = None


def selected_sets(model: Any, path: Path) -> SelectedSets:
    """Read the case control of a pyNastran model.

    Raises
    ------
    InputError
        For a solution other than SOL 101, subcases without a load or with one that is not modelled, combined subcases,
        and subcases whose constraints or initial temperatures differ.
    """
    where = str(path)
    statements = read_statements(read_head(path).control)
    check_selections(statements)
    check_parameters(model, statements, where)
    if model.sol != 101:
        raise InputError(f"SOL {model.sol} is not the linear static solution SOL 101", where=where)
    for line in model.case_control_deck.lines:
        word = line.split("=")[0].split("(")[0].split()
        if word and word[0].upper() in _REFUSED_SUBCASES:
            raise InputError(f"case control combines subcases: {line.strip()!r}", where=where, hint="use SUBCASE only")
    numbers = sorted(number for number in model.subcases if number) or [0]
    loads, constraints, equations, initials, problems = [], set(), set(), set(), []
    for number in numbers:
        params = model.subcases[number].params
        refused = [key for key in _REFUSED if key in params]
        if refused:
            problems.append(f"subcase {number} selects {', '.join(refused)}")
        temperature = _selected(params, "TEMPERATURE(LOAD)", "TEMPERATURE(BOTH)")
        load = _selected(params, "LOAD")
        if temperature is None and load is None:
            problems.append(f"subcase {number} has no TEMPERATURE(LOAD) and no LOAD")
            continue
        label = str(params["LABEL"][0]) if "LABEL" in params else ""
        loads.append(SelectedLoads(int(number) or 1, label, temperature, load))
        constraints.add(_selected(params, "SPC"))
        equations.add(_selected(params, "MPC"))
        initials.add(_selected(params, "TEMPERATURE(INITIAL)"))
    for name, selected in (("SPC", constraints), ("MPC", equations)):
        if len(selected) > 1:
            problems.append(f"subcases select different {name} sets; one factorisation serves them all")
    if len(initials) > 1:
        problems.append("subcases select different TEMPERATURE(INITIAL) sets")
    if problems:
        some = "; ".join(problems[:10]) + (" ..." if len(problems) > 10 else "")
        raise InputError(some, where=where, hint="write one thermal subcase per area with `tedm write-deck`")
    return SelectedSets(
        constraints.pop(), equations.pop(), initials.pop(), tuple(loads), *direct_matrices(statements, where)
    )


def read_load_cases(
    model: Any,
    sets: SelectedSets,
    grid_id: IntArray,
    blocks: Sequence[tuple[IntArray, IntArray]],
    mechanical: Callable[[int | None], MechanicalLoads],
    path: Path,
) -> tuple[FloatArray | None, list[LoadCase]]:
    """Temperatures of all grids, and of elements that have their own, in every selected set; forces and motions.

    Parameters
    ----------
    model : pyNastran model.
    sets : from `selected_sets`.
    grid_id : [N], ascending.
    blocks : ids [E] and grids [E, n], by row, of all elements. Grids of elements without a temperature of their own
        must have one in every set.
    mechanical : the loads of a set that LOAD selects.
    path : for messages.

    Returns
    -------
    Initial temperatures [N] or None, and the load cases in the order of their subcases.
    """
    initial = None
    if sets.initial is not None:
        if element_temperatures(model, sets.initial) is not None:
            raise InputError(
                f"TEMPERATURE(INITIAL) selects set {sets.initial}, which gives elements temperatures of their own",
                where=str(path),
                hint="the initial temperatures are read of grids alone: give that set TEMP and TEMPD",
            )
        initial = _temperatures(model, sets.initial, None, grid_id, blocks, path)
    cases = []
    for one in sets.subcases:
        own = temperature = None
        if one.temperature is not None:
            own = element_temperatures(model, one.temperature)
            temperature = _temperatures(model, one.temperature, own, grid_id, blocks, path)
        found = mechanical(one.load)
        cases.append(
            LoadCase(
                id=one.id,
                label=one.label,
                temperature=temperature,
                elements=own,
                force=found.force,
                acceleration=found.acceleration,
                enforced=found.enforced,
            )
        )
    return initial, cases


def _selected(params: dict[str, Any], *keys: str) -> int | None:
    for key in keys:
        if key in params:
            return int(params[key][0])
    return None


def _temperatures(
    model: Any,
    sid: int,
    own: ElementTemperatures | None,
    grid_id: IntArray,
    blocks: Sequence[tuple[IntArray, IntArray]],
    path: Path,
) -> FloatArray:
    """Temperature [N] of every grid in the set `sid` (TEMP cards over the TEMPD default); `own` are of elements."""
    default = model.tempds.get(sid)
    given = columns_of(model).temperature_sets.get(sid)
    where = f"{path}: TEMP set {sid}"
    if default is None and given is None and own is None:
        raise InputError("selected by case control, but neither TEMP nor TEMPD cards exist", where=where)
    ids = np.zeros(0, dtype=np.int64) if given is None else given.grid_id
    values = np.zeros(0) if given is None else given.value
    row = np.searchsorted(grid_id, ids).clip(max=len(grid_id) - 1)
    unknown = ids[grid_id[row] != ids]
    if unknown.size:
        raise InputError(f"{unknown.size} grid(s) that do not exist, the first is {unknown[0]}", where=where)
    temperature = np.full(len(grid_id), np.nan if default is None else float(default.temperature))
    temperature[row] = values
    contradicted = ids[temperature[row] != values]
    if contradicted.size:
        raise InputError(f"grid {contradicted[0]} has two different temperatures", where=where)
    bare = np.isnan(temperature)
    if bare.any():
        _require_temperatures(bare, own, grid_id, blocks, where)
    return np.where(bare, 0.0 if own is None else own.mean[0, 0], temperature)


def _require_temperatures(
    bare: BoolArray,
    own: ElementTemperatures | None,
    grid_id: IntArray,
    blocks: Sequence[tuple[IntArray, IntArray]],
    where: str,
) -> None:
    """Refuse `bare` grids [N], without a temperature, of elements that take theirs from them."""
    needed = np.zeros(len(grid_id), dtype=bool)
    for element_id, connectivity in blocks:
        following = connectivity if own is None else connectivity[~np.isin(element_id, own.element_id)]
        needed[following.reshape(-1)] = True
    lacking = grid_id[bare & needed]
    if lacking.size:
        raise InputError(
            f"{lacking.size} grid(s) of elements have no temperature, the first is {lacking[0]}",
            where=where,
            hint="add a TEMPD card with the temperature of the rest",
        )
