"""Thermal areas as sums over what the adjoint says of every grid and element."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.fem.adjoint import TemperatureSensitivity


@dataclass(frozen=True, eq=False, kw_only=True)
class Warmed:
    """What one unit of an area's temperature warms.

    grid : [n], rows of the grids; what takes the temperatures of its grids takes the step from them.
    element : [m], rows of the shells, bars and rods that have the step by themselves.
    step : [n], of these grids, where they do not all have 1: a field, whose elements all follow their grids.
    gradient : [m, 2], 1, of these elements in planes 1 and 2, where the unit is K/m; None of a mean temperature in K.
    """

    grid: IntArray
    element: IntArray
    gradient: FloatArray | None = None
    step: FloatArray | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Temperatures:
    """Temperatures that r outputs follow: those of N grids, and of L shells, bars and rods that may have their own.

    grid : [r, N], per kelvin of a grid, of all that takes the temperatures of its grids: no element of `own`.
    own : [L], elements that have temperatures of their own in some area.
    mean, gradient : [r, L], per kelvin of an element's own mean; [r, L, 2], per K/m in planes 1 and 2 over its length.
    """

    grid: FloatArray
    own: BoolArray
    mean: FloatArray
    gradient: FloatArray

    def terms(self, area: Warmed) -> FloatArray:
        """Terms [r, n + m] of an area's sensitivity, those of grids first; they sum to the column of its unit load."""
        if area.gradient is None:
            of_elements = self.mean[:, area.element]
        else:
            of_elements = np.einsum("rmp,mp->rm", self.gradient[:, area.element], area.gradient)
        of_grids = self.grid[:, area.grid]
        return np.concatenate([of_grids if area.step is None else of_grids * area.step, of_elements], axis=1)

    def sums(self, areas: Sequence[Warmed]) -> FloatArray:
        """Sensitivity [r, k] to the areas; the structure's share of S_SG and N."""
        return np.array([self.terms(area).sum(axis=1) for area in areas]).T

    def cancellation(self, areas: Sequence[Warmed]) -> FloatArray:
        """Sum of the sizes of the terms over the size of their sum, [r, k], 1 or more.

        Where it is large, an even temperature of the area hides what an uneven one would do. Infinite where terms
        cancel altogether, NaN where nothing of the area acts on the output.
        """
        out = np.empty((len(self.grid), len(areas)))
        for number, area in enumerate(areas):
            terms = self.terms(area)
            with np.errstate(divide="ignore", invalid="ignore"):
                out[:, number] = np.abs(terms).sum(axis=1) / np.abs(terms.sum(axis=1))
        return out


def temperatures(found: TemperatureSensitivity, own: BoolArray) -> Temperatures:
    """Of all that follows its grids, where the elements `own` [L] do not."""
    return Temperatures(grid=found.felt(own), own=own, mean=found.mean, gradient=found.gradient.sum(axis=2))


@dataclass(frozen=True, eq=False, kw_only=True)
class Places:
    """Where temperatures are, and how much of the structure has them; basic frame, m and m³.

    grid, grid_volume : [N, 3] and [N], the integral of each grid's shape functions over the elements that follow it,
        which is negative at corners of some quadratic ones: weighted by it, linear fields have their exact means.
    element, element_volume : [L, 3] and [L], of elements with temperatures of their own.
    """

    grid: FloatArray
    grid_volume: FloatArray
    element: FloatArray
    element_volume: FloatArray

    def at(self, area: Warmed) -> FloatArray:
        """Places [n + m, 3] of what is warmed."""
        return np.concatenate([self.grid[area.grid], self.element[area.element]])

    def weight(self, area: Warmed) -> FloatArray:
        """Volumes [n + m] of what is warmed."""
        return np.concatenate([self.grid_volume[area.grid], self.element_volume[area.element]])

    def centroid(self, area: Warmed) -> FloatArray:
        """Of what is warmed, weighted by volume, [3]."""
        weight = self.weight(area)
        if not weight.sum() > 0.0:  # corners of quadratic elements alone, or grids of none
            weight = np.ones(len(weight))
        return np.asarray(weight @ self.at(area) / weight.sum())


def gradient_sensitivity(of: Temperatures, areas: Sequence[Warmed], places: Places) -> FloatArray:
    """Sensitivity [r, k, 3] to a gradient of 1 K/m along x, y, z within each area, zero at its centroid.

    The rest of the structure keeps its temperature. NaN of areas that are gradients through shells and bars.
    """
    out = np.full((len(of.grid), len(areas), 3), np.nan)
    for number, area in enumerate(areas):
        if area.gradient is None:
            out[:, number] = of.terms(area) @ (places.at(area) - places.centroid(area))
    return out
