"""How far limited quantities may be off because masses and places of parts are: first-order margins of a programme.

A source of deviation, such as the place of one block along x, changes every quantity by so much per standard deviation.
Of the worst case the magnitudes of all sources add up, which is what k deviations of each at once would do. Of the root
sum of squares they add as independent deviations do. Both are convex in the masses, so tangents never ask for too much;
they are added where a solution needs them, until it has room for what it may be off itself.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeVar

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.balance.programme import Programme
from tedm_cli.errors import PhysicsError

Sum = Literal["worst case", "root sum of squares"]
Found = TypeVar("Found")
_ENOUGH = 1e-6  # of a range: a solution that lacks less room has enough
_MOST = 60


@dataclass(frozen=True, eq=False)
class Source:
    """What one standard deviation of something does to r quantities, SI.

    column : [n], the unknowns that it comes with; by_unit : [r, n], by one unit of each. by_rest : [r].
    """

    name: str
    column: IntArray
    by_unit: FloatArray
    by_rest: FloatArray

    def change(self, units: FloatArray) -> FloatArray:
        """[r], of masses of so many units."""
        return np.asarray(self.by_rest + self.by_unit @ units[self.column])


@dataclass(frozen=True, eq=False)
class Deviations:
    """All sources, how they are summed, and how many standard deviations count."""

    sources: Sequence[Source]
    sum: Sum
    sigmas: float

    def changes(self, units: FloatArray) -> FloatArray:
        """[s, r], by one standard deviation of each source."""
        return np.array([source.change(units) for source in self.sources])

    def off(self, units: FloatArray) -> FloatArray:
        """[r], how far quantities may be off, SI."""
        changes = self.changes(units)
        if self.sum == "worst case":
            return np.asarray(self.sigmas * np.abs(changes).sum(axis=0))
        return np.asarray(self.sigmas * np.sqrt((changes**2).sum(axis=0)))

    def tangent(self, units: FloatArray) -> tuple[FloatArray, FloatArray]:
        """By unit [r, c] and by the rest [r]: what `off` is at `units`, and is nowhere less than."""
        changes = self.changes(units)
        if self.sum == "worst case":
            weight = np.sign(changes)
        else:
            norm = np.sqrt((changes**2).sum(axis=0))
            weight = np.where(norm > 0.0, changes / np.where(norm > 0.0, norm, 1.0), 0.0)
        by_unit, by_rest = np.zeros((changes.shape[1], len(units))), np.zeros(changes.shape[1])
        for source, own in zip(self.sources, weight, strict=True):
            by_unit[:, source.column] += self.sigmas * own[:, None] * source.by_unit
            by_rest += self.sigmas * own * source.by_rest
        return by_unit, by_rest


def with_room(
    programme: Programme,
    deviations: Deviations | None,
    solve: Callable[[Programme], tuple[FloatArray, FloatArray, Found]],
) -> tuple[Programme, Found]:
    """Solve a programme that has room for its deviations.

    Parameters
    ----------
    solve : of a programme, the numbers of units [c], the largest ratio that each requirement was allowed [r], and more.

    Returns
    -------
    The programme with the tangents that it took, and what else `solve` found.

    Raises
    ------
    PhysicsError : the tangents do not come to an end.
    """
    units, cap, found = solve(programme)
    if deviations is None:
        return programme, found
    reached = programme.reached
    for _ in range(_MOST):
        lacking = programme.ratios(units, deviations.off(units)) - cap
        if programme.off and (lacking[reached] <= _ENOUGH).all():
            return programme, found
        programme = replace(programme, off=(*programme.off, deviations.tangent(units)))
        units, cap, found = solve(programme)
    raise PhysicsError("the margins for tolerances do not settle", hint="look for tolerances that are far too wide")
