"""Order and corner of the low-passes that fit a thermal network, against those that the cases assume."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.figures.drawing.fit import line_count, wrapped
from tedm_cli.figures.drawing.key import key
from tedm_cli.figures.drawing.spec import PAGE_HEIGHT
from tedm_cli.figures.drawing.style import COLOURS, LINE, SMALL, WIDTH, grid, heading, heading_lines, style
from tedm_cli.results.thermal.groups import GroupGains
from tedm_cli.thermal.low_pass import within

_COLUMNS = 4
_LEFT, _RIGHT, _GAP, _FOOT, _HIGH, _ABOVE = 0.55, 0.12, 0.14, 0.5, 1.2, 0.1  # inches
_MARKS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "p", "h", "d")
_SIZE = 6.2
_ASSUMED: dict[str, Any] = {"color": "black", "linewidth": 0.9, "linestyle": (0, (5, 2))}


def low_passes_figure(found: GroupGains, disturbances: Sequence[int], assumed: Sequence[tuple[float, float]]) -> Figure:
    """Panels of order over corner: of the temperature noise, and of the gains of some disturbances.

    assumed : (order, corner in Hz) of the low-passes in the configuration of the cases.
    """
    with style():
        frequency = found.frequency_hz
        columns = min(_COLUMNS, len(disturbances) + 1)
        rows = math.ceil((len(disturbances) + 1) / columns)
        width = (WIDTH - _LEFT - _RIGHT - (columns - 1) * _GAP) / columns
        names = ["temperature noise, all together", *(found.disturbance[d] for d in disturbances)]
        titles = [wrapped(name, width, SMALL) for name in names]
        above = [_ABOVE + LINE * max(map(line_count, titles[i : i + columns])) for i in range(0, len(titles), columns)]
        title = "Low-passes of the thermal network" + " against what the cases assume" * bool(assumed)
        more = (
            "marks: the mean temperature of each group; bars: range over its nodes. White, at an edge: the corner is"
            " beyond the frequencies, the order is the slope there"
        )
        top = heading_lines(title, more)[2]
        legend = key(_samples(found, assumed), WIDTH - 0.3, sample=2.6)
        around = top + sum(above) + _FOOT + legend.height
        tall = min(_HIGH if rows > 1 else 1.6, (PAGE_HEIGHT - around) / rows)  # a long key takes room from the panels
        height = around + rows * tall
        figure = Figure(figsize=(WIDTH, height))
        pairs = [(found.noise_low_pass.order, found.noise_low_pass.corner_hz)]
        pairs += [(found.low_pass.order[:, d], found.low_pass.corner_hz[:, d]) for d in disturbances]
        limits = _limits(found, pairs, assumed)
        upper = height - top
        for number, (order, corner) in enumerate(pairs):
            row, column = divmod(number, columns)
            if column == 0:
                upper -= above[row] + tall
            x = _LEFT + column * (width + _GAP)
            axes = figure.add_axes((x / WIDTH, upper / height, width / WIDTH, tall / height))
            axes.set_title(titles[number], fontsize=SMALL, pad=3)
            for n, fc in assumed:
                axes.axhline(n, **_ASSUMED)
                axes.axvline(fc * 1e3, **_ASSUMED)
            if number:
                _bars(axes, found, disturbances[number - 1])
            _marks(axes, order, corner, within(corner, frequency), limits[0])
            _scales(axes, limits, column == 0, number + columns >= len(pairs))
        heading(figure, title, more=more)
        legend.draw(figure, 0.15, 0.08)
        return figure


def _limits(
    found: GroupGains, pairs: Sequence[tuple[FloatArray, FloatArray]], assumed: Sequence[tuple[float, float]]
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Corners in mHz and orders that are shown."""
    sound = [fc[within(fc, found.frequency_hz)] for _, fc in pairs]
    corner = np.concatenate([*sound, found.least[1].ravel(), found.most[1].ravel(), [fc for _, fc in assumed]])
    order = np.concatenate([*(n for n, _ in pairs), found.most[0].ravel(), [n for n, _ in assumed]])
    corner, order = corner[np.isfinite(corner)], order[np.isfinite(order)]
    if not corner.size:
        corner = found.frequency_hz
    low, high = float(corner.min()) * 1e3, float(corner.max()) * 1e3
    return (low / 1.6, high * 1.6), (0.0, 1.1 * float(order.max(initial=1.0)))


def _look(g: int) -> dict[str, Any]:
    """Of the mark of group number `g`."""
    return {"marker": _MARKS[g % len(_MARKS)], "markersize": _SIZE, "linestyle": "none", "color": COLOURS[g % 7]}


def _bars(axes: Axes, found: GroupGains, d: int) -> None:
    for g in range(len(found.group)):
        (n0, f0), (n1, f1) = found.least[:, g, d], found.most[:, g, d]
        n, fc = found.low_pass.order[g, d], found.low_pass.corner_hz[g, d]
        if found.nodes[g] > 1 and np.isfinite([n0, n]).all() and within(np.array(fc), found.frequency_hz):
            bar: dict[str, Any] = {"color": COLOURS[g % 7], "linewidth": 0.9, "solid_capstyle": "butt"}
            axes.plot([fc * 1e3, fc * 1e3], [n0, n1], **bar)
            axes.plot([f0 * 1e3, f1 * 1e3], [n, n], **bar)


def _marks(axes: Axes, order: FloatArray, corner: FloatArray, sound: BoolArray, ends: tuple[float, float]) -> None:
    for g, (n, fc, inside) in enumerate(zip(order.tolist(), corner.tolist(), sound.tolist(), strict=True)):
        if not math.isfinite(n):
            continue
        at = min(max(fc * 1e3, ends[0] * 1.15), ends[1] / 1.15)
        fill = {"markeredgecolor": "black", "markeredgewidth": 0.6} if inside else {
            "markerfacecolor": "white", "markeredgecolor": COLOURS[g % 7], "markeredgewidth": 1.1,
        }  # fmt: skip
        axes.plot([at], [n], **{**_look(g), **fill}, zorder=4)


def _scales(axes: Axes, limits: tuple[tuple[float, float], tuple[float, float]], left: bool, lowest: bool) -> None:
    axes.set_xscale("log")
    axes.set_xlim(*limits[0])
    axes.set_ylim(*limits[1])
    axes.xaxis.set_major_locator(LogLocator(base=10, numticks=5))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.yaxis.set_major_locator(MaxNLocator(5, integer=True))
    grid(axes)
    axes.tick_params(labelsize=SMALL, labelleft=left, labelbottom=lowest)
    if left:
        axes.set_ylabel("order (1)", fontsize=SMALL)
    if lowest:
        axes.set_xlabel("corner (mHz)", fontsize=SMALL, labelpad=1)


def _samples(found: GroupGains, assumed: Sequence[tuple[float, float]]) -> list[Artist]:
    marks: list[Artist] = [
        Line2D([], [], **_look(g), markeredgecolor="black", markeredgewidth=0.6, label=group)
        for g, group in enumerate(found.group)
    ]
    if assumed:
        words = "; ".join(f"order {n:g}, {fc * 1e3:g} mHz" for n, fc in assumed)
        marks.append(Line2D([], [], **_ASSUMED, label=f"assumed by the cases: {words}"))
    return marks
