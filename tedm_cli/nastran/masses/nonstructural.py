"""Non-structural mass of the set that case control selects: NSM, NSM1, NSML, NSML1 and NSMADD.

NSM and NSM1 give mass per area or length; NSML and NSML1 give a mass, spread over the area or length of everything that
they name (NSML per pair of id and value, NSML1 over all its ids). Ids that do not exist are passed over, as Nastran
does (Quick Reference Guide).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.fem.shapes import corner_count, shape_of

_ALIAS = {
    **dict.fromkeys(("PSHELL", "PCOMP", "PCOMPG"), "PSHELL"),
    **dict.fromkeys(("PBAR", "PBARL"), "PBAR"),
    **dict.fromkeys(("PBEAM", "PBEAML", "PBCOMP"), "PBEAM"),
}
_LUMPED = ("NSML", "NSML1")


@dataclass(frozen=True)
class Measured:
    """Elements in the order of the model: ids, cards, property ids and types, and their measures (m³, m² or m; 0).

    property_type : gives the cards of the properties [E], which are wanted seldom.
    """

    id: IntArray
    card: list[str]
    property_id: IntArray
    property_type: Callable[[], Sequence[str]]
    measure: FloatArray


def selected_set(model: Any, where: str) -> int | None:
    """The NSM set that case control selects.

    Raises
    ------
    InputError : subcases with different sets.
    """
    control = model.case_control_deck
    subcases = {} if control is None else control.subcases
    chosen = {
        int(number): int(subcase.get_parameter("NSM")[0]) if "NSM" in subcase else 0
        for number, subcase in subcases.items()
        if number != 0 or len(subcases) == 1
    }
    if len(set(chosen.values())) > 1:
        raise InputError(
            f"subcases select different sets of non-structural mass: {sorted(set(chosen.values()))}",
            where=where,
            hint="all unit loads are of one structure: put NSM above the first subcase",
        )
    return next(iter(chosen.values()), 0) or None


def nonstructural(model: Any, elements: Measured, where: str) -> FloatArray:
    """Mass per area or length [E] that the selected set adds to each element, before PARAM,WTMASS.

    Raises
    ------
    InputError : an unknown set, a kind of property that is not read, a lump on areas and lengths together.
    """
    out = np.zeros(len(elements.id))
    number = selected_set(model, where)
    if number is None:
        return out
    if number not in model.nsms and number not in model.nsmadds:
        raise InputError(f"case control selects NSM = {number}, and there is no such set", where=where)
    shapes = [shape_of(c, corner_count(c) or 0) for c in elements.card]
    dimension = np.array([0 if s is None else s.dimension for s in shapes])
    kind = np.array([_ALIAS.get(p, p) for p in elements.property_type()])
    for card in _cards(model, number):
        named = _named(card, elements, kind, where)
        if card.nsm_type != "ELEMENT" or "ALL" in card.ids:
            named &= (dimension == 1) | (dimension == 2)
        if (dimension[named] == 3).any() or not dimension[named].all():
            wrong = elements.id[named][~np.isin(dimension[named], (1, 2))][0]
            raise InputError(f"{card.type} {card.sid}: element {wrong} has neither area nor length", where=where)
        value = float(card.value)
        if card.type not in _LUMPED:
            out[named] += value
            continue
        if not named.any():
            continue
        if np.unique(dimension[named]).size > 1:
            raise InputError(
                f"{card.type} {card.sid}: a mass spread over areas and lengths together",
                where=where,
                hint="give it as two cards",
            )
        out[named] += value / float(elements.measure[named].sum())
    return out


def _cards(model: Any, number: int) -> Iterator[Any]:
    """Cards of a set, with those of the sets that an NSMADD of its number adds; each set once."""
    wanted, seen = [number], set()
    while wanted:
        sid = wanted.pop(0)
        if sid in seen:
            continue
        seen.add(sid)
        yield from model.nsms.get(sid, [])
        for add in model.nsmadds.get(sid, []):
            wanted += [int(s) for s in add.nsm_ids]


def _named(card: Any, elements: Measured, kind: NDArray[np.str_], where: str) -> BoolArray:
    """Which elements a card names: by id, or by property id and type, where PCOMP counts as PSHELL and so on."""
    if card.nsm_type in ("PCONEAX", "PRAC2D", "PBEND"):
        raise InputError(f"{card.type} {card.sid}: {card.nsm_type} is not read", where=where)
    every = "ALL" in card.ids
    ids = np.array([] if every else [int(i) for i in card.ids], dtype=np.int64)
    if card.nsm_type in ("ELEMENT", "CONROD"):
        of_kind = np.array([card.nsm_type == "ELEMENT" or c == "CONROD" for c in elements.card])
        return np.asarray(of_kind if every else of_kind & np.isin(elements.id, ids))
    of_kind = kind == _ALIAS.get(card.nsm_type, card.nsm_type)
    return np.asarray(of_kind if every else of_kind & np.isin(elements.property_id, ids))
