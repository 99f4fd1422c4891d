"""Plain cards as the objects of pyNastran, made when one is asked for and not kept."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from tedm_cli.nastran.bulk.columns import Columns
from tedm_cli.nastran.bulk.lines import NotPlainError
from tedm_cli.nastran.bulk.numbers import Ids
from tedm_cli.nastran.bulk.plain import PLATES
from tedm_cli.nastran.library import without_integration


class CardTable(Mapping[int, Any]):
    """Cards by id: those that pyNastran has read, and plain ones, each made when it is asked for."""

    def __init__(self, cards: Mapping[int, Any], plain_id: Ids, make: Callable[[int], Any]) -> None:
        """`plain_id` [n] ascending; `make` gives the card in a row of it."""
        self._cards, self._id, self._make = cards, plain_id, make

    def __getitem__(self, key: int) -> Any:
        if key in self._cards:
            return self._cards[key]
        row = self._row(key)
        if row is None:
            raise KeyError(key)
        return self._make(row)

    def _row(self, key: object) -> int | None:
        if not isinstance(key, int | np.integer) or not len(self._id):
            return None
        row = int(np.searchsorted(self._id, key))
        return row if row < len(self._id) and self._id[row] == key else None

    def __contains__(self, key: object) -> bool:
        return key in self._cards or self._row(key) is not None

    def __iter__(self) -> Iterator[int]:
        yield from (int(i) for i in self._id)
        yield from self._cards

    def __len__(self) -> int:
        return len(self._id) + len(self._cards)


def install(model: Any, columns: Columns) -> None:
    """Give a model that pyNastran has read the tables of all of its cards, and let it link them as its own.

    Cross-referencing raises `NotPlainError` where plain cards name frames, properties or grids that there are not.
    """
    with without_integration():
        from pyNastran.bdf.bdf import CQUAD4, CTRIA3, GRID
        from pyNastran.bdf.cards.elements import solid

    grids, order = columns.plain_grids, columns.element_order
    pieces = list(columns.plain_elements.items())
    linked: set[str] = set()

    def grid(row: int) -> Any:
        card = GRID(
            int(grids.id[row]),
            grids.xyz[row].copy(),
            int(grids.cp[row]),
            int(grids.cd[row]),
            str(grids.held[row] or ""),
        )
        if "nodes" in linked:
            card.cross_reference(model, model.grdset)
        return card

    def element(row: int) -> Any:
        (name, size), piece = pieces[order.kind[row]]
        at = order.row[row]
        number, pid, nodes = int(piece.id[at]), int(piece.property_id[at]), piece.node_id[at].tolist()
        if name in PLATES:
            mcid = int(piece.mcid[at])
            turned = float(piece.theta[at]) if mcid < 0 else mcid
            kind = CQUAD4 if name == "CQUAD4" else CTRIA3
            card = kind(number, pid, nodes, theta_mcid=turned, zoffset=float(piece.z_offset[at]))
        else:
            card = getattr(solid, f"{name}{size}")(number, pid, nodes)
        if "elements" in linked:
            card.cross_reference(model)
        return card

    link_grids, link_elements = model._cross_reference_nodes, model._cross_reference_elements

    def cross_reference_grids() -> None:
        model.nodes = columns.grid_cards
        try:
            link_grids()
        finally:
            model.nodes = node_table
        linked.add("nodes")
        columns.is_linked = True
        columns.forget()
        frames = np.union1d(np.unique(grids.cp), np.unique(columns.displacement_frame()))
        _require(frames, model.coords)

    def cross_reference_elements() -> None:
        model.elements = columns.element_cards
        try:
            link_elements()
        finally:
            model.elements = element_table
        linked.add("elements")
        for piece in columns.plain_elements.values():
            _require(np.unique(piece.property_id), model.properties)
            _require(np.unique(piece.mcid[piece.mcid >= 0]), model.coords)
            for column in piece.node_id.T:
                rows = np.searchsorted(columns.grid_id, column).clip(max=max(len(columns.grid_id) - 1, 0))
                if not len(columns.grid_id) or (columns.grid_id[rows] != column).any():
                    raise NotPlainError

    node_table = CardTable(columns.grid_cards, grids.id, grid)
    element_table = CardTable(columns.element_cards, order.id, element)
    model.nodes, model.elements, model.tedm_columns = node_table, element_table, columns
    model._cross_reference_nodes, model._cross_reference_elements = cross_reference_grids, cross_reference_elements


def _require(ids: Ids, table: Mapping[int, Any]) -> None:
    if not all(int(i) in table for i in ids):
        raise NotPlainError
