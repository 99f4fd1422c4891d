"""How much of its step each thermal area gives to its own elements: grids of a neighbour take their part of it away."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array

from tedm_cli.arrays import IntArray
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
    geometry: ModelGeometry, warm: Mapping[str, IntArray], selected: Mapping[str, IntArray]
) -> list[MeanStep]:
    """The mean step of each area over its own elements, in units of the step.

    The own elements are those that its definition selects. Where it selects none they are those of whose grids no other
    area has more; an element that several areas have evenly counts in each for its part. Where there are none of these
    either, they are those with any grid of the area. Springs and the like have no volume to expand, and are none.

    Parameters
    ----------
    warm : rows of the grids that each area warms; no grid is in two. selected : ids of the elements that definitions
        select, by area.
    """
    e = geometry.elements
    element = np.repeat(np.arange(len(e.id)), np.diff(e.node_offset))
    volume = node_volumes(geometry)
    size = np.bincount(element, volume, len(e.id))
    expands = np.bincount(element, volume != 0.0, len(e.id)) > 0.0
    label = np.full(len(geometry.grid_id), len(warm))
    for number, rows in enumerate(warm.values()):
        label[rows] = number
    place, shape = (element, label[e.node_index]), (len(e.id), len(warm) + 1)
    grids, warmed = (csc_array((v, place), shape=shape) for v in (np.ones(len(element)), volume))
    most = grids.max(axis=1).toarray().reshape(-1)
    grids.sum_duplicates()
    evenly = np.bincount(grids.indices, grids.data == most[grids.indices], len(e.id))
    out = []
    for number, name in enumerate(warm):
        has, part = (m[:, [number]].toarray().reshape(-1) for m in (grids, warmed))
        first = (has > 0.0) & (has == most)
        choices = (
            np.isin(e.id, selected.get(name, [])),
            np.where(first, 1.0 / np.maximum(evenly, 1.0), 0.0),
            has > 0.0,
        )
        weight = next((w for c in choices if (w := expands * c).any()), np.zeros(len(e.id)))
        own = np.flatnonzero(weight)
        whole = float(weight @ size)
        out.append(MeanStep(name, float(weight @ part) / whole if whole else float("nan"), e.id[own]))
    return out
