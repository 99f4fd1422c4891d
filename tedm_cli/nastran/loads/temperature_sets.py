"""Temperature sets of unit loads: the temperature they start from, their set ids, and their TEMP and TEMPD cards."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

from tedm_cli.arrays import IntArray
from tedm_cli.errors import InputError
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.geometry import id_list
from tedm_cli.nastran.loads.element_temperatures import element_temperature_sets
from tedm_cli.nastran.units import units_of

MAX_ID = 99_999_999
_TEMPERATURE_TABLES = ("MATT1", "MATT2", "MATT3", "MATT4", "MATT5", "MATT8", "MATT9", "MATT11")


@dataclass(frozen=True)
class Reference:
    """The temperature of the model at rest, in the deck's scale, exact as written.

    is_initial : it must be selected with TEMPERATURE(INITIAL), because the materials' TREF alone does not say it.
    """

    value: Decimal
    is_initial: bool
    notes: tuple[str, ...] = ()


def reference_temperature(
    model: Any, configured_K: float | None, *, material_temperature: bool, where: str
) -> Reference:
    """The temperature at which every part of the model is free of thermal strain.

    In linear statics the thermal strain is A(T0) (T - T0). T0 is the TEMPERATURE(INITIAL) set where there is one, else
    TREF of the material (of the laminate on PCOMP, PCOMPG); MATTi are evaluated at the TEMPERATURE(INITIAL) or
    (MATERIAL) set and not used without either (MSC Nastran Quick Reference Guide, TEMPERATURE case control command).

    Raises
    ------
    InputError : temperature-dependent materials while nothing says at which temperature to linearise; a configured
        temperature, or several TREF, beside TEMPERATURE(MATERIAL), which excludes TEMPERATURE(INITIAL).
    """
    trefs = Counter(_tref(card) for card in model.materials.values() if hasattr(card, "tref"))
    trefs += Counter(_tref(card) for card in model.properties.values() if card.type in ("PCOMP", "PCOMPG"))
    tables = {name: sorted(getattr(model, name, {})) for name in _TEMPERATURE_TABLES}
    dependent = [f"{name} {id_list(ids)}" for name, ids in tables.items() if ids]
    if configured_K is None and dependent and not material_temperature:
        raise InputError(
            f"materials depend on temperature ({'; '.join(dependent)}), and nothing says where to linearise them",
            where=where,
            hint="set model.reference_temperature_K: the unit loads start from it, with the properties at it",
        )
    common = next(iter(trefs)) if len(trefs) == 1 else None
    if configured_K is not None:
        value = units_of(model).shown_at(Decimal(repr(configured_K)))
    elif common is not None or not trefs:
        value = common or Decimal(0)
    else:
        value = max(sorted(trefs), key=lambda t: trefs[t])
    is_initial = (
        len(trefs) > 1 or (common is not None and common != value) or (bool(dependent) and not material_temperature)
    )
    if is_initial and material_temperature:
        raise InputError(
            f"TEMPERATURE(MATERIAL) excludes TEMPERATURE(INITIAL), which the reference temperature {plain(value)}"
            f" needs beside TREF {', '.join(plain(t) for t in sorted(trefs))}",
            where=where,
            hint="give every material (and PCOMP) the same TREF, or remove TEMPERATURE(MATERIAL)",
        )
    notes = []
    if is_initial:
        listed = ", ".join(plain(t) for t in sorted(trefs))
        notes.append(
            f"TEMPERATURE(INITIAL) sets the reference to {plain(value)} in place of TREF {listed};"
            " MYSTRAN passes over it and its results would be wrong"
        )
    if dependent:
        at = "the TEMPERATURE(MATERIAL) set" if material_temperature else plain(value)
        notes.append(f"temperature-dependent materials are linearised at {at}: {'; '.join(dependent)}")
    return Reference(value, is_initial, tuple(notes))


def _tref(card: Any) -> Decimal:
    return Decimal(repr(float(card.tref or 0.0))).normalize() + 0


def free_set_ids(model: Any, count: int, where: str) -> list[int]:
    """Ids of `count` new load sets, after all load, temperature and deformation sets of the model where there is room.

    Static, thermal and deformation sets must not share ids (Quick Reference Guide, remark on TEMPERATURE).
    """
    temperatures = columns_of(model).temperature_sets
    tables = (temperatures, model.loads, model.load_combinations, model.tempds, model.dloads, model.dload_entries)
    used = sorted({int(sid) for table in tables for sid in table} | element_temperature_sets(model))
    for before, after in zip([used[-1] if used else 0, 0, *used], [MAX_ID + 1, *used, MAX_ID + 1], strict=False):
        if after - before > count:
            return list(range(before + 1, before + count + 1))
    raise InputError(f"has no {count} load set ids left", where=where)


def temperature_cards(sid: int, rest: Decimal, warm: IntArray, step: Decimal = Decimal(1)) -> list[str]:
    """TEMPD of the rest and TEMP of the grids `warm` (ascending), a `step` higher; in large fields where small cannot.

    Raises
    ------
    InputError : a temperature of more digits than a large field has.
    """
    low, high = plain(rest), plain(rest + step)
    if max(len(low), len(high)) > 16:
        raise InputError(f"the reference temperature {low} has more digits than a field of a deck")
    if max(len(low), len(high)) > 8 or int(max(warm, default=0)) > MAX_ID:
        lines = [f"TEMPD*  {sid:>16}{low:>16}", "*"]
        for three in _threes(warm):
            fields = [f"{sid:>16}", *(f"{text:>16}" for i in three for text in (str(i), high))]
            lines += ["TEMP*   " + "".join(fields[:4]), "*       " + "".join(fields[4:])]
        return lines
    lines = [f"TEMPD   {sid:>8}{low:>8}"]
    return lines + [f"TEMP    {sid:>8}" + "".join(f"{i:>8}{high:>8}" for i in three) for three in _threes(warm)]


def _threes(ids: IntArray) -> Iterable[list[int]]:
    return ([int(i) for i in ids[k : k + 3]] for k in range(0, len(ids), 3))


def plain(value: Decimal) -> str:
    """A real number as Nastran reads it, without exponent and with its point."""
    text = f"{value:f}"
    if "." in text:
        text = text.rstrip("0")
    return text if "." in text else text + "."
