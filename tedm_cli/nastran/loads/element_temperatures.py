"""Temperatures that a deck gives to elements: TEMPP1 of shells, TEMPRB of bars and rods.

MSC Nastran Quick Reference Guide: an element with such a card takes its mean and its gradients from the card, not from
its grids. TEMPP1 has the mean of a shell and the gradient through its thickness, along its normal; TEMPRB the means at
the ends A and B of a bar and the gradients across it in planes 1 and 2. Temperatures of fibres (TS1, TS2, TC to TF) are
for stresses alone. pyNastran does not read TEMPP1, so both are read here, from their fields.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tedm_cli.arrays import IntArray
from tedm_cli.deck_units import TEMPERATURE, TEMPERATURE_GRADIENT, DeckUnits
from tedm_cli.errors import InputError
from tedm_cli.fem.structure import ElementTemperatures
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.captured_output import fact_of
from tedm_cli.quantities import TEMPERATURE as TEMPERATURE_BOUNDS
from tedm_cli.quantities import TEMPERATURE_GRADIENT as GRADIENT_BOUNDS

SHELLS = ("CQUAD4", "CQUAD8", "CQUADR", "CTRIA3", "CTRIA6", "CTRIAR")
LINES = ("CBAR", "CBEAM", "CROD", "CONROD", "CTUBE")
ELEMENTS_OF = {"TEMPP1": SHELLS, "TEMPRB": LINES}
"""The elements that a card may name, by the card's name."""

# The first fields of the lists of further elements.
_LIST = {"TEMPP1": 9, "TEMPRB": 17}
_GRADIENTS = ("TP1A", "TP1B", "TP2A", "TP2B")


@dataclass(frozen=True)
class TemperatureCard:
    """One card as the deck writes it, in the deck's degrees and degrees per length.

    `mean` is of ends A and B, `gradient` in plane 1 at A and at B, then in plane 2; of a shell both ends are the same
    and plane 2 has none. `ranges` are first and last ids of elements.
    """

    name: str
    set_id: int
    place: str
    mean: tuple[float, float]
    gradient: tuple[float, float, float, float]
    ranges: tuple[tuple[int, int], ...]

    @property
    def title(self) -> str:
        return f"{self.name} of set {self.set_id}"


def temperature_card(name: str, card: Any, place: str) -> TemperatureCard:
    """Read the fields of a TEMPP1 or TEMPRB, in whatever form its lines are.

    Parameters
    ----------
    card : pyNastran's BDFCard.
    place : file and line, for messages.

    Raises
    ------
    InputError : a field that is not what it has to be, among them a mean that is blank; ids that are none.
    """
    from pyNastran.bdf.bdf_interface.assign_type import double, double_or_blank, integer

    try:
        set_id, first = integer(card, 1, "SID"), integer(card, 2, "EID1")
        if name == "TEMPP1":
            mean = (double(card, 3, "TBAR"),) * 2
            gradient = (float(double_or_blank(card, 4, "TPRIME", 0.0)),) * 2 + (0.0, 0.0)
            names = {5: "TS1", 6: "TS2"}
        else:
            mean = (double(card, 3, "TA"), double(card, 4, "TB"))
            one, two, three, four = (double_or_blank(card, 5 + k, _GRADIENTS[k], 0.0) for k in range(4))
            gradient = (float(one), float(two), float(three), float(four))
            names = {9 + k: f"T{point}{end}" for k, (end, point) in enumerate((e, p) for e in "AB" for p in "CDEF")}
        for field, fibre in names.items():
            double_or_blank(card, field, fibre)
        ranges = _ranges([str(word or "").strip().upper() for word in card.fields(_LIST[name], len(card))])
    except SyntaxError as exc:
        raise InputError(f"{name}: {fact_of(exc, '')}", where=place) from exc
    except _NoList as exc:
        raise InputError(f"{name} {set_id}: {exc}", where=place) from exc
    if name == "TEMPP1" and any(card.field(k) for k in (7, 8)):
        raise InputError(
            f"{name} {set_id}: has fields behind TS2: its list of elements is in the next line", where=place
        )
    ranges = ((first, first), *ranges)
    if set_id < 1 or any(low < 1 for low, _ in ranges):
        raise InputError(f"{name} {set_id}: numbers of sets and elements are 1 and more", where=place)
    return TemperatureCard(name, set_id, place, (float(mean[0]), float(mean[1])), gradient, ranges)


class _NoList(Exception):
    """What is wrong with a list of elements."""


