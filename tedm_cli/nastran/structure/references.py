"""References of cards to grids, properties and materials."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.arrays import IntArray
from tedm_cli.errors import InputError


class CardReferences:
    """Rows of grid ids; collects the references to grids, properties and materials that do not exist."""

    def __init__(self, grid_id: IntArray, path: Path) -> None:
        self._grid_id = grid_id
        self._path = path
        self._missing: list[str] = []

    @property
    def where(self) -> str:
        """The deck's path, for messages."""
        return str(self._path)

    def rows(self, ids: Any, who: str, owners: Sequence[int] | IntArray = ()) -> IntArray:
        """Rows of grid ids; `owners` are the elements, one for each row of `ids` [E, n]."""
        wanted = np.asarray(ids, dtype=np.int64)
        row = np.searchsorted(self._grid_id, wanted).clip(max=len(self._grid_id) - 1)
        absent = self._grid_id[row] != wanted
        for grid in np.unique(wanted[absent]):
            owner = f" of element {owners[np.argwhere(absent & (wanted == grid))[0, 0]]}" if len(owners) else ""
            self._missing.append(f"{who}: grid {grid}{owner}")
        return np.asarray(row, dtype=np.int64)

    def card(self, table: dict[int, Any], key: int, *kinds: str, who: str) -> Any:
        """The card `key` of one of the types `kinds`, or None after noting that it is missing."""
        found = table.get(key)
        if found is None or found.type not in kinds:
            self._missing.append(f"{who}: {' or '.join(kinds)} {key}")
            return None
        return found

    def refuse_missing(self) -> None:
        if self._missing:
            some = "; ".join(self._missing[:10]) + (" ..." if len(self._missing) > 10 else "")
            raise InputError(
                f"{len(self._missing)} reference(s) to cards that do not exist: {some}", where=str(self._path)
            )


def material_of(model: Any, references: CardReferences, pid: int, *kinds: str) -> tuple[Any, Any]:
    """Property and MAT1 of an element, each None where missing."""
    prop = references.card(model.properties, pid, *kinds, who="elements")
    mat = references.card(model.materials, prop.mid, "MAT1", who=f"{prop.type} {pid}") if prop else None
    return prop, mat
