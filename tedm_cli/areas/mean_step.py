"""How much of its step each thermal area gives to its own elements: grids of a neighbour take their part of it away."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy

from tedm_cli.areas.places import corner_areas, element_owners
from tedm_cli.arrays import IntArray
from tedm_cli.nastran.geometry import ModelGeometry
from tedm_cli.nastran.loads.area_loads import AreaLoad, none
from tedm_cli.nastran.loads.element_temperatures import LINES, SHELLS
from tedm_cli.nastran.node_volumes import node_volumes

LEAST = 0.8
"""Mean step below which an area is warned of."""


@dataclass(frozen=True, eq=False)
class MeanStep:
    """Mean over the elements of an area of the step that they get, by volume; 1: all of it. NaN: it has no elements.

    elements : ids, ascending. carriers : how many of them may have a temperature of their own: shells, bars and rods.
    """

    area: str
    share: float
    elements: IntArray
    carriers: int


def mean_steps(
    geometry: ModelGeometry, loads: Mapping[str, AreaLoad], selected: Mapping[str, IntArray]
) -> list[MeanStep]:
    """The mean step of each area over its own elements, in units of the step; NaN of areas under a gradient.

    The own elements are those that its definition selects, but for what has a temperature of its own in another area.
    Where there are none they are those of whose grids no other area has more; an element that several areas have evenly
    counts in each for its part. Where there are none of these either, they are those with any grid of the area. Springs
    and the like have no volume to expand, and are none.

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
    grids, warmed = (scipy.sparse.csc_array((v, place), shape=shape) for v in (np.ones(len(element)), volume))
    for table in (grids, warmed):
        table.sum_duplicates()
    most = grids.max(axis=1).toarray().reshape(-1)
    evenly = np.bincount(grids.indices, grids.data == most[grids.indices], len(e.id))
    may_carry = np.isin(e.type, (*SHELLS, *LINES))
    got = np.zeros(len(e.id))
    out = []
    for number, (name, load) in enumerate(loads.items()):
        if load.gradient is not None:
            out.append(MeanStep(name, float("nan"), load.element_id, len(load.element_id)))
            continue
        column = slice(grids.indptr[number], grids.indptr[number + 1])
        rows = grids.indices[column]
        chosen = np.searchsorted(e.id, selected.get(name, none()))
        chosen = chosen[(owner[chosen] < 0) | (owner[chosen] == number)]
        first = grids.data[column] == most[rows]
        choices = ((chosen, 1.0), (rows[first], 1.0 / evenly[rows[first]]), (rows, 1.0))
        own, weight = next(((r, expands[r] * w) for r, w in choices if expands[r].any()), (rows[:0], np.zeros(0)))
        got[rows] = warmed.data[column]
        whole = float(weight @ size[own])
        share = float(weight @ got[own]) / whole if whole else float("nan")
        own = own[weight > 0.0]
        out.append(MeanStep(name, share, e.id[own], int(may_carry[own].sum())))
        got[rows] = 0.0
    return out
