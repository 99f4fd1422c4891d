"""Plain cards of a block as columns: grids, solids, plates, temperatures of grids."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.nastran.bulk.fields import FORMS, Fields, Form
from tedm_cli.nastran.bulk.lines import Cards, word
from tedm_cli.nastran.bulk.numbers import Ids

SOLIDS = {"CHEXA": (8, 20), "CPENTA": (6, 15), "CTETRA": (4, 10), "CPYRAM": (5, 13)}
PLATES = {"CQUAD4": 4, "CTRIA3": 3}
_TEMPERATURES = 3  # of a TEMP card


@dataclass(frozen=True)
class PlainGrids:
    """Columns of GRID cards: id, cp, cd, components that are held (as one number, 0: none), each [n]; xyz [n, 3]."""

    id: Ids
    cp: Ids
    cd: Ids
    held: Ids
    xyz: FloatArray


@dataclass(frozen=True)
class PlainElements:
    """Columns of elements of one card with the same number of grids.

    id, property_id : [n]; node_id : [n, nodes]. For plates theta (degrees) and z_offset [n], and mcid [n] (-1: theta
    counts); of solids empty.
    """

    id: Ids
    property_id: Ids
    node_id: Ids
    theta: FloatArray
    mcid: Ids
    z_offset: FloatArray


@dataclass(frozen=True)
class PlainTemperatures:
    """Columns of TEMP cards: set, grid and temperature [n], in the deck's scale."""

    set_id: Ids
    grid_id: Ids
    value: FloatArray


@dataclass
class PlainCards:
    """What has been read of a deck, piece by piece; `counts` of cards by name."""

    grids: list[PlainGrids] = field(default_factory=list)
    elements: dict[tuple[str, int], list[PlainElements]] = field(default_factory=dict)
    temperatures: list[PlainTemperatures] = field(default_factory=list)
    counts: Counter[str] = field(default_factory=Counter)

    def take(self, cards: Cards) -> BoolArray:
        """Read the plain cards of a block; which of its cards [C] they are."""
        taken = np.zeros(len(cards.first), dtype=bool)
        words = cards.word
        temperatures: list[tuple[Ids, PlainTemperatures]] = []
        for name, form, rows in _groups(cards, words):
            if name == "GRID":
                read = self._grids(Fields(cards, rows, form), int(cards.count[rows[0]]), form)
            elif name == "TEMP":
                read, number, piece = _temperatures(Fields(cards, rows, form), int(cards.count[rows[0]]), form)
                temperatures.append((rows[number], piece))
            else:
                read = self._elements(name, Fields(cards, rows, form), int(cards.count[rows[0]]), form)
            taken[rows[read]] = True
            self.counts[name] += int(read.sum())
        if temperatures:
            self.temperatures.append(_in_order(temperatures))
        return taken

    def _grids(self, of: Fields, lines: int, form: Form) -> BoolArray:
        if lines != (2 if form.is_large else 1):
            return ~of.read
        number, cp = of.integer(0), of.integer(1, optional=True)
        xyz = np.stack([np.asarray(of.real(k).value, dtype=np.float64) for k in (2, 3, 4)], axis=1)
        cd, held = of.integer(5, optional=True), of.components(6)
        of.read &= (number > 0) & (of.integer(7, optional=True) == 0)
        ok = of.read
        self.grids.append(PlainGrids(_small(number[ok]), _small(cp[ok]), _small(cd[ok]), _small(held[ok]), xyz[ok]))
        return ok

    def _elements(self, name: str, of: Fields, lines: int, form: Form) -> BoolArray:
        sizes = SOLIDS.get(name) or (PLATES[name],)
        most = lines * form.per_line
        options = 2 if name in PLATES else 0
        nodes = next((n for n in sizes if -(-(2 + n + options) // form.per_line) == lines), None)
        if nodes is None:
            return ~of.read
        number, pid = of.integer(0), of.integer(1)
        node = np.stack([of.integer(2 + k) for k in range(nodes)], axis=1)
        of.read &= (number > 0) & (pid > 0) & (node > 0).all(axis=1)
        order = np.sort(node, axis=1)
        of.read &= (order[:, 1:] != order[:, :-1]).all(axis=1)
        theta = offset = np.zeros(0)
        mcid: Ids = np.zeros(0, dtype=np.int32)
        if options:
            whole, real = of.integer_or_real(2 + nodes)
            theta = np.asarray(real.value, dtype=np.float64)
            mcid = np.where(whole.read & ~whole.blank, np.asarray(whole.value), -1).astype(np.int32)
            offset = np.asarray(of.real(3 + nodes).value, dtype=np.float64)
        of.blank(2 + nodes + options, most)
        ok = of.read
        if options:
            theta, mcid, offset = theta[ok], mcid[ok], offset[ok]
        piece = PlainElements(_small(number[ok]), _small(pid[ok]), _small(node[ok]), theta, mcid, offset)
        self.elements.setdefault((name, nodes), []).append(piece)
        return ok


def _temperatures(of: Fields, lines: int, form: Form) -> tuple[BoolArray, IntArray, PlainTemperatures]:
    """Which cards are read, the number of the card of each temperature, and these."""
    most = lines * form.per_line
    pairs = min((most - 1) // 2, _TEMPERATURES)
    number = of.integer(0)
    grid = np.stack([of.integer(1 + 2 * k, optional=k > 0) for k in range(pairs)], axis=1)
    given = [of.real(2 + 2 * k) for k in range(pairs)]
    value, there = np.stack([g.value for g in given], axis=1), np.stack([~g.blank for g in given], axis=1)
    of.blank(1 + 2 * pairs, most)
    of.read &= there[:, 0] & ((grid > 0) == there).all(axis=1) & (there[:, :-1] >= there[:, 1:]).all(axis=1)
    order = np.sort(np.where(there, grid, -np.arange(1, pairs + 1)), axis=1)
    of.read &= (order[:, 1:] != order[:, :-1]).all(axis=1) & (number > 0)
    at = there & of.read[:, None]
    card = np.repeat(np.arange(len(at)), at.sum(axis=1))
    return of.read, card, PlainTemperatures(_small(number[card]), _small(grid[at]), np.asarray(value[at]))


def _in_order(pieces: list[tuple[Ids, PlainTemperatures]]) -> PlainTemperatures:
    """The temperatures of cards in several forms in the order of the deck; with each the rows of its cards."""
    if len(pieces) == 1:
        return pieces[0][1]
    order = np.argsort(np.concatenate([rows for rows, _ in pieces]), kind="stable")
    sets, grids, values = (
        np.concatenate([getattr(piece, name) for _, piece in pieces])[order] for name in ("set_id", "grid_id", "value")
    )
    return PlainTemperatures(sets, grids, values)


def _small(ids: Ids) -> Ids:
    """Ids, which have at most nine digits, in half the memory."""
    return np.asarray(ids, dtype=np.int32)


def _groups(cards: Cards, words: Ids) -> Iterator[tuple[str, Form, IntArray]]:
    """Rows of the plain cards by name, form and number of lines."""
    for name in ("GRID", "TEMP", *SOLIDS, *PLATES):
        for form in FORMS:
            spelled = [word(f"{name}{form.suffix}".encode())]
            if form.is_large:
                spelled.append(word(f"{name:<7}*".encode()))
            of_form = cards.plain & (cards.is_free == form.is_free) & (cards.is_large == form.is_large)
            rows = np.flatnonzero(of_form & np.isin(words, spelled))
            for count in np.unique(cards.count[rows]):
                yield name, form, rows[cards.count[rows] == count]
