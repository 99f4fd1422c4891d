"""Temperatures of the steady state of a thermal network, group by group."""

from __future__ import annotations

from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from tedm_cli.figures.drawing.fit import line_count, widest, wrapped
from tedm_cli.figures.drawing.key import key
from tedm_cli.figures.drawing.spec import PAGE_HEIGHT
from tedm_cli.figures.drawing.style import (
    BLUE,
    LINE,
    SMALL,
    VERMILION,
    WIDTH,
    grid,
    heading,
    heading_lines,
    inches,
    style,
)
from tedm_cli.results.thermal.groups import GroupTemperatures
from tedm_cli.results.wording import count

_ROW, _FOOT, _NAMES = 0.23, 0.55, 2.6  # inches
_ZERO_K = 273.15
_LOOK: dict[bool, dict[str, Any]] = {
    True: {"facecolor": BLUE, "edgecolor": "black", "linewidth": 0.6, "alpha": 0.55},
    False: {"facecolor": VERMILION, "edgecolor": "black", "linewidth": 0.6, "alpha": 0.55, "hatch": "////"},
}
_MEAN: dict[bool, dict[str, Any]] = {
    on: {"marker": "D", "markersize": 4.2, "color": colour, "markeredgecolor": "black", "linestyle": "none"}
    for on, colour in ((True, "white"), (False, "#4D4D4D"))
}
_WORDS = {True: "on the model", False: "not on the model"}


def temperatures_figure(found: GroupTemperatures) -> Figure:
    """A bar from the coldest to the warmest node of each group, with its mean."""
    with style():
        title = "Temperatures of the steady state by group of thermal nodes"
        more = "bars: from the coldest to the warmest node; diamonds: mean of the nodes"
        names = [
            wrapped(f"{group} ({count(n, 'node')})", _NAMES, SMALL)
            for group, n in zip(found.group, found.nodes, strict=True)
        ]
        row = max(_ROW, 0.08 + LINE * max(map(line_count, names)))
        top = heading_lines(title, more)[2] + 0.38
        legend = key(_samples(found), WIDTH - 0.3, sample=2.6)
        foot = _FOOT + legend.height
        row = min(row, (PAGE_HEIGHT - top - foot) / len(names))
        figure = Figure(figsize=(WIDTH, top + row * len(names) + foot))
        axes = figure.subplots()
        inches(figure, left=0.2 + widest(names, SMALL), right=0.25, top=top, bottom=foot)
        for place, (on, low, mean, high) in enumerate(
            zip(found.on_model.tolist(), found.least, found.mean, found.most, strict=True)
        ):
            axes.barh([place], [high - low], left=[low], height=0.62, **_LOOK[on])
            axes.plot([mean], [place], zorder=4, **_MEAN[on])
        axes.set_yticks(range(len(names)), names, fontsize=SMALL)
        axes.set_ylim(len(names) - 0.5, -0.5)
        _scale(axes, float(found.least.min()), float(found.most.max()))
        heading(figure, title, more=more)
        legend.draw(figure, 0.15, 0.08)
        return figure


def _scale(axes: Axes, low: float, high: float) -> None:
    """Kelvin below, degrees Celsius above."""
    room = 0.04 * (high - low) or 0.5
    axes.set_xlim(low - room, high + room)
    axes.xaxis.set_major_locator(MaxNLocator(7))
    axes.ticklabel_format(axis="x", useOffset=False)
    axes.tick_params(axis="x", labelsize=SMALL)
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel("temperature (K)", fontsize=9)
    grid(axes)
    axes.grid(False, axis="y")
    celsius = axes.twiny()
    celsius.set_xlim(low - room - _ZERO_K, high + room - _ZERO_K)
    celsius.xaxis.set_major_locator(MaxNLocator(7))
    celsius.ticklabel_format(axis="x", useOffset=False)
    celsius.tick_params(axis="x", labelsize=SMALL, pad=1)
    celsius.set_xlabel("(°C)", fontsize=9, labelpad=2)


def _samples(found: GroupTemperatures) -> list[Artist]:
    shown = list(dict.fromkeys(found.on_model.tolist()))
    samples: list[Artist] = []
    for on in shown:
        where = f", {_WORDS[on]}" * (True in shown)
        samples += [Patch(**_LOOK[on], label=f"range{where}"), Line2D([], [], **_MEAN[on], label=f"mean{where}")]
    return samples
