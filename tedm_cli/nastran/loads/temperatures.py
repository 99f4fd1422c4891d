"""The temperature step of each subcase: what TEMP and TEMPD load, minus the temperature of no thermal strain.

MSC Nastran Quick Reference Guide, case control TEMPERATURE: thermal strains are A (T - T_0), with T the set of
TEMPERATURE(LOAD) (or BOTH, which is what TEMPERATURE alone means), and T_0 the set of TEMPERATURE(INITIAL) where there
is one, else TREF of the material (for laminates TREF of the PCOMP, not of its plies).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.nastran.bulk.columns import TemperatureColumns, columns_of

_NONE = TemperatureColumns(np.zeros(0, dtype=np.int64), np.zeros(0))
_LAMINATES = ("PCOMP", "PCOMPG")
_EXPANSION = ("a", "a1", "a2", "a3", "A", "ax", "ath", "az")
# A step this small against the temperatures is the rounding of eight digits, subtracted.
_ROUNDING = 1e-9
_DIGITS = 15  # of the longest number in a field


@dataclass(frozen=True)
class Selection:
    """Temperature sets that a subcase selects: load (None where it has none), initial, material."""

    load: int | None
    initial: int | None
    material: int | None


def selection(subcase: Any, where: str) -> Selection:
    """Which temperature sets a pyNastran subcase selects; `InputError` where it selects two as loads."""
    sets = {str(k).replace(" ", ""): subcase.get_parameter(k)[0] for k in subcase.params if k.startswith("TEMPERATURE")}
    both = [sets[k] for k in ("TEMPERATURE(BOTH)", "TEMPERATURE") if k in sets]
    loads = {int(v) for v in [*both, *([sets["TEMPERATURE(LOAD)"]] if "TEMPERATURE(LOAD)" in sets else [])]}
    if len(loads) > 1:
        raise InputError(
            f"selects two temperature sets as loads: {', '.join(f'{n}' for n in sorted(loads))}",
            where=where,
            hint="TEMPERATURE alone means both LOAD and MATERIAL: write TEMPERATURE(LOAD)",
        )
    initial = sets.get("TEMPERATURE(INITIAL)")
    material = next((sets[k] for k in ("TEMPERATURE(MATE)", "TEMPERATURE(MATERIAL)") if k in sets), None)
    material = material if material is not None else next(iter(both), None)
    return Selection(
        load=loads.pop() if loads else None,
        initial=None if initial is None else int(initial),
        material=None if material is None else int(material),
    )


def selects_material_temperature(model: Any) -> bool:
    """Whether the case control of a pyNastran model selects TEMPERATURE(MATERIAL)."""
    control = model.case_control_deck
    keys = [] if control is None else [str(k).replace(" ", "") for s in control.subcases.values() for k in s.params]
    return any(key in ("TEMPERATURE(MATE)", "TEMPERATURE(MATERIAL)") for key in keys)


_MATT = ("MATT1", "MATT2", "MATT3", "MATT8", "MATT9", "MATT11")


def temperature_dependent(model: Any) -> list[str]:
    """Names of the materials whose properties depend on temperature (MATT1, MATT2, ...)."""
    return [f"{card.type} {mid}" for kind in _MATT for mid, card in sorted(getattr(model, kind, {}).items())]


def reference_temperatures(model: Any) -> dict[float, str]:
    """TREF of every material that expands and every laminate of a cross-referenced model, each with one that has it."""
    found: dict[float, str] = {}
    for owner in [*model.properties.values(), *columns_of(model).element_cards.values()]:  # plain ones have a property
        if owner.type in _LAMINATES:
            found.setdefault(float(owner.tref or 0.0), f"{owner.type} {owner.pid}")
            continue
        for name in ("mid_ref", "mid1_ref", "mid2_ref", "mid3_ref", "mid4_ref"):
            material = getattr(owner, name, None)
            if material is not None and hasattr(material, "tref") and any(expansion_coefficients(material)):
                found.setdefault(float(material.tref or 0.0), f"{material.type} {material.mid}")
    return found


def expansion_coefficients(material: Any) -> list[float]:
    """All expansion coefficients that a material card gives, per degree of the deck."""
    values = [v for name in _EXPANSION if (v := getattr(material, name, None)) is not None]
    return [float(x or 0.0) for v in values for x in np.atleast_1d(v)]


@dataclass(frozen=True)
class Field:
    """Temperatures of the grids of a set, as the deck writes them, for their digits count.

    `named` : by TEMP [n], by id; the others are at `rest` (TEMPD; NaN without one).
    """

    grid_id: IntArray
    named: FloatArray
    rest: float

    def on(self, grid_id: IntArray) -> FloatArray:
        """Temperature [N] of each of the ascending ids."""
        out = np.full(len(grid_id), self.rest)
        rows = np.searchsorted(grid_id, self.grid_id)
        out[rows] = self.named
        return out


def temperature_field(model: Any, sid: int, grid_id: IntArray, where: str) -> Field:
    """The temperatures of a set of TEMP and TEMPD cards.

    Raises
    ------
    InputError : a grid that does not exist, a grid twice with different temperatures, other cards than TEMP and TEMPD,
        an empty set.
    """
    given = columns_of(model).temperature_sets.get(sid, _NONE)
    ids, first, number = np.unique(given.grid_id, return_index=True, return_inverse=True)
    values = given.value[first]
    twice = np.flatnonzero(given.value != values[number])
    if twice.size:
        at = twice[0]
        raise InputError(
            f"temperature set {sid} gives grid {given.grid_id[at]} both {values[number[at]]:g} and {given.value[at]:g}",
            where=where,
        )
    rest = float(model.tempds[sid].temperature) if sid in model.tempds else float("nan")
    if not ids.size and np.isnan(rest):
        raise InputError(
            f"temperature set {sid} has neither TEMP nor TEMPD cards",
            where=where,
            hint="add a TEMPD card with the temperature of the rest",
        )
    missing = ids[~np.isin(ids, grid_id)]
    if missing.size:
        shown = ", ".join(str(i) for i in missing[:8])
        raise InputError(f"TEMP names {missing.size} grids that do not exist: {shown}", where=where)
    return Field(ids.astype(np.int64), values, rest)


def step(load: Field, initial: Field, grid_id: IntArray) -> FloatArray:
    """T - T_0 [N] on every grid as the cards say it in decimals, in degrees of the deck; NaN where one is not given.

    Cards have up to 15 digits: 293.02 - 293 is 0.02, where doubles leave 0.01999999999998.
    """
    warm, cold = load.on(grid_id), initial.on(grid_id)
    largest = float(np.fmax.reduce(np.fmax(np.abs(warm), np.abs(cold)), initial=0.0))  # passes over what is not given
    out: FloatArray = np.round(warm - cold, _DIGITS - _digits_before_the_point(largest))
    out[np.abs(out) <= _ROUNDING * np.maximum(np.abs(warm), np.abs(cold))] = 0.0
    return out


def error_in_single_precision(load: Field, initial: Field, grid_id: IntArray, steps: FloatArray) -> float:
    """Largest relative error of the `steps` [N] that are not 0 where a solver keeps its temperatures in 4 bytes."""
    on = np.nan_to_num(steps) != 0.0
    with np.errstate(over="ignore", invalid="ignore"):  # 4 bytes end at 3e38
        warm, cold = (field.on(grid_id)[on].astype(np.float32).astype(np.float64) for field in (load, initial))
        error = np.abs((warm - cold) / steps[on] - 1.0)
    return float(np.nan_to_num(error, nan=np.inf).max(initial=0.0))


def _digits_before_the_point(value: float) -> int:
    return int(np.floor(np.log10(value))) + 1 if value >= 1.0 else 1
