"""Levers between optical elements and the grids that carry them: long ones are slips, or must be said to be meant."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.optics.benches import benches
from tedm_cli.optics.layout import Element, OpticalLayout
from tedm_cli.optics.sensitivity import reference_offsets

_COMMON = 0.1  # spread of the offsets of a bench that is off as a whole, relative


@dataclass(frozen=True, eq=False)
class Levers:
    """Elements far from their grids, but for those whose lever is said to be meant, with lengths in m.

    long : longer than `limit_m`; too_long : longer than the bench, too, which is size_m.
    common_m : [3], the offset of all these elements, basic frame, where it is nearly the same; else None.
    """

    limit_m: float
    long: tuple[tuple[Element, float], ...]
    too_long: tuple[tuple[Element, float], ...]
    size_m: float
    common_m: FloatArray | None


def long_levers(layout: OpticalLayout, node_positions_m: FloatArray, model_size_m: float = math.inf) -> Levers:
    """Judge the distance of every element's reference point from its grid.

    A bench is as large as the largest distance between the reference points of the element's neighbours on it, so that
    one that is off by kilometres does not make room for itself; it cannot be larger than the model. One of less than
    three elements has no size of its own, and stands for all benches.

    Parameters
    ----------
    node_positions_m : grids of the bench elements in layout order, [n_bench, 3] m, basic frame.
    model_size_m : diagonal of the finite-element model.
    """
    offset = reference_offsets(layout, node_positions_m)
    length = np.linalg.norm(offset, axis=1)
    limit = layout.tolerances.lever_m
    on_bench = benches(layout).values()
    long, too_long, sizes = [], [], []
    for i, e in enumerate(layout.bench):
        if e.lever_ok or length[i] <= limit:
            continue
        own = next(members for members in on_bench if e in members)
        others = [o.ref_m for o in (own if len(own) > 2 else layout.bench) if o is not e]
        size = min(_largest_distance(np.array(others).reshape(-1, 3)), model_size_m)
        found = (e, float(length[i]))
        if length[i] > max(size, limit):
            too_long.append(found)
            sizes.append(size)
        else:
            long.append(found)
    far = offset[[layout.bench.index(e) for e, _ in (*long, *too_long)]]
    return Levers(limit, tuple(long), tuple(too_long), max(sizes, default=0.0), _common(far, layout.axes))


def _common(offset: FloatArray, axes: FloatArray) -> FloatArray | None:
    """The mean of offsets [n, 3] that hardly differ, basic frame; `axes`: those of the layout."""
    if len(offset) < 3:
        return None
    mean = offset.mean(axis=0)
    spread = np.linalg.norm(offset - mean, axis=1).max()
    return np.asarray(mean @ axes) if spread < _COMMON * np.linalg.norm(mean) else None


def _largest_distance(points: FloatArray) -> float:
    return float(np.linalg.norm(points[:, None] - points, axis=2).max(initial=0.0))
