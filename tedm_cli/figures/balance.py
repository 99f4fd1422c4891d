"""The blocks that balance the field at rest in sections of the model, and the ratios to the limits before and after."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from scipy.spatial import ConvexHull

from tedm_cli.arrays import FloatArray, IndexArray
from tedm_cli.figures.drawing.fit import text_width
from tedm_cli.figures.drawing.key import key
from tedm_cli.figures.drawing.style import (
    BLUE,
    COLOURS,
    SMALL,
    VERMILION,
    WIDTH,
    grid,
    heading,
    heading_lines,
    ratio_axis,
    style,
)
from tedm_cli.results.gravity.balance import BalanceResults
from tedm_cli.results.gravity.field import place_text, symbol
from tedm_cli.results.wording import ratio_text

_VIEWS = (("x", "y", 2), ("x", "z", 1), ("y", "z", 0))  # axes to the right and up, and the one that is cut across
_ROW, _LISTED, _LEAST = 0.2, 0.01, 1e-3
_FILLS = COLOURS[:-1]  # black is for edges
_ROUNDING_M = 1e-9
_STRUCTURE = "#C9C9C9"
_MARGIN_M, _BETWEEN, _LEFT = 0.008, 0.55, 0.62


@dataclass(frozen=True, eq=False, kw_only=True)
class Surroundings:
    """What stands around the blocks, basic frame, m.

    low, high : [n, 3], cuboids that hold the elements of the structure. test_mass : names; corner : [t, 8, 3] of the
    cuboids that hold them.
    """

    low: FloatArray
    high: FloatArray
    test_mass: Sequence[str]
    corner: FloatArray


def balance_figure(r: BalanceResults, around: Surroundings, title: str) -> Figure:
    """Three sections through each test mass with the blocks near to it, and what each limit is kept by."""
    with style():
        corner = _corners(r)
        near = _nearest(r, around)
        masses = [t for t in range(len(around.test_mass)) if (near == t).any()]
        shown = [i for i in range(len(r.after)) if max(r.before[i].ratio, r.after[i].ratio) > _LISTED]
        shown.sort(key=lambda i: -r.before[i].ratio)
        wide = (WIDTH - 0.12 - 3 * _LEFT) / 3
        legend = key(_handles(r), WIDTH - 0.3)
        ratios = _ROW * max(len(shown), 1)
        head = heading_lines(title, "")[2] + 0.3
        total = head - 0.1 + len(masses) * (wide + _BETWEEN) + 0.35 + ratios + 0.5 + legend.height + 0.1
        figure = Figure(figsize=(WIDTH, total))
        top = head
        for t in masses:
            for number, view in enumerate(_VIEWS):
                x = _LEFT + number * (wide + _LEFT)
                axes = figure.add_axes((x / WIDTH, 1 - (top + wide) / total, wide / WIDTH, wide / total))
                _section(axes, r, around, corner, np.flatnonzero(near == t), t, view)
                axes.set_title(f"{around.test_mass[t]}, cut at its {'xyz'[view[2]]}", fontsize=SMALL)
            top += wide + _BETWEEN
        names = [f"{place_text(v.place)} {symbol(v.quantity)} {v.subsystem}" for v in (r.after[i] for i in shown)]
        left = 0.2 + max((text_width(name, SMALL) for name in names), default=1.0)
        top += 0.2
        axes = figure.add_axes((left / WIDTH, 1 - (top + ratios) / total, (WIDTH - left - 0.6) / WIDTH, ratios / total))
        _ratios(axes, r, shown, names)
        heading(figure, title)
        legend.draw(figure, 0.15, 0.06)
        return figure


def _corners(r: BalanceResults) -> FloatArray:
    """[b, 8, 3]."""
    sign = np.array(list(product((-0.5, 0.5), repeat=3)))
    return np.asarray(r.centre[:, None] + (sign * r.size[:, None]) @ r.axes)


def _nearest(r: BalanceResults, around: Surroundings) -> IndexArray:
    """[b], the test mass nearest to each block."""
    middle = around.corner.mean(axis=1)
    return np.asarray(np.linalg.norm(r.centre[:, None] - middle, axis=2).argmin(axis=1))


def _section(
    axes: Axes,
    r: BalanceResults,
    around: Surroundings,
    corner: FloatArray,
    blocks: IndexArray,
    mass: int,
    view: tuple[str, str, int],
) -> None:
    """The structure where the plane through the test mass cuts it, and all blocks near to it behind and before."""
    right, up, across = "xyz".index(view[0]), "xyz".index(view[1]), view[2]
    flat = [right, up]
    box = around.corner[mass]
    at = box[:, across].mean()
    points = np.concatenate([corner[blocks].reshape(-1, 3), box])[:, flat]
    low, high = points.min(axis=0) - _MARGIN_M, points.max(axis=0) + _MARGIN_M
    middle, half = (low + high) / 2.0, float((high - low).max()) / 2.0
    # Planes of meshes are often those of the test mass: what begins at the plane is cut, what ends there is not.
    cut = (around.low[:, across] <= at + _ROUNDING_M) & (around.high[:, across] > at + _ROUNDING_M)
    rectangles = [
        [(a[0], a[1]), (b[0], a[1]), (b[0], b[1]), (a[0], b[1])]
        for a, b in zip(around.low[cut][:, flat], around.high[cut][:, flat], strict=True)
    ]
    axes.add_collection(
        PolyCollection(rectangles, facecolor=_STRUCTURE, edgecolor=_STRUCTURE, linewidth=0.3, antialiased=False)
    )
    names = _used(r)
    for b in blocks:
        is_cut = corner[b][:, across].min() < at < corner[b][:, across].max()
        colour, hatch = _look(names.index(r.box[r.block_candidate[b]]))
        outline = corner[b][:, flat]
        outline = outline[ConvexHull(outline).vertices]
        look: dict[str, Any] = {"linestyle": "-" if is_cut else (0, (2, 1.5)), "linewidth": 0.8}
        if is_cut:
            look |= {"facecolor": colour, "edgecolor": "black", "hatch": hatch}
        else:
            look |= {"facecolor": "none", "edgecolor": colour}
        axes.add_collection(PolyCollection([outline], zorder=3.0 + is_cut, **look))
    hull = box[:, flat]
    axes.add_collection(
        PolyCollection([hull[ConvexHull(hull).vertices]], facecolor="#F4E9B5", edgecolor="black", linewidth=0.8)
    )
    axes.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half), aspect="equal")
    axes.set_xlabel(f"{view[0]} (m)", fontsize=SMALL, labelpad=1)
    axes.set_ylabel(f"{view[1]} (m)", fontsize=SMALL, labelpad=1)
    axes.tick_params(labelsize=SMALL, length=2.5)
    axes.locator_params(nbins=3)


def _ratios(axes: Axes, r: BalanceResults, shown: Sequence[int], names: Sequence[str]) -> None:
    for row, i in enumerate(shown):
        before, after = max(r.before[i].ratio, _LEAST), max(r.after[i].ratio, _LEAST)
        axes.plot([before, after], [row, row], color="#9A9A9A", linewidth=1.2, zorder=2)
        axes.plot([before], [row], marker="o", markersize=5, markerfacecolor="white", markeredgecolor="black", zorder=3)
        if (off := r.off_ratio(i)) > 0.0:
            ends = [max(after - off, _LEAST), after + off]
            axes.plot(ends, [row, row], color=BLUE, linewidth=4, alpha=0.3, solid_capstyle="butt", zorder=2.5)
        colour = BLUE if r.after[i].passed else VERMILION
        axes.plot([after], [row], marker="o" if r.after[i].passed else "X", markersize=6, color=colour, zorder=4)
        if not r.after[i].passed:
            axes.annotate(f"{ratio_text(after)} FAIL", (max(before, after), row), xytext=(5, 0),
                          textcoords="offset points", fontsize=SMALL, va="center_baseline")  # fmt: skip
    axes.axvline(1.0, color="black", linewidth=1.5)
    axes.set_xscale("log")
    ratio_axis(axes.xaxis, *axes.get_xlim())
    axes.set_ylim(len(shown) - 0.4, -0.6)
    axes.set_yticks(range(len(names)), names, fontsize=SMALL)
    axes.set_xlabel("|value| / limit (1)", fontsize=SMALL)
    axes.tick_params(labelsize=SMALL)
    grid(axes)
    axes.grid(False, axis="y")


def _used(r: BalanceResults) -> list[str]:
    """Boxes that have blocks."""
    there = {r.box[row] for row in r.block_candidate}
    return [name for name in dict.fromkeys(r.box) if name in there]


def _look(number: int) -> tuple[str, str]:
    """Colour and hatch of a box."""
    return _FILLS[number % len(_FILLS)], ("", "////", "....", "xxxx")[number // len(_FILLS) % 4]


def _handles(r: BalanceResults) -> list[Any]:
    handles: list[Any] = []
    for n, name in enumerate(_used(r)):
        colour, hatch = _look(n)
        label = f"{name}, {r.by_box()[name][0]:.3g} kg"
        handles.append(Patch(facecolor=colour, edgecolor="black", linewidth=0.8, hatch=hatch, label=label))
    handles += [
        Patch(facecolor="none", edgecolor="black", linestyle=(0, (2, 1.5)), label="before or behind the cut"),
        Patch(facecolor=_STRUCTURE, label="structure that is cut"),
        Line2D([], [], marker="o", markersize=5, markerfacecolor="white", markeredgecolor="black", linestyle="none",
               label="without blocks"),
        Line2D([], [], marker="o", markersize=6, color=BLUE, linestyle="none", label="with blocks"),
    ]  # fmt: skip
    if not all(v.passed for v in r.after):
        handles.append(Line2D([], [], marker="X", markersize=6, color=VERMILION, linestyle="none", label="not met"))
    if r.off.any():
        handles.append(Line2D([], [], color=BLUE, linewidth=4, alpha=0.3, label="may be off by tolerances"))
    return handles
