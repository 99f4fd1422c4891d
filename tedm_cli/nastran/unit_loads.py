"""Thermal areas and unit loads of a deck: which grids each subcase warms, by how much, under which label."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tedm_cli.errors import InputError
from tedm_cli.nastran.geometry import IntArray, ModelGeometry, id_list, rows_of

_OTHER_LOADS = ("LOAD", "DEFORM")
_HOLDING = ("SPC", "MPC", "SUPORT1")


@dataclass(frozen=True)
class UnitLoad:
    """One subcase: its label, the rows of the grids it warms, and the temperature step (K)."""

    subcase: int
    label: str
    rows: IntArray
    load_K: float


@dataclass(frozen=True)
class UnitLoads:
    """The unit loads of the areas, and the uniform load where the deck has one."""

    areas: list[UnitLoad]
    uniform: UnitLoad | None


def deck_unit_loads(model: Any, geometry: ModelGeometry, uniform_label: str) -> UnitLoads:
    """Read the areas from the subcases' TEMP cards.

    Raises
    ------
    InputError : a subcase without label or temperatures, uneven steps, two subcases with one label, a reference
        temperature that differs from the materials', grids in two areas or in none.
    """
    where = str(geometry.files[0])
    control = model.case_control_deck
    if control is None:
        raise InputError(
            "has no case control, so no unit loads", where=where, hint="make a deck with `tedm write-deck`"
        )
    if any("TEMPERATURE(INITIAL)" in sub.params for sub in control.subcases.values()):
        raise InputError("TEMPERATURE(INITIAL) is not read", where=where, hint="set TREF on the materials instead")
    tref = {float(m.tref or 0.0) for m in model.materials.values() if hasattr(m, "tref")}
    subcases = {n: s for n, s in sorted(control.subcases.items()) if n != 0}
    _check_control(subcases, where)
    loads = [_unit_load(model, geometry, n, s, tref, where) for n, s in subcases.items()]
    labels: dict[str, int] = {}
    for load in loads:
        if load.label.upper() in labels:
            raise InputError(
                f"subcases {labels[load.label.upper()]} and {load.subcase} have the same label '{load.label}'",
                where=where,
            )
        labels[load.label.upper()] = load.subcase
    areas = [load for load in loads if load.label.upper() != uniform_label.upper()]
    uniform = next((load for load in loads if load.label.upper() == uniform_label.upper()), None)
    if not areas:
        raise InputError(
            "has no subcase that warms a thermal area", where=where, hint="make a unit-load deck with `tedm write-deck`"
        )
    _check_partition(areas, geometry, where)
    return UnitLoads(areas, uniform)


def _check_control(subcases: Mapping[int, Any], where: str) -> None:
    """Unit loads add up only when temperature is the one load and every subcase is held in the same way."""
    for number, subcase in subcases.items():
        for key in _OTHER_LOADS:
            if key in subcase.params:
                raise InputError(
                    f"{key} = {subcase.get_parameter(key)[0]} loads the structure besides its temperature",
                    where=f"{where}: subcase {number}",
                    hint="remove it: a unit load is a temperature step and nothing else",
                )
    for key in _HOLDING:
        chosen = {n: str(s.get_parameter(key)[0]) if key in s.params else "none" for n, s in subcases.items()}
        if len(set(chosen.values())) > 1:
            listed = ", ".join(f"{v} in subcase {n}" for n, v in list(chosen.items())[:8])
            raise InputError(f"the subcases have different {key}: {listed}", where=where)


def _unit_load(
    model: Any, geometry: ModelGeometry, number: int, subcase: Any, tref: set[float], where: str
) -> UnitLoad:
    label = str(subcase.get_parameter("LABEL")[0]).strip() if "LABEL" in subcase.params else ""
    if not label:
        raise InputError("has no LABEL, so its thermal area has no name", where=f"{where}: subcase {number}")
    place = f"{where}: subcase {number} (area '{label}')"
    key = next((k for k in ("TEMPERATURE(LOAD)", "TEMPERATURE(BOTH)", "TEMPERATURE") if k in subcase.params), None)
    if key is None:
        raise InputError("selects no temperatures", where=place, hint="add TEMPERATURE(LOAD) = <set id>")
    sid = int(subcase.get_parameter(key)[0])
    temperatures: dict[int, float] = {}
    for card in model.loads.get(sid, []):
        if card.type == "TEMP":
            temperatures.update({int(n): float(t) for n, t in card.temperatures.items()})
    base = float(model.tempds[sid].temperature) if sid in model.tempds else 0.0
    if tref and tref != {base}:
        raise InputError(
            f"rests at {base:g} K (TEMPD), but the materials' TREF is {', '.join(f'{t:g} K' for t in sorted(tref))}",
            where=place,
            hint="set TEMPD and every TREF to one reference temperature, or the rest of the model expands too",
        )
    steps = {n: t - base for n, t in temperatures.items() if t != base}
    if not steps:
        raise InputError(f"warms no grid (temperature set {sid})", where=place)
    values = set(steps.values())
    if max(values) - min(values) > 1e-9 * max(abs(v) for v in values):
        raise InputError(
            f"warms its grids by {min(values):g} to {max(values):g} K; a unit load has one step",
            where=place,
        )
    rows = rows_of(geometry.grid_id, np.array(sorted(steps), dtype=np.int64), where=place, what="TEMP")
    return UnitLoad(number, label, rows, next(iter(values)))


def _check_partition(areas: list[UnitLoad], geometry: ModelGeometry, where: str) -> None:
    count = np.zeros(len(geometry.grid_id), dtype=int)
    for area in areas:
        count[area.rows] += 1
    twice = geometry.grid_id[count > 1]
    if twice.size:
        both = [a.label for a in areas if np.isin(twice[0], geometry.grid_id[a.rows])]
        raise InputError(
            f"{twice.size} of {len(count)} grids are in more than one thermal area: {id_list(twice)}"
            f" (the first in {', '.join(both)})",
            where=where,
        )
    left = geometry.grid_id[(count == 0) & geometry.structural]
    if left.size:
        raise InputError(
            f"{left.size} of {geometry.structural.sum()} structural grids are in no thermal area: {id_list(left)}",
            where=where,
            hint="is a subcase missing, or an area without its TEMP cards?",
        )
