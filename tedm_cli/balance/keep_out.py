"""Where no mass may be: cuboids that blocks must not reach into."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.gravity.compensation import CompensationMass
from tedm_cli.gravity.testmass import cuboid_gap

_FLUSH_M = 1e-7  # bodies that reach into each other by less only touch


@dataclass(frozen=True, eq=False)
class KeepOut:
    """A cuboid where no mass may be, and the gap that a block must leave to it (m); axes as rows, basic frame."""

    name: str
    centre_m: FloatArray
    size_m: FloatArray
    axes: FloatArray
    clearance_m: float = 0.0

    def is_met_by(self, block: CompensationMass) -> bool:
        """Whether a block reaches into it, or is nearer than it may be."""
        gap = cuboid_gap(self.centre_m, self.size_m, self.axes, block.centre_m, block.size_m, block.axes)
        return gap < self.clearance_m - _FLUSH_M


@dataclass(frozen=True, eq=False)
class Elements:
    """Cuboids [n, 3] along the basic axes that hold the elements of a structure, by their names [n]."""

    name: Sequence[str]
    low_m: FloatArray
    high_m: FloatArray

    def met_by(self, block: CompensationMass) -> list[str]:
        """Names of those that a block reaches into.

        Two cuboids are apart if they are so along a face normal of one of them, or across an edge of each.
        """
        half = block.size_m / 2.0
        reach = half @ np.abs(block.axes)  # of the block along the basic axes
        near = np.flatnonzero(
            ((self.low_m < block.centre_m + reach - _FLUSH_M) & (self.high_m > block.centre_m - reach + _FLUSH_M)).all(
                axis=1
            )
        )
        if not near.size:
            return []
        edges = np.cross(block.axes[:, None, :], np.eye(3)[None]).reshape(9, 3)
        length = np.linalg.norm(edges, axis=1)
        directions = np.concatenate([block.axes, edges[length > 1e-9] / length[length > 1e-9, None]])
        middle, size = (self.low_m[near] + self.high_m[near]) / 2.0, (self.high_m[near] - self.low_m[near]) / 2.0
        gap = np.abs((middle - block.centre_m) @ directions.T) - size @ np.abs(directions).T
        gap -= half @ np.abs(block.axes @ directions.T)
        return [self.name[i] for i in near[(gap < -_FLUSH_M).all(axis=1)]]


def met_by(block: CompensationMass, keep_outs: Sequence[KeepOut]) -> list[str]:
    """Names of what a block reaches into."""
    return [one.name for one in keep_outs if one.is_met_by(block)]


def overlapping(blocks: Sequence[CompensationMass]) -> list[tuple[str, str]]:
    """Pairs of blocks that reach into each other, by name."""
    reach = np.array([block.size_m / 2.0 @ np.abs(block.axes) for block in blocks]).reshape(-1, 3)
    centre = np.array([block.centre_m for block in blocks]).reshape(-1, 3)
    found = []
    for i, first in enumerate(blocks):
        close = (np.abs(centre[i + 1 :] - centre[i]) < reach[i + 1 :] + reach[i] - _FLUSH_M).all(axis=1)
        for j in np.flatnonzero(close) + i + 1:
            second = blocks[j]
            gap = cuboid_gap(first.centre_m, first.size_m, first.axes, second.centre_m, second.size_m, second.axes)
            if gap < -_FLUSH_M:
                found.append((first.name, second.name))
    return found
