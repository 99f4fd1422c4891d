"""The ratio to the requirement of every case in one figure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from tedm_cli.figures.drawing.fit import line_count, widest, wrapped
from tedm_cli.figures.drawing.key import key
from tedm_cli.figures.drawing.style import BLUE, LINE, SMALL, VERMILION, WIDTH, grid, ratio_axis, style
from tedm_cli.results.cases.noise import CaseNoise, JudgedOutput

_ROW, _FOOT, _BETWEEN, _GAP, _RIGHT = 0.25, 0.5, 0.25, 0.2, 0.2  # inches
_RANGE = "#9A9A9A"


def ratios_figure(cases: Sequence[CaseNoise], kinds: Sequence[str]) -> Figure:
    """Ratio to the requirement of every case's worst output, with its range over other temperature filters."""
    with style():
        columns = min(2, len(kinds))
        rows = math.ceil(len(kinds) / columns)
        names = [wrapped(f"case {c.id}", 1.6, SMALL) for c in cases]
        left = 0.2 + widest(names, SMALL)
        wide = (WIDTH - left - _RIGHT - (columns - 1) * _GAP) / columns
        titles = [_title(cases, kind, wide) for kind in kinds]
        row = max(_ROW, 0.05 + LINE * max(map(line_count, names)))
        head, tall = 0.1 + LINE * max(map(line_count, titles)), row * len(cases)
        legend = key(_samples(cases, kinds), WIDTH - 0.3)
        height = rows * (head + tall + _FOOT) + (rows - 1) * _BETWEEN + legend.height + 0.2
        figure = Figure(figsize=(WIDTH, height))
        for number, (kind, title) in enumerate(zip(kinds, titles, strict=True)):
            down, across = divmod(number, columns)
            bottom = height - down * (head + tall + _FOOT + _BETWEEN) - head - tall
            x = left + across * (wide + _GAP)
            axes = figure.add_axes((x / WIDTH, bottom / height, wide / WIDTH, tall / height))
            _panel(axes, cases, kind)
            axes.set_title(title, fontsize=SMALL)
            axes.set_yticks(range(len(cases)), names if across == 0 else [""] * len(cases))
            axes.tick_params(labelsize=SMALL)
        legend.draw(figure, 0.15, 0.1)
        return figure


def _title(cases: Sequence[CaseNoise], kind: str, wide: float) -> str:
    names = dict.fromkeys(limit.plain for c in cases for limit in c.limits_of(kind))
    return wrapped(f"worst output; limit: {'; '.join(names)}", wide, SMALL)


def _panel(axes: Axes, cases: Sequence[CaseNoise], kind: str) -> None:
    for row, case in enumerate(cases):
        if case.of_kind(kind):
            j = case.worst(kind)
            if j.filter_ratio is not None:
                ends = [float(j.filter_ratio.min()), float(j.filter_ratio.max())]
                axes.plot(ends, [row, row], color=_RANGE, linewidth=4, solid_capstyle="butt")
            axes.plot([j.ratio], [row], **_look(j.passed))
    axes.axvline(1.0, color="black", linewidth=1.6)
    axes.set_xscale("log")
    ratio_axis(axes.xaxis, *axes.get_xlim())
    axes.set_ylim(len(cases) - 0.4, -0.6)
    axes.set_xlabel("safety factor × noise / requirement (1)", fontsize=SMALL)
    grid(axes)


def _look(passed: bool) -> dict[str, Any]:
    return {
        "linestyle": "none",
        "marker": "o" if passed else "X",
        "markersize": 8,
        "color": BLUE if passed else VERMILION,
        "label": "met (at most 1)" if passed else "violated (above 1)",
    }


def _samples(cases: Sequence[CaseNoise], kinds: Sequence[str]) -> list[Artist]:
    worst: list[JudgedOutput] = [c.worst(kind) for c in cases for kind in kinds if c.of_kind(kind)]
    samples: list[Artist] = []
    for passed in (True, False):
        if any(j.passed == passed for j in worst):
            samples.append(Line2D([], [], **_look(passed)))
    if any(j.filter_ratio is not None for j in worst):
        label = "range over filter orders and corners"
        samples.append(Line2D([], [], color=_RANGE, linewidth=4, solid_capstyle="butt", label=label))
    return samples
