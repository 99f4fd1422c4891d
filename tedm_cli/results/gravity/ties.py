"""The grids that compensation masses follow, as unit_loads.h5 tells them, against what the configuration says now."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import IntArray
from tedm_cli.contracts import UNIT_LOADS
from tedm_cli.errors import InputError
from tedm_cli.files.store import Reader
from tedm_cli.gravity.compensation import CompensationMass
from tedm_cli.gravity.ties import needs_rotations


@dataclass(frozen=True, eq=False)
class Ties:
    """Tied blocks: their names, what the configuration ties them to, and the rows of their grids, ascending."""

    block: list[str]
    to: list[str]
    offset: IntArray
    index: IntArray

    @classmethod
    def of(cls, block: list[str], to: list[str], rows: Sequence[IntArray]) -> Ties:
        """From the rows of each block."""
        index = np.concatenate([np.zeros(0, dtype=np.int64), *rows])
        return cls(block, to, np.cumsum([0, *map(len, rows)]), index)

    def rows(self, block: str) -> IntArray:
        """Rows of the grids that a block follows; none of one that stays still."""
        if block not in self.block:
            return np.zeros(0, dtype=np.int64)
        number = self.block.index(block)
        return self.index[self.offset[number] : self.offset[number + 1]]


def read_ties(unit: Reader) -> Ties:
    """The ties in unit_loads.h5."""
    return Ties(
        unit.strings(UNIT_LOADS.TIE_BLOCK),
        unit.strings(UNIT_LOADS.TIE_TO),
        unit.array(UNIT_LOADS.TIE_NODE_OFFSET),
        unit.array(UNIT_LOADS.TIE_NODE_INDEX),
    )


def turning_grids(unit: Reader) -> IntArray:
    """Rows of the grids in unit_loads.h5 whose rotations turn tied blocks, ascending."""
    ties = read_ties(unit)
    if not ties.block:
        return ties.index
    position = unit.array(UNIT_LOADS.GRID_POSITION)
    found = [rows for rows in map(ties.rows, ties.block) if needs_rotations(position[rows])]
    return np.asarray(np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *found])))


def require_ties(unit: Reader, blocks: Sequence[CompensationMass]) -> Ties:
    """The ties in unit_loads.h5; `InputError` where the configuration ties blocks to something else now."""
    ties = read_ties(unit)
    then = dict(zip(ties.block, ties.to, strict=True))
    now = {block.name: block.tie.words for block in blocks if block.tie is not None}
    changed = [name for name in dict.fromkeys((*now, *then)) if now.get(name) != then.get(name)]
    if changed:
        name = changed[0]
        more = f" ({len(changed) - 1} more differ)" if len(changed) > 1 else ""
        raise InputError(
            f"is stale: compensation mass {name!r} was {_follows(then.get(name))} when it was made, and is"
            f" {_follows(now.get(name))} now{more}",
            where=str(unit.path),
            hint="begin again with `tedm ingest`, or run make all",
        )
    return ties


def _follows(to: str | None) -> str:
    return "tied to nothing" if to is None else f"tied to {to}"
