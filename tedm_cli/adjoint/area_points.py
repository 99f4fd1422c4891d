"""The temperatures of areas as points of a temperature field."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.adjoint.areas import Places, Temperatures, Warmed
from tedm_cli.adjoint.temperature_field import FieldPoints
from tedm_cli.arrays import FloatArray, IntArray

_LEAST = 1e-9  # of the mean volume: what a point has at least


@dataclass(frozen=True, eq=False, kw_only=True)
class AreaPoints:
    """n points: the grids of areas of mean temperatures, then their elements with a temperature of their own.

    points : of a field of the same amplitude everywhere. area : [n], the area of each. grid : [g], rows of the grids
    that the first g points are.
    """

    points: FieldPoints
    area: IntArray
    grid: IntArray


def area_points(of: Temperatures, direct: FloatArray, areas: Sequence[Warmed], places: Places) -> AreaPoints:
    """The points of k areas, as r outputs feel them.

    A volume counts without its sign, and a point without any with next to none. `direct` [r, k], what follows the mean
    temperature of an area past the structure, is spread over the area by volume.
    """
    owner, of_element = np.full(len(places.grid), -1), np.full(len(places.element), -1)
    for number, area in enumerate(areas):
        if area.gradient is None:
            owner[area.grid] = number
            of_element[area.element] = number
    grid, own = np.flatnonzero(owner >= 0), np.flatnonzero(of.own)
    at = np.concatenate([places.grid[grid], places.element[own]])
    size = np.concatenate([np.abs(places.grid_volume[grid]), places.element_volume[own]])
    size = np.maximum(size, _LEAST * size.mean())
    area_of = np.concatenate([owner[grid], of_element[own]])
    felt = np.concatenate([of.grid[:, grid], of.mean[:, own]], axis=1)
    felt += direct[:, area_of] * size / np.bincount(area_of, size, len(areas))[area_of]
    return AreaPoints(points=FieldPoints(position=at, volume=size, sensitivity=felt), area=area_of, grid=grid)
