"""Levers between optical elements and the grids that carry them: long ones are slips, or must be said to be meant."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.optics.layout import Element, OpticalLayout
from tedm_cli.optics.sensitivity import reference_offsets

_COMMON = 0.1  # spread of the offsets of a bench that is off as a whole, relative


@dataclass(frozen=True, eq=False)
class Levers:
    """Elements far from their grids, but for those whose lever is said to be meant, with lengths in m.

    long : longer than `limit_m`; too_long : longer than the bench, too, which is size_m.
    common_m : [3], the offset of all elements of the bench, basic frame, where they have nearly the same; else None.
    """

    limit_m: float
    long: tuple[tuple[Element, float], ...]
    too_long: tuple[tuple[Element, float], ...]
    size_m: float
    common_m: FloatArray | None


def long_levers(layout: OpticalLayout, node_positions_m: FloatArray, model_size_m: float = math.inf) -> Levers:
    """Judge the distance of every element's reference point from its grid.

    The bench is as large as the largest distance between the reference points of the other elements, so that one that
    is off by kilometres does not make room for itself; it cannot be larger than the model.

    Parameters
    ----------
    node_positions_m : grids of the bench elements in layout order, [n_bench, 3] m, basic frame.
    model_size_m : diagonal of the finite-element model.
    """
    offset = reference_offsets(layout, node_positions_m)
    length = np.linalg.norm(offset, axis=1)
    refs = np.array([e.ref_m for e in layout.bench])
    limit = layout.tolerances.lever_m
    long, too_long, sizes = [], [], []
    for i, e in enumerate(layout.bench):
        if e.lever_ok or length[i] <= limit:
            continue
        size = min(_largest_distance(np.delete(refs, i, axis=0)), model_size_m)
        found = (e, float(length[i]))
        if length[i] > max(size, limit):
            too_long.append(found)
            sizes.append(size)
        else:
            long.append(found)
    mean = offset.mean(axis=0)
    spread = float(np.linalg.norm(offset - mean, axis=1).max())
    is_common = len(length) > 1 and bool(np.linalg.norm(mean) > limit) and spread < _COMMON * np.linalg.norm(mean)
    return Levers(
        limit, tuple(long), tuple(too_long), max(sizes, default=0.0), mean @ layout.axes if is_common else None
    )


def _largest_distance(points: FloatArray) -> float:
    return float(np.linalg.norm(points[:, None] - points[None], axis=2).max(initial=0.0))
