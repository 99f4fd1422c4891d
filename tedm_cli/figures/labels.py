"""Places for names beside what they name: clear of each other first, then of outlines, then of lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextPath
from numpy.typing import NDArray

Array = NDArray[np.float64]

_ANGLES = np.arange(24) * np.pi / 12
_GAPS = (2.5, 6.0, 11.0, 18.0, 27.0, 40.0)  # between name and outline, points
_COST_LABEL, _COST_BODY, _COST_LINE, _COST_OUTSIDE = 1000.0, 60.0, 25.0, 500.0


@dataclass(frozen=True, eq=False)
class Placed:
    """A name: middle of its box and half its size, in the units of the outlines; `far` where a leader is of use."""

    centre: Array
    half: Array
    far: bool


def text_size(text: str, size_pt: float) -> Array:
    """Width and height of a text in points."""
    box = TextPath((0, 0), text, prop=FontProperties(family="DejaVu Sans", size=size_pt), usetex=False).get_extents()
    return np.array([box.width, size_pt])


def place_labels(
    names: Sequence[str], shapes: Sequence[Array], obstacles: Sequence[Array], lines: Array, size_pt: float,
    per_pt: float, limits: tuple[Array, Array],
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
    done: list[Placed] = []
    for name, shape in zip(names, shapes, strict=True):
        half = per_pt * (text_size(name, size_pt) / 2 + 1.0)
        middle = (shape.min(axis=0) + shape.max(axis=0)) / 2
        if _inside(shape, middle - 1.3 * half, middle + 1.3 * half):
            done.append(Placed(middle, half, False))
            continue
        best: tuple[float, Placed] | None = None
        for gap in _GAPS:
            for angle in _ANGLES:
                way = np.array([np.cos(angle), np.sin(angle)])
                reach = float(((shape - middle) @ way).max()) + gap * per_pt + float(np.abs(way) @ half)
                option = Placed(middle + reach * way, half, gap > 8.0)
                low, high = option.centre - half, option.centre + half
                cost = 0.35 * gap + _COST_LINE * int(crossing(lines, low, high).sum())
                cost += _COST_BODY * int(crossing(edges, low, high).sum())
                cost += _COST_LABEL * sum(overlap(option, other) for other in done)
                cost += _COST_OUTSIDE * bool((low < limits[0]).any() or (high > limits[1]).any())
                if best is None or cost < best[0]:
                    best = (cost, option)
        assert best is not None
        done.append(best[1])
    return done


def _inside(shape: Array, low: Array, high: Array) -> bool:
    """Whether a box lies inside a convex outline, counter-clockwise."""
    way = np.roll(shape, -1, axis=0) - shape
    corners = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
    out = corners[:, None] - shape
    return bool(np.all(way[:, 0] * out[..., 1] - way[:, 1] * out[..., 0] >= 0.0))


def overlap(a: Placed, b: Placed) -> bool:
    """Whether the boxes of two names overlap."""
    return bool(np.all(np.abs(a.centre - b.centre) < a.half + b.half))


def crossing(segments: Array, low: Array, high: Array) -> NDArray[np.bool_]:
    """Which segments [n, 2, 2] have a part inside the box: cut by its slabs one after the other (Liang and Barsky 1984)."""
    start, way = segments[:, 0], segments[:, 1] - segments[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        first, last = (low - start) / way, (high - start) / way
    still = way == 0.0
    inside = (start >= low) & (start <= high)
    enter = np.where(still, np.where(inside, -np.inf, np.inf), np.minimum(first, last)).max(axis=1)
    leave = np.where(still, np.where(inside, np.inf, -np.inf), np.maximum(first, last)).min(axis=1)
    return np.asarray(np.maximum(enter, 0.0) <= np.minimum(leave, 1.0))