def _ranges(words: Sequence[str]) -> tuple[tuple[int, int], ...]:
    """First and last id of each part of a list of ids and of `a THRU b`."""
    left, found = [word for word in words if word], list[tuple[int, int]]()
    while left:
        count = 3 if left[1:2] == ["THRU"] else 1
        ends = [left[0], left[count - 1]] if len(left) >= count else left[:1]
        if len(left) < count or not all(word.removeprefix("+").isdecimal() for word in ends):
            raise _NoList(f"{' '.join(left[:count])} in its list of elements names none")
        low, high = int(ends[0]), int(ends[-1])
        if high < low:
            raise _NoList(f"{low} THRU {high} runs backwards")
        found.append((low, high))
        left = left[count:]
    return tuple(found)


def element_temperature_sets(model: Any) -> frozenset[int]:
    """Numbers of all sets of a model from `read_deck` that have temperatures of elements."""
    return frozenset(card.set_id for card in model.tedm_element_temperatures)


def element_temperatures(model: Any, set_id: int) -> ElementTemperatures | None:
    """The temperatures that a set gives to elements, in the deck's degrees and degrees per length; None of none.

    Raises
    ------
    InputError : with file and line, an element that does not exist (of a range that has gaps, all of it), or that has
        no such temperature; an element with two different ones; a temperature or a gradient that no structure has.
    """
    cards = [card for card in model.tedm_element_temperatures if card.set_id == set_id]
    if not cards:
        return None
    known = columns_of(model).element.id
    ids, owner = [], []
    for number, card in enumerate(cards):
        _check_values(card, model.tedm_units)
        for low, high in card.ranges:
            part = known[np.searchsorted(known, low) : np.searchsorted(known, high, side="right")]
            _check_elements(model, card, (low, high), part)
            ids.append(part)
            owner.append(np.full(len(part), number))
    named, row = np.concatenate(ids), np.concatenate(owner)
    order = np.argsort(named, kind="stable")
    named, row = named[order], row[order]
    table = np.array([[*card.mean, *card.gradient] for card in cards])
    again = np.flatnonzero((named[1:] == named[:-1]) & (table[row[1:]] != table[row[:-1]]).any(axis=1))
    if again.size:
        former, latter = cards[row[again[0]]], cards[row[again[0] + 1]]
        raise InputError(
            f"{latter.title} gives element {named[again[0]]} another temperature than {former.place} does",
            where=latter.place,
        )
    element_id, first = np.unique(named, return_index=True)
    values = table[row[first]]
    # plane 1 at A and B, plane 2 at A and B: by end, then by plane
    return ElementTemperatures(
        element_id=element_id, mean=values[:, :2], gradient=values[:, 2:].reshape(-1, 2, 2).transpose(0, 2, 1)
    )


def _check_values(card: TemperatureCard, units: DeckUnits) -> None:
    """Refuse temperatures and gradients that no structure has."""
    for bounds, dimension, values in (
        (TEMPERATURE_BOUNDS, TEMPERATURE, card.mean),
        (GRADIENT_BOUNDS, TEMPERATURE_GRADIENT, card.gradient),
    ):
        for value in values:
            fact = bounds.fact(units.factor(dimension) * value)
            if fact:
                raise InputError(f"{card.title}: {fact}", where=card.place)


def _check_elements(model: Any, card: TemperatureCard, wanted: tuple[int, int], found: IntArray) -> None:
    """Refuse a part of a card's list that names no element, or one of another kind."""
    low, high = wanted
    if not found.size:
        other = next((t[low].type for t in (model.rigid_elements, model.masses) if low == high and low in t), "")
        fact = f"{other} {low}, which has no temperature" if other else f"element {low}, which does not exist"
        fact = fact if low == high else f"elements {low} THRU {high}, none of which exists"
        raise InputError(f"{card.title} names {fact}", where=card.place)
    kinds, elements = ELEMENTS_OF[card.name], columns_of(model).element
    rows = np.searchsorted(elements.id, found)
    wrong = np.flatnonzero(~elements.is_of(kinds)[rows])
    if wrong.size:
        row = rows[wrong[0]]
        kind = str(elements.cards[elements.kind[row]])
        own = next((name for name, those in ELEMENTS_OF.items() if kind in those), "")
        raise InputError(
            f"{card.title} names {kind} {elements.id[row]}, and is for {', '.join(kinds)}",
            where=card.place,
            hint=f"write {own}" if own else "load its grids with TEMP and TEMPD",
        )
