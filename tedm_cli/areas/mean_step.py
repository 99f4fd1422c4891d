"""How much of its step each thermal area gives to its own elements: grids of a neighbour take their part of it away."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array

from tedm_cli.areas.places import corner_areas, element_owners
from tedm_cli.arrays import IntArray
from tedm_cli.nastran.area_loads import AreaLoad
from tedm_cli.nastran.geometry import ModelGeometry
from tedm_cli.nastran.node_volumes import node_volumes

LEAST = 0.8
"""Mean step below which an area is warned of."""


@dataclass(frozen=True, eq=False)
class MeanStep:
    """Mean over the elements of an area of the step that they get, by volume; 1: all of it. NaN: it has no elements.

    elements : ids, ascending.
    """

    area: str
    share: float
    elements: IntArray


def mean_steps(
    geometry: ModelGeometry, loads: Mapping[str, AreaLoad], selected: Mapping[str, IntArray]
) -> list[MeanStep]:
    """The mean step of each area over its own elements, in units of the step; NaN of areas under a gradient.

    The own elements are those that its definition selects, but for what has a temperature of its own in another area.
    Where there are none they are those of whose grids no other area has more; an element that several areas have evenly counts in each
    for its part. Where there are none of these either, they are those with any grid of the area. Springs and the like
    have no volume to expand, and are none.

    Parameters
    ----------
    loads : of the areas; no grid and no element is in two of a mean temperature. selected : ids of the elements that
        definitions select, by area.
    """
    e = geometry.elements
    element = np.repeat(np.arange(len(e.id)), np.diff(e.node_offset))
    volume = node_volumes(geometry)
    size = np.bincount(element, volume, len(e.id))
    expands = np.bincount(element, volume != 0.0, len(e.id)) > 0.0
    owner = element_owners(geometry, loads.values())
    area = corner_areas(geometry, loads.values(), owner)
    place, shape = (element, np.where(area < 0, len(loads), area)), (len(e.id), len(loads) + 1)
    grids, warmed = (csc_array((v, place), shape=shape) for v in (np.ones(len(element)), volume))
    most = grids.max(axis=1).toarray().reshape(-1)
    grids.sum_duplicates()
    evenly = np.bincount(grids.indices, grids.data == most[grids.indices], len(e.id))
    out = []
    for number, (name, load) in enumerate(loads.items()):
        if load.gradient is not None:
            out.append(MeanStep(name, float("nan"), load.element_id))
            continue
        has, part = (m[:, [number]].toarray().reshape(-1) for m in (grids, warmed))
        first = (has > 0.0) & (has == most)
        chosen = np.isin(e.id, selected.get(name, [])) & ((owner < 0) | (owner == number))
        choices = (chosen, np.where(first, 1.0 / np.maximum(evenly, 1.0), 0.0), has > 0.0)
        weight = next((w for c in choices if (w := expands * c).any()), np.zeros(len(e.id)))
        whole = float(weight @ size)
        share = float(weight @ part) / whole if whole else float("nan")
        out.append(MeanStep(name, share, e.id[np.flatnonzero(weight)]))
    return out
