"""How good a mapped field is: averages that it keeps, and how much it changes across elements."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.mapping.averages import NONE, Volumes
from tedm_cli.mapping.node_map import ConductedMap

_BLOCK = 64  # sets at a time
_ALIKE = 1e-9  # elements that symmetry makes alike differ by rounding: the first of them is named


@dataclass(frozen=True, eq=False)
class Quality:
    """Of m sets of temperatures.

    kept : [m], K, the largest difference of a node's temperature and the average over its elements.
    jump : [m], K, the largest difference between two grids of one element; element : [m], row of that element, `NONE`
        where there is no change.
    step : [m], K, the same where each grid of a node's elements has the node's temperature, as TEMP cards of areas
        give it (that of the first node where it is of several).
    """

    kept: FloatArray
    jump: FloatArray
    element: IntArray
    step: FloatArray


def quality(through: ConductedMap, of: Volumes, place_node: IntArray, tau: FloatArray, field: FloatArray) -> Quality:
    """Quality of a map with nodes at places [M], for temperatures [n, m] and the field [N, m] that it makes of them."""
    first = _first_nodes(of, place_node, len(field), through.nodes)
    some = [slice(start, start + _BLOCK) for start in range(0, max(tau.shape[1], 1), _BLOCK)]
    found = [_quality(through, of, first, tau[:, part], field[:, part]) for part in some]
    return Quality(*(np.concatenate([getattr(q, f.name) for q in found]) for f in fields(Quality)))


def _quality(through: ConductedMap, of: Volumes, first: IntArray, tau: FloatArray, field: FloatArray) -> Quality:
    """Quality of a few sets; `first` as `_first_nodes` has it."""
    known = np.where(through.mapped[:, None], field, 0.0)
    kept = np.abs(through.average @ known - tau).max(axis=0, initial=0.0)
    ranges = np.nan_to_num(element_ranges(of, field), nan=-1.0)
    largest = ranges.max(axis=0, initial=-1.0)
    at = np.where(largest > 0.0, (ranges >= (1.0 - _ALIKE) * largest).argmax(axis=0), NONE)
    jump = np.maximum(largest, 0.0)
    stepped = np.where((first != NONE)[:, None], tau[first], np.nan)
    step = np.nan_to_num(element_ranges(of, stepped)).max(axis=0, initial=0.0)
    return Quality(kept, jump, at, step)


def element_ranges(of: Volumes, field: FloatArray) -> FloatArray:
    """Largest less smallest temperature [E, m] of the grids of each element; NaN where it has none."""
    some = np.flatnonzero(np.diff(of.node_offset) > 0)
    out = np.full((len(of.node_offset) - 1, field.shape[1]), np.nan)
    if some.size:
        values, start = field[of.node_index], of.node_offset[some]
        out[some] = np.fmax.reduceat(values, start) - np.fmin.reduceat(values, start)
    return out


def _first_nodes(of: Volumes, place_node: IntArray, grids: int, nodes: int) -> IntArray:
    """The first node [N] that has a place at a grid; `NONE` where no node does."""
    first = np.full(grids, nodes)
    np.minimum.at(first, of.node_index[place_node != NONE], place_node[place_node != NONE])
    return np.where(first == nodes, NONE, first)
