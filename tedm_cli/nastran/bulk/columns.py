"""The grids, elements and temperatures of grids of a model as columns, of whichever way they were read."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.nastran.bulk.lines import NotPlainError
from tedm_cli.nastran.bulk.numbers import Ids
from tedm_cli.nastran.bulk.plain import PLATES, PlainCards, PlainElements, PlainGrids


@dataclass(frozen=True)
class GridColumns:
    """GRID cards in ascending order of their ids: id, cp, cd [N]; xyz [N, 3] in the frame CP, as on the card."""

    id: IntArray
    cp: Ids
    cd: Ids
    xyz: FloatArray


@dataclass(frozen=True)
class ElementColumns:
    """Elements in ascending order of their ids.

    id [E]; kind [E], into cards; cards: names; property_id [E], as on the card (0: none).
    node_offset [E + 1], node_id: grids as on the card, 0 where one is left out.
    """

    id: IntArray
    kind: Ids
    cards: NDArray[np.str_]
    property_id: IntArray
    node_offset: IntArray
    node_id: IntArray

    @property
    def card(self) -> NDArray[np.str_]:
        """Names of the cards [E]."""
        return self.cards[self.kind]

    def is_of(self, names: Iterable[str]) -> BoolArray:
        """Which elements [E] are of these cards."""
        return np.asarray(np.isin(self.cards, list(names))[self.kind])

    def without(self, node_id: Iterable[int]) -> tuple[IntArray, IntArray]:
        """Offsets [E + 1] and ids of the grids that are given, but for these."""
        kept = self.node_id != 0
        others = np.array(sorted(node_id), dtype=np.int64)
        if others.size:
            kept &= ~np.isin(self.node_id, others)
        if kept.all():
            return self.node_offset, self.node_id
        return np.concatenate([[0], np.cumsum(kept)])[self.node_offset], self.node_id[kept]


@dataclass(frozen=True)
class Alike:
    """Elements with the same card, number of grids and property, and no object of their own; others are by themselves.

    first : [R], row of the first element of each of them, ascending; number : [E], which of them an element is of;
    count : [R].
    """

    first: IntArray
    number: IntArray
    count: IntArray


@dataclass(frozen=True)
class TemperatureColumns:
    """TEMP cards of one set in the order of the deck: grids [n], which may be there twice, and temperatures [n]."""

    grid_id: Ids
    value: FloatArray


class Columns:
    """Columns of a model, of its plain cards and of the cards that pyNastran has read.

    grid_cards, element_cards : pyNastran's, by id. temperature_sets : by number.
    """

    def __init__(self, model: Any, plain: PlainCards) -> None:
        """Takes the TEMP cards out of `model`; `NotPlainError`: an id that is there twice."""
        self.grid_cards: dict[int, Any] = model.nodes
        self.element_cards: dict[int, Any] = model.elements
        self._model = model
        self.plain_grids = _sorted_grids(plain.grids)
        self.plain_elements = {
            key: _joined(pieces) for key, pieces in sorted(plain.elements.items()) if sum(len(p.id) for p in pieces)
        }
        self.temperature_sets = _temperature_sets(model, plain)
        self._refuse_twice()

    def _refuse_twice(self) -> None:
        ids = self.plain_grids.id
        twice = (ids[1:] == ids[:-1]).any() or _any_of(self.grid_cards, ids)
        order = self.element_order
        twice |= (order.id[1:] == order.id[:-1]).any() or _any_of(self.element_cards, order.id)
        if twice:
            raise NotPlainError

    @cached_property
    def element_order(self) -> _ElementOrder:
        """Ascending ids of the plain elements, and where each of them is."""
        pieces = list(self.plain_elements.values())
        ids = np.concatenate([np.zeros(0, dtype=np.int32), *(p.id for p in pieces)])
        kind = np.repeat(np.arange(len(pieces), dtype=np.int16), [len(p.id) for p in pieces])
        row = np.concatenate([np.zeros(0, dtype=np.int32), *(np.arange(len(p.id), dtype=np.int32) for p in pieces)])
        if (ids[1:] < ids[:-1]).any():
            order = np.argsort(ids, kind="stable")
            ids, kind, row = ids[order], kind[order], row[order]
        return _ElementOrder(ids, kind, row)

    @property
    def grid_id(self) -> IntArray:
        """Ids of all grids, ascending."""
        return self.grid.id

    def forget(self) -> None:
        """Make the columns again of cards that have changed: cross-referenced grids have the defaults of GRDSET."""
        self.__dict__.pop("grid", None)

    @cached_property
    def grid(self) -> GridColumns:
        """All grids."""
        plain, cards = self.plain_grids, [self.grid_cards[i] for i in sorted(self.grid_cards)]
        ids = np.concatenate([plain.id, np.array([c.nid for c in cards], dtype=np.int64)]).astype(np.int64)
        cp = np.concatenate([plain.cp, np.array([c.Cp() for c in cards], dtype=np.int64)])
        cd = np.concatenate([self.displacement_frame(), np.array([c.Cd() for c in cards], dtype=np.int64)])
        xyz = plain.xyz
        if cards:
            order = np.argsort(ids, kind="stable")
            xyz = np.concatenate([plain.xyz, np.array([c.xyz for c in cards], dtype=float).reshape(-1, 3)])[order]
            ids, cp, cd = ids[order], cp[order], cd[order]
        return GridColumns(ids, cp, cd, xyz)

    def displacement_frame(self) -> Ids:
        """CD of the plain grids, with the default of GRDSET where the model is cross-referenced."""
        default = getattr(self._model.grdset, "cd", 0) if self.is_linked else 0
        cd = self.plain_grids.cd
        return np.where(cd == 0, np.int32(default), cd) if default else cd

    is_linked = False
    """Whether grids have their frames."""

    @cached_property
    def element(self) -> ElementColumns:
        """All elements."""
        pieces, order = list(self.plain_elements.items()), self.element_order
        others = [(i, *_of_card(self.element_cards[i])) for i in sorted(self.element_cards)]
        names = [name for (name, _), _ in pieces] + [name for _, name, _, _ in others]
        cards, kinds = np.unique(names, return_inverse=True)
        ids = np.concatenate([order.id, np.array([i for i, *_ in others], dtype=np.int64)]).astype(np.int64)
        kind = np.concatenate([kinds[: len(pieces)][order.kind], kinds[len(pieces) :]]).astype(np.int16)
        sizes = np.array([size for (_, size), _ in pieces], dtype=np.int64)[order.kind]
        count = np.concatenate([sizes, np.array([len(nodes) for *_, nodes in others], dtype=np.int64)])
        pid = np.zeros(len(ids), dtype=np.int64)
        place = np.argsort(ids, kind="stable") if others else np.arange(len(ids))
        offset = np.concatenate([[0], np.cumsum(count[place])])
        start = np.empty(len(ids), dtype=np.int64)
        start[place] = offset[:-1]
        node = np.zeros(int(offset[-1]), dtype=np.int64)
        for number, (_, piece) in enumerate(pieces):
            rows = np.flatnonzero(order.kind == number)
            pid[rows] = piece.property_id[order.row[rows]]
            for column in range(piece.node_id.shape[1]):
                node[start[rows] + column] = piece.node_id[order.row[rows], column]
        for at, (_, _, own, nodes) in enumerate(others, start=len(order.id)):
            pid[at] = own
            node[start[at] : start[at] + len(nodes)] = nodes
        return ElementColumns(ids[place], kind[place], cards, pid[place], offset, node)

    @cached_property
    def alike(self) -> Alike:
        """Elements that differ in their grids, and plates in their offset and material angle, alone."""
        e, order = self.element, self.element_order
        row_of = np.searchsorted(e.id, order.id)
        label = np.full(len(e.id), -1, dtype=np.int64)
        known = 0
        for number, piece in enumerate(self.plain_elements.values()):
            rows = np.flatnonzero(order.kind == number)
            pids, which = np.unique(piece.property_id[order.row[rows]], return_inverse=True)
            label[row_of[rows]] = known + which
            known += len(pids)
        own = np.flatnonzero(label < 0)
        label[own] = known + np.arange(len(own))
        _, first, number_of, count = np.unique(label, return_index=True, return_inverse=True, return_counts=True)
        place = np.argsort(first)
        rank = np.empty_like(place)
        rank[place] = np.arange(len(place))
        return Alike(first[place], rank[number_of], count[place])

    def plate_offsets(self, ids: IntArray) -> FloatArray:
        """ZOFFS [n] of elements, ids ascending; 0 where the card has none."""
        out = np.zeros(len(ids))
        for (card, _), piece in self.plain_elements.items():
            if card in PLATES and len(ids):
                rows = np.searchsorted(ids, piece.id).clip(max=len(ids) - 1)
                there = ids[rows] == piece.id
                out[rows[there]] = piece.z_offset[there]
        for row in np.flatnonzero(np.isin(ids, list(self.element_cards))).tolist():
            out[row] = float(getattr(self.element_cards[int(ids[row])], "zoffset", 0.0) or 0.0)
        return out

    def examples(self) -> list[Any]:
        """The first element of each that are alike, as pyNastran has it."""
        return [self._model.elements[int(i)] for i in self.element.id[self.alike.first]]


@dataclass(frozen=True)
class _ElementOrder:
    """Ids [n] ascending, and for each the number of its piece and its row in it."""

    id: Ids
    kind: Ids
    row: Ids


def columns_of(model: Any) -> Columns:
    """The columns of a model from `read_deck`."""
    columns: Columns = model.tedm_columns
    return columns


def _of_card(element: Any) -> tuple[str, int, list[int]]:
    """Name, property and grids of an element that pyNastran has read."""
    nodes = element.nodes if hasattr(element, "nodes") else element.node_ids
    return str(element.type), int(getattr(element, "pid", None) or 0), [int(n or 0) for n in nodes]


def _any_of(cards: Mapping[int, Any], ids: Ids) -> bool:
    return bool(np.isin(np.array(list(cards), dtype=np.int64), ids).any()) if cards and len(ids) else False


def _sorted_grids(pieces: list[PlainGrids]) -> PlainGrids:
    empty = np.zeros(0, dtype=np.int32)

    def joined(of: Callable[[PlainGrids], NDArray[Any]], none: NDArray[Any] = empty) -> NDArray[Any]:
        return np.concatenate([none, *(of(p) for p in pieces)])

    ids = joined(lambda p: p.id)
    xyz = joined(lambda p: p.xyz, np.zeros((0, 3)))
    out = PlainGrids(ids, joined(lambda p: p.cp), joined(lambda p: p.cd), joined(lambda p: p.held), xyz)
    pieces.clear()
    if (ids[1:] >= ids[:-1]).all():
        return out
    order = np.argsort(ids, kind="stable")
    return PlainGrids(ids[order], out.cp[order], out.cd[order], out.held[order], xyz[order])


def _joined(pieces: list[PlainElements]) -> PlainElements:
    names = ("id", "property_id", "node_id", "theta", "mcid", "z_offset")
    out = PlainElements(*(np.concatenate([getattr(p, name) for p in pieces]) for name in names))
    pieces.clear()
    return out


def _temperature_sets(model: Any, plain: PlainCards) -> dict[int, TemperatureColumns]:
    """TEMP cards by set, those of `model` taken out of it."""
    sets, grids, values = (
        np.concatenate([np.zeros(0, dtype=kind), *(getattr(p, name) for p in plain.temperatures)])
        for name, kind in (("set_id", np.int32), ("grid_id", np.int32), ("value", np.float64))
    )
    plain.temperatures.clear()
    order = np.argsort(sets, kind="stable") if (sets[1:] < sets[:-1]).any() else slice(None)
    sets, grids, values = sets[order], grids[order], values[order]
    numbers, first = np.unique(sets, return_index=True)
    ends = [*first[1:], len(sets)][: len(numbers)]
    out = {int(n): TemperatureColumns(grids[a:b], values[a:b]) for n, a, b in zip(numbers, first, ends, strict=True)}
    for number, pairs in _pairs_of_cards(model):
        more = TemperatureColumns(
            np.array([g for g, _ in pairs], dtype=np.int64), np.array([t for _, t in pairs], dtype=np.float64)
        )
        old = out.get(number)
        out[number] = (
            more
            if old is None
            else TemperatureColumns(
                np.concatenate([old.grid_id, more.grid_id]), np.concatenate([old.value, more.value])
            )
        )
    return dict(sorted(out.items()))


def _pairs_of_cards(model: Any) -> Iterator[tuple[int, list[tuple[int, float]]]]:
    for number, cards in list(model.loads.items()):
        temperatures = [card for card in cards if card.type == "TEMP"]
        if temperatures:
            yield int(number), [(int(g), float(t)) for card in temperatures for g, t in card.temperatures.items()]
            model.loads[number] = [card for card in cards if card.type != "TEMP"]
            if not model.loads[number]:
                del model.loads[number]
