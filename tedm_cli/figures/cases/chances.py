"""How probable the verdicts are: the spread of each ratio over what is uncertain, and which parameters it is by."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from tedm_cli.figures.drawing.fit import line_count, text_width, widest, wrapped
from tedm_cli.figures.drawing.key import key
from tedm_cli.figures.drawing.style import (
    BLUE,
    COLOURS,
    LINE,
    SMALL,
    VERMILION,
    WIDTH,
    grid,
    heading,
    heading_lines,
    ratio_axis,
    style,
)
from tedm_cli.results.cases.chances import distribution_in, largest_sources, probability_text
from tedm_cli.results.cases.deciding import Pair
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import capital
from tedm_cli.uncertainty.verdicts import CaseUncertainty, Distribution

Row = tuple[str, bool, CaseUncertainty, Distribution]  # its name, whether it is met, and its distribution

_ROW, _FOOT, _GAP = 0.4, 0.5, 0.25  # inches
_NAMES, _SHARES = 1.9, 1.75  # inches of the names, and of the shares of the variance
_WIDE, _MIDDLE = "#C9C9C9", "#7A7A7A"
_SOURCES = 5  # with colours of their own
_PATTERNS = ("", "....", "\\\\\\\\", "////", "xxxx")  # each its own, so that colour is not needed
_HEAD = "probability\nof violation"


def chances_figure(pairs: Sequence[Pair]) -> Figure:
    """A row for each judged output in the case that decides it; all of them have distributions."""
    rows = _rows(pairs)
    with style():
        names = [wrapped(name, _NAMES, SMALL) for name, _, _, _ in rows]
        told = [probability_text(d.violated) for _, _, _, d in rows]
        sources = _shown(rows)
        title = "How probable is each verdict, and what is its spread by?"
        top = heading_lines(title, "")[2] + 2 * LINE + 0.1
        legend = key(_samples(rows, sources), WIDTH - 0.3, sample=2.2, most=3)
        row = max(_ROW, 0.1 + LINE * max(map(line_count, names)))
        height = top + len(rows) * row + _FOOT + legend.height + 0.05
        figure = Figure(figsize=(WIDTH, height))
        left = 0.2 + widest(names, SMALL)
        beside = 0.12 + max(widest([_HEAD], SMALL), *(text_width(text, SMALL) for text in told))
        wide = WIDTH - left - beside - _GAP - _SHARES - 0.15
        bottom, tall = (_FOOT + legend.height + 0.05) / height, len(rows) * row / height
        ratios = figure.add_axes((left / WIDTH, bottom, wide / WIDTH, tall))
        start = left + wide + beside + _GAP
        shares = figure.add_axes((start / WIDTH, bottom, _SHARES / WIDTH, tall))
        _draw_ratios(ratios, rows, names, told)
        _draw_shares(shares, rows, sources)
        heading(figure, title)
        legend.draw(figure, 0.15, 0.08)
        return figure


def _rows(pairs: Sequence[Pair]) -> list[Row]:
    rows = []
    for case, j in pairs:
        if case.uncertainty is not None:
            name = f"{capital(output_title(j.output))}, case {case.id}"
            rows.append((name, j.passed, case.uncertainty, distribution_in(case.uncertainty, j)))
    return rows


def _shown(rows: Sequence[Row]) -> list[str]:
    """The sources with the largest shares in any row."""
    largest: dict[str, float] = {}
    for _, _, u, d in rows:
        for name, first, _ in largest_sources(u, d):
            largest[name] = max(largest.get(name, 0.0), first)
    return sorted(largest, key=lambda name: -largest[name])[:_SOURCES]


def _draw_ratios(axes: Axes, rows: Sequence[Row], names: Sequence[str], told: Sequence[str]) -> None:
    for place, (_, passed, _, d) in enumerate(rows):
        for ends, width, colour in (((5, 95), 5.0, _WIDE), ((25, 75), 9.0, _MIDDLE)):
            low, high = (d.percentile(p) for p in ends)
            axes.plot([low, high], [place, place], color=colour, linewidth=width, solid_capstyle="butt", zorder=2)
        axes.plot([d.percentile(50)], [place], color="white", marker="|", markersize=9, markeredgewidth=1.6, zorder=3)
        axes.plot([d.nominal], [place], zorder=4, **_nominal(passed))
        axes.text(1.03, place, told[place], transform=axes.get_yaxis_transform(), va="center", fontsize=SMALL,
                  fontweight="bold" if d.violated.probability > 0.5 else "normal")  # fmt: skip
    axes.text(1.03, 1.0, _HEAD, transform=axes.transAxes, va="bottom", fontsize=SMALL)
    axes.axvline(1.0, color="black", linewidth=1.5, zorder=3)
    values = [1.0, *(d.percentile(p) for _, _, _, d in rows for p in (5, 95)), *(d.nominal for _, _, _, d in rows)]
    positive = [v for v in values if v > 0.0]
    axes.set_xscale("log")
    axes.set_xlim(min(positive) / 1.4, max(positive) * 1.4)
    ratio_axis(axes.xaxis, *axes.get_xlim())
    axes.set_xlabel("ratio to the requirement (1)", fontsize=SMALL)
    axes.set_yticks(range(len(rows)), names)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.tick_params(axis="y", length=0, labelsize=SMALL, pad=6)
    axes.tick_params(axis="x", labelsize=SMALL)
    grid(axes)
    axes.grid(False, axis="y")


def _draw_shares(axes: Axes, rows: Sequence[Row], sources: Sequence[str]) -> None:
    """Shares of sources alone, end to end; what is left to 1 is of others and of interactions."""
    for place, (_, _, u, d) in enumerate(rows):
        share = {name: first for name, first, _ in largest_sources(u, d)}
        end = 0.0
        for name in sources:
            axes.barh([place], [share.get(name, 0.0)], left=[end], height=0.5, linewidth=0.0, **_look(sources, name))
            end += share.get(name, 0.0)
        if share:
            axes.barh([place], [max(1.0 - end, 0.0)], left=[end], height=0.5, facecolor=_WIDE, linewidth=0.0)
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_yticks([])
    axes.set_xticks([0.0, 0.5, 1.0], ["0", "0.5", "1"])
    axes.tick_params(axis="x", labelsize=SMALL)
    axes.set_xlabel("share of the variance (1)", fontsize=SMALL)


def _look(sources: Sequence[str], name: str) -> dict[str, Any]:
    place = sources.index(name)
    return {"facecolor": COLOURS[place], "hatch": _PATTERNS[place], "edgecolor": "white"}


def _nominal(passed: bool) -> dict[str, Any]:
    return {
        "linestyle": "none",
        "marker": "o" if passed else "X",
        "markersize": 7.5,
        "color": BLUE if passed else VERMILION,
        "markeredgecolor": "black",
        "markeredgewidth": 0.8,
        "label": f"nominal, {'met' if passed else 'violated'}",
    }


def _samples(rows: Sequence[Row], sources: Sequence[str]) -> list[Artist]:
    met = {passed for _, passed, _, _ in rows}
    handles: list[Artist] = [Line2D([], [], **_nominal(passed)) for passed in (True, False) if passed in met]
    handles += [
        Line2D([], [], color=_WIDE, linewidth=5, solid_capstyle="butt", label="90 % of the draws"),
        Line2D([], [], color=_MIDDLE, linewidth=9, solid_capstyle="butt", label="half of the draws, with the median"),
    ]
    handles += [Patch(linewidth=0.0, label=name, **_look(sources, name)) for name in sources]
    return [*handles, Patch(facecolor=_WIDE, label="other parameters, and interactions")]
