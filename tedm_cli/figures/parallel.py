"""Variants by criteria: an axis for each criterion, a line for each variant, the better always higher."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from tedm_cli.arrays import FloatArray
from tedm_cli.figures.drawing.fit import line_count, wrapped
from tedm_cli.figures.drawing.key import key
from tedm_cli.figures.drawing.style import (
    COLOURS,
    LINE,
    SMALL,
    VERMILION,
    WIDTH,
    heading,
    heading_lines,
    series_look,
    style,
)
from tedm_cli.results.trade import Trade, TradedCriterion
from tedm_cli.results.wording import unit_text
from tedm_cli.trade.pareto import rounded

_TITLE = "Variants by criteria"
_MORE = (
    "Each axis has its own scale; higher is better. Thick: on the Pareto front. A line breaks where a criterion is"
    " missing."
)
_TALL, _GAP, _SIDE = 2.2, 0.2, 0.75  # inches: of an axis, between panels, beside the outer axes
_LOW, _PAGE = 1.1, 9.8  # inches: of the axes of many panels, and of a figure that fits on a page in its size
_ACROSS = 6  # axes beside each other
_NAMED = 14  # variants that have a look of their own, where there are more only those on the front do
_DECADES = 1.0  # from this span on a scale is logarithmic
_LEAST = 0.02  # relative span of a scale where values differ: small differences look small
_OTHER = "#B5B5B5"
_LIMIT: dict[str, Any] = {
    "color": VERMILION,
    "linestyle": "none",
    "marker": "_",
    "markersize": 15,
    "markeredgewidth": 2.0,
}
_MARKERS = ("o", "s", "^", "D")


@dataclass(frozen=True)
class _Scale:
    """Where values stand on an axis: 0 at the worst end, 1 at the best."""

    low: float
    high: float
    log: bool
    reverse: bool

    def at(self, value: float) -> float:
        low, high, here = (
            (math.log(v) for v in (self.low, self.high, value)) if self.log else (self.low, self.high, value)
        )
        place = 0.5 if high == low else (here - low) / (high - low)
        return 1.0 - place if self.reverse else place

    @property
    def ends(self) -> list[float]:
        """Values to be written at the axis: one where all are alike."""
        return [self.low] if self.low == self.high else [self.low, self.high]


def parallel_figure(trade: Trade) -> Figure:
    """Parallel coordinates of a trade; criteria that no variant has are left out."""
    values = trade.values
    shown = [c for c in range(len(trade.criteria)) if not np.isnan(values[:, c]).all()]
    panels = np.array_split(shown, max(1, math.ceil(len(shown) / _ACROSS)))
    with style():
        top = heading_lines(_TITLE, _MORE)[2] + 0.12
        step = (WIDTH - 2 * _SIDE) / max(1, max(map(len, panels)) - 1)
        room = min(step, 2 * _SIDE) - 0.1
        heads = [[_head(trade.criteria[c], room) for c in panel] for panel in panels]
        feet = [[_foot(trade.criteria[c], values[:, c], room) for c in panel] for panel in panels]
        above, below = (0.12 + LINE * max([1, *(line_count(t) for row in of for t in row)]) for of in (heads, feet))
        legend = key(_samples(trade), WIDTH - 0.3)
        around = above + 0.3 + below
        room_of_axis = (_PAGE - top - legend.height - 0.25 - (len(panels) - 1) * _GAP) / len(panels) - around
        tall = min(_TALL, max(_LOW, room_of_axis))
        each = around + tall
        height = top + len(panels) * each + (len(panels) - 1) * _GAP + legend.height + 0.25
        figure = Figure(figsize=(WIDTH, height))
        for number, panel in enumerate(panels):
            bottom = height - top - number * (each + _GAP) - above - 0.3 - tall
            wide = max(step * (len(panel) - 1), 0.1)
            axes = figure.add_axes((_SIDE / WIDTH, bottom / height, wide / WIDTH, tall / height))
            _panel(axes, trade, panel.tolist(), heads[number], feet[number])
        heading(figure, _TITLE, more=_MORE)
        legend.draw(figure, 0.15, 0.1)
        return figure


def _head(criterion: TradedCriterion, room: float) -> str:
    name = wrapped(criterion.name, room / 1.16, SMALL)  # bold type is wider than what is measured
    return name if criterion.unit == "1" else f"{name}\n{wrapped(f'({unit_text(criterion.unit)})', room / 1.16, SMALL)}"


def _foot(criterion: TradedCriterion, values: FloatArray, room: float) -> str:
    """The limit, and how many meet it."""
    if criterion.limit is None:
        return ""
    there = values[~np.isnan(values)]
    passed = int((there <= criterion.limit if criterion.goal == "min" else there >= criterion.limit).sum())
    return wrapped(f"{criterion.limit_words}: {passed} of {len(there)}", room, SMALL)


def scale_of(criterion: TradedCriterion, values: FloatArray) -> _Scale:
    """The scale of an axis: logarithmic where values above 0 span a decade; from the least to the largest of them.

    Values that differ little are in the middle of a wider one.
    """
    there = rounded(values[~np.isnan(values)])
    low, high = float(there.min()), float(there.max())
    is_log = low > 0.0 and math.log10(high / low) >= _DECADES
    wider = 0.5 * (_LEAST * max(abs(low), abs(high)) - (high - low))
    if high > low and wider > 0.0:
        low, high = low - wider, high + wider
        if criterion.kind == "probability":
            low, high = max(low, 0.0), min(high, 1.0)
    return _Scale(low, high, is_log, criterion.goal == "min")


def _drawn_limit(criterion: TradedCriterion, scale: _Scale) -> float | None:
    """The limit, where it lies among the values."""
    limit = criterion.limit
    return limit if limit is not None and scale.low < scale.high and scale.low <= limit <= scale.high else None


def _panel(axes: Axes, trade: Trade, shown: Sequence[int], heads: Sequence[str], feet: Sequence[str]) -> None:
    values = trade.values
    scales = [scale_of(trade.criteria[c], values[:, c]) for c in shown]
    axes.set_axis_off()
    axes.set_xlim(0, max(len(shown) - 1, 0.1))
    axes.set_ylim(0, 1)
    for place, (c, scale) in enumerate(zip(shown, scales, strict=True)):
        criterion = trade.criteria[c]
        axes.plot([place, place], [0, 1], color="black", linewidth=0.9, zorder=1, clip_on=False)
        said: dict[str, Any] = {"ha": "center", "fontsize": SMALL, "clip_on": False, "textcoords": "offset points"}
        axes.annotate(heads[place], (place, 1), (0, 18), va="bottom", fontweight="bold", **said)
        for value in scale.ends:
            up = scale.at(value) > 0.25
            text = criterion.text(value)
            axes.annotate(text, (place, 1 if up else 0), (0, 5 if up else -5), va="bottom" if up else "top", **said)
        axes.annotate(feet[place], (place, 0), (0, -18), va="top", **said)
        if (limit := _drawn_limit(criterion, scale)) is not None:
            y = scale.at(limit)
            axes.plot([place], [y], clip_on=False, zorder=2, **_LIMIT)
    for v, look in enumerate(_looks(trade)):
        ys = [
            math.nan if math.isnan(values[v, c]) else s.at(float(rounded(values[v, c])))
            for c, s in zip(shown, scales, strict=True)
        ]
        axes.plot(range(len(shown)), ys, clip_on=False, **look)


def _looks(trade: Trade) -> list[dict[str, Any]]:
    """How each variant is drawn."""
    looks = []
    few = len(trade.variants) <= _NAMED
    number = 0
    for variant in trade.variants:
        is_first = variant.front == 1
        if few or is_first:
            look = series_look(number) | {"marker": _MARKERS[number // len(COLOURS) % len(_MARKERS)], "markevery": 1}
            number += 1
        else:
            look = {"color": _OTHER, "linestyle": "-", "marker": "o", "markersize": 3.0}
        looks.append(
            look | {"linewidth": 2.4 if is_first else 1.1, "zorder": 4 if is_first else 3, "label": variant.name}
        )
    return looks


def _samples(trade: Trade) -> list[Line2D]:
    """A sample for each variant that has a value, and one for the limits; those that look alike have one together."""
    found = []
    alike = 0
    has = ~np.isnan(trade.values).all(axis=1)
    for variant, look, compared in zip(trade.variants, _looks(trade), has, strict=True):
        if not compared:
            continue
        if look["color"] == _OTHER:
            alike += 1
            continue
        found.append(
            Line2D([], [], **{k: w for k, w in look.items() if k not in ("label", "markevery")}, label=variant.name)
        )
    if alike:
        found.append(Line2D([], [], color=_OTHER, linewidth=1.1, label=f"{alike} others, not on the front"))
    values = trade.values
    shown = [
        (criterion, values[:, c]) for c, criterion in enumerate(trade.criteria) if not np.isnan(values[:, c]).all()
    ]
    if any(_drawn_limit(criterion, scale_of(criterion, of)) is not None for criterion, of in shown):
        found.append(Line2D([], [], **_LIMIT, label="limit"))
    return found
