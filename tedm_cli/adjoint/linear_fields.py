"""Temperatures that are straight across a body of thermal areas, from what the areas do alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.adjoint.areas import Places, Warmed
from tedm_cli.arrays import FloatArray, IntArray


@dataclass(frozen=True, eq=False, kw_only=True)
class AreaShapes:
    """Where k areas are, basic frame; NaN of areas that are gradients through shells and bars.

    middle : [k, 3], m, centroid by volume. volume : [k], m³. low, high : [k, 3], m, smallest and largest coordinates of
    the grids, and of the centres of elements that have temperatures of their own.
    """

    middle: FloatArray
    volume: FloatArray
    low: FloatArray
    high: FloatArray

    def middle_of(self, members: IntArray) -> FloatArray:
        """Centroid [3] of areas together."""
        weight = self.volume[members]
        return np.asarray(weight @ self.middle[members] / weight.sum())

    def extent_of(self, members: IntArray) -> FloatArray:
        """From end to end of areas together along each axis, [3], m."""
        return np.asarray(self.high[members].max(axis=0) - self.low[members].min(axis=0))


def area_shapes(areas: Sequence[Warmed], places: Places) -> AreaShapes:
    """Of what each area warms."""
    k = len(areas)
    middle, low, high = (np.full((k, 3), np.nan) for _ in range(3))
    volume = np.full(k, np.nan)
    for number, area in enumerate(areas):
        if area.gradient is None:
            at = places.at(area)
            middle[number], volume[number] = places.centroid(area), places.weight(area).sum()
            low[number], high[number] = at.min(axis=0), at.max(axis=0)
    return AreaShapes(middle=middle, volume=volume, low=low, high=high)


def linear_field(value: FloatArray, gradient: FloatArray, shapes: AreaShapes, members: IntArray) -> FloatArray:
    """Sensitivity [r, 3] to 1 K/m along x, y, z across areas together, zero at their centroid.

    Of T = e · (x - x̄), an area at x̄_a has the mean e · (x̄_a - x̄), and within it the gradient e: what it does is its
    sensitivity to a mean temperature times the first, and to the gradient.

    Parameters
    ----------
    value : [r, k], per kelvin of each area. gradient : [r, k, 3], per K/m within it.
    """
    away = shapes.middle[members] - shapes.middle_of(members)
    return np.asarray(gradient[:, members].sum(axis=1) + value[:, members] @ away)
