"""Places for names beside what they name: clear of each other first, then of outlines, then of lines."""

from __future__ import annotations

import functools
import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path

from tedm_cli.arrays import BoolArray, FloatArray

_ANGLES = np.arange(24) * np.pi / 12
_GAPS = (2.5, 6.0, 11.0, 18.0, 27.0, 40.0)  # between name and outline, points
_FAR = 8.0  # gap from which a leader is of use
_COST_LABEL, _COST_BODY, _COST_LINE, _COST_OUTSIDE = 1000.0, 60.0, 25.0, 500.0


@dataclass(frozen=True, eq=False)
class Placed:
    """A name: middle of its box and half its size, in the units of the outlines; `far` where a leader is of use."""

    centre: FloatArray
    half: FloatArray
    far: bool


@functools.cache
def text_size(text: str, size_pt: float) -> FloatArray:
    """Width and height of a text in points."""
    font = FontProperties(family="DejaVu Sans", size=size_pt)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing")  # whoever shows an SVG has fonts of their own
        width, _, _ = text_to_path.get_text_width_height_descent(text, font, False)
    return np.array([width, size_pt])


def place_labels(
    names: Sequence[str], shapes: Sequence[FloatArray], obstacles: Sequence[FloatArray], lines: FloatArray,
    size_pt: float, per_pt: float, limits: tuple[FloatArray, FloatArray],
) -> list[Placed]:  # fmt: skip
    """A place for each name.

    Parameters
    ----------
    names, shapes : names and the outlines [m, 2] that they belong to.
    obstacles : all outlines that no name should cover; lines : [n, 2, 2], the same for segments.
    size_pt : size of the type; per_pt : units of the outlines in one point.
    limits : lower and upper corner of the room there is.
    """
    edges = np.concatenate([np.stack([s, np.roll(s, -1, axis=0)], axis=1) for s in obstacles])
    gap, angle = (a.reshape(-1) for a in np.meshgrid(_GAPS, _ANGLES, indexing="ij"))
    way = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    done: list[Placed] = []
    for name, shape in zip(names, shapes, strict=True):
        half = per_pt * (text_size(name, size_pt) / 2 + 1.0)
        middle = (shape.min(axis=0) + shape.max(axis=0)) / 2
        if _inside(shape, middle - 1.3 * half, middle + 1.3 * half):
            done.append(Placed(middle, half, False))
            continue
        reach = ((shape - middle) @ way.T).max(axis=0) + gap * per_pt + np.abs(way) @ half
        centre = middle + reach[:, None] * way
        low, high = centre - half, centre + half
        cost = 0.35 * gap + _COST_LINE * crossing(lines, low, high).sum(axis=1)
        cost += _COST_BODY * crossing(edges, low, high).sum(axis=1)
        cost += _COST_OUTSIDE * ((low < limits[0]).any(axis=1) | (high > limits[1]).any(axis=1))
        for other in done:
            cost += _COST_LABEL * np.all(np.abs(centre - other.centre) < half + other.half, axis=1)
        best = int(cost.argmin())
        done.append(Placed(centre[best], half, bool(gap[best] > _FAR)))
    return done


def _inside(shape: FloatArray, low: FloatArray, high: FloatArray) -> bool:
    """Whether a box lies inside a convex outline, counter-clockwise."""
    way = np.roll(shape, -1, axis=0) - shape
    corners = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
    out = corners[:, None] - shape
    return bool(np.all(way[:, 0] * out[..., 1] - way[:, 1] * out[..., 0] >= 0.0))


def crossing(segments: FloatArray, low: FloatArray, high: FloatArray) -> BoolArray:
    """Which segments [n, 2, 2] have a part inside which boxes [m, 2], as [m, n] (Liang and Barsky 1984)."""
    enter, leave = np.zeros((2, len(low), len(segments)))
    leave += 1.0
    for axis in (0, 1):
        start, way = segments[:, 0, axis], segments[:, 1, axis] - segments[:, 0, axis]
        below, above = low[:, None, axis] - start, high[:, None, axis] - start
        still = way == 0.0
        scale = 1.0 / np.where(still, 1.0, way)
        first, last = below * scale, above * scale
        # A segment that stands still along this axis is inside its slab all the time, or never.
        beside = still & ((below > 0.0) | (above < 0.0))
        np.maximum(enter, np.where(still, np.where(beside, np.inf, 0.0), np.minimum(first, last)), out=enter)
        np.minimum(leave, np.where(still, 1.0, np.maximum(first, last)), out=leave)
    return np.asarray(enter <= leave)


def apart(places: Sequence[float], gap: float, high: float, low: float = 0.0) -> list[float]:
    """Places moved up and down as little as keeps them `gap` apart and within `low` to `high`."""
    order = np.argsort(places, kind="stable")
    done = np.asarray(places, dtype=np.float64)[order]
    for i in range(len(done)):
        done[i] = max(done[i], low if i == 0 else done[i - 1] + gap)
    done[-1] = min(done[-1], high)
    for i in range(len(done) - 2, -1, -1):
        done[i] = min(done[i], done[i + 1] - gap)
    out = np.empty_like(done)
    out[order] = done
    return [float(v) for v in out]
