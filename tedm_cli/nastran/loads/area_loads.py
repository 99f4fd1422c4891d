"""What the unit load of a thermal area acts on: grids by TEMP, elements by cards of their own."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.nastran.loads.element_temperatures import LINES, SHELLS

WITH_CARD = (*SHELLS, *LINES)
SOLIDS = ("CTETRA", "CPYRAM", "CPENTA", "CHEXA")
GRADIENT_DIGITS = 1e-4
"""Relative difference of gradients that small fields of cards with directions do not hold apart."""
_PARALLEL = 0.99  # cosine of the angle between the gradients of two areas in one element


def none() -> IntArray:
    """No ids, or no rows."""
    return np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class AreaLoad:
    """Ids, ascending, of what a unit load acts on.

    grid_id : grids that get the step; what has no temperature of its own among elements takes those of its grids.
    element_id [m] : elements that get the step by a card of their own. held_id : elements with temperatures of their
    own in other areas, that a card keeps at rest because they have warm grids.
    gradient : [m, 2], K/m, of a gradient, along `gradient_axes` of each element; None of a mean temperature.
    """

    grid_id: IntArray
    element_id: IntArray
    held_id: IntArray
    gradient: FloatArray | None = None

    @property
    def kind(self) -> str:
        return "mean" if self.gradient is None else "gradient"


def uniform_load(loads: Iterable[AreaLoad]) -> AreaLoad:
    """All mean temperatures together."""
    means = [load for load in loads if load.gradient is None]
    return AreaLoad(
        np.sort(np.concatenate([load.grid_id for load in means])),
        np.sort(np.concatenate([load.element_id for load in means])),
        none(),
    )


@dataclass(frozen=True, eq=False)
class Mesh:
    """Which elements take the temperatures of their grids, of a mesh with grids [N], elements [E], nodes [M].

    structural [N]: corners of elements; card [E]; node_offset [E+1], node_index [M].
    """

    structural: BoolArray
    card: NDArray[np.str_]
    node_offset: IntArray
    node_index: IntArray

    @cached_property
    def with_card(self) -> BoolArray:
        """Elements [E] that may have a temperature of their own."""
        return np.isin(self.card, WITH_CARD)

    @cached_property
    def solid(self) -> BoolArray:
        """Elements [E] that have the temperatures of their grids in any case."""
        return np.isin(self.card, SOLIDS)

    def grids_of(self, elements: BoolArray) -> BoolArray:
        """Grids [N] of the elements chosen [E]."""
        mask = np.zeros(len(self.structural), dtype=bool)
        mask[self.node_index[np.repeat(elements, np.diff(self.node_offset))]] = True
        return mask

    def touching(self, grids: BoolArray) -> BoolArray:
        """Elements [E] with any of the grids chosen [N]."""
        hits = np.concatenate([[0], np.cumsum(grids[self.node_index])])[self.node_offset]
        return np.asarray(np.diff(hits) > 0)

    def within(self, grids: BoolArray) -> BoolArray:
        """Elements [E] all of whose grids are among those chosen [N]."""
        outside = np.concatenate([[0], np.cumsum(~grids[self.node_index])])[self.node_offset]
        return np.asarray((np.diff(outside) == 0) & (np.diff(self.node_offset) > 0))

    def owner(self, of_grid: IntArray) -> IntArray:
        """The owner [E] that all grids of an element have (`of_grid`, [N]); -1 where they differ."""
        own = of_grid[self.node_index]
        counts = np.diff(self.node_offset)
        first = np.full(len(counts), -1)
        first[counts > 0] = own[self.node_offset[:-1][counts > 0]]
        other = np.concatenate([[0], np.cumsum(own != np.repeat(first, counts))])[self.node_offset]
        return np.where(np.diff(other) == 0, first, -1)

    def followed(self, owned: BoolArray) -> BoolArray:
        """Structural grids [N] whose temperature is felt, when the elements `owned` [E] have temperatures of their own.

        Grids of springs alone are among them, as long as no such element is on them too.
        """
        if not owned.any():
            return self.structural
        follow = self.solid | (self.with_card & ~owned)
        return self.structural & (self.grids_of(follow) | ~self.grids_of(owned))


def parallel(one: FloatArray, other: FloatArray) -> BoolArray:
    """Elements [m] in which two gradients [m, 2] are the same load, but for size and sign."""
    size = np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
    return np.asarray(np.abs((one * other).sum(axis=1)) > _PARALLEL * size)
