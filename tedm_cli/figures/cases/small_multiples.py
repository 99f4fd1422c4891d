"""All cases of one quantity as small panels with the same axes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator

from tedm_cli.figures.cases.spectra import bands, limit_lines, limit_samples, log_range
from tedm_cli.figures.drawing.fit import line_count, wrapped
from tedm_cli.figures.drawing.key import key
from tedm_cli.figures.drawing.style import (
    BLUE,
    ENVELOPE,
    LINE,
    SMALL,
    VERMILION,
    WIDTH,
    grid,
    heading,
    heading_lines,
    power_of_ten,
    style,
)
from tedm_cli.results.cases.noise import CaseNoise, limit_named
from tedm_cli.results.wording import and_text, capital, quantity, ratio_text, unit_text

_LEFT, _RIGHT, _FOOT, _GAP = 0.8, 0.12, 0.55, 0.28  # inches, as are all below
_BETWEEN = 0.1  # rows of panels


def cases_figure(cases: Sequence[CaseNoise], kind: str) -> Figure:
    """A panel for each case: the output with the largest ratio, its bounds, and the requirement."""
    with style():
        shown = [c for c in cases if c.of_kind(kind)]
        columns = {1: 1, 2: 2, 4: 2}.get(len(shown), 3)
        rows = math.ceil(len(shown) / columns)
        high = {1: 2.4, 2: 1.8, 3: 1.5, 4: 1.3}.get(rows, 1.1)
        width = (WIDTH - _LEFT - _RIGHT - (columns - 1) * _GAP) / columns
        words = [_words(c, kind, width) for c in shown]
        above = [0.1 + LINE * max(sum(map(line_count, w)) for w in words[i : i + columns])
                 for i in range(0, len(shown), columns)]  # fmt: skip
        outputs = [c.worst(kind).output for c in shown]
        title = f"{capital(quantity(kind, outputs))} by case: the output with the largest ratio"
        top = heading_lines(title, "")[2] + 0.05
        legend = key(_samples(shown, kind), WIDTH - 0.4)
        height = top + sum(above) + rows * high + (rows - 1) * _BETWEEN + _FOOT + legend.height
        figure = Figure(figsize=(WIDTH, height))
        panels: list[Axes] = []
        upper = height - top
        for number, (case, text) in enumerate(zip(shown, words, strict=True)):
            row, column = divmod(number, columns)
            if column == 0:
                upper -= above[row] + high + (_BETWEEN if row else 0.0)
            x = _LEFT + column * (width + _GAP)
            shared: dict[str, Any] = {"sharex": panels[0], "sharey": panels[0]} if panels else {}
            axes = figure.add_axes((x / WIDTH, upper / height, width / WIDTH, high / height), **shared)
            panels.append(axes)
            _panel(axes, case, kind)
            _write(axes, text, case.worst(kind).passed, high)
        _axes(panels, shown, kind, columns)
        heading(figure, title)
        legend.draw(figure, 0.15, 0.08)
        return figure


def _words(case: CaseNoise, kind: str, width: float) -> tuple[str, str]:
    """Title of a panel, and its verdict with all outputs that have the largest ratio."""
    worst = case.worst(kind)
    verdict = (
        f"{ratio_text(worst.ratio)}\N{NO-BREAK SPACE}×\N{NO-BREAK SPACE}limit, {'pass' if worst.passed else 'FAIL'}"
    )
    names = and_text(case.worst_outputs(kind))
    bold = 1.0 if worst.passed else 1.16  # bold type is wider than what is measured
    return wrapped(f"{case.id}  {case.title}", width, SMALL), wrapped(f"{names}: {verdict}", width / bold, SMALL)


def _write(axes: Axes, words: tuple[str, str], passed: bool, high: float) -> None:
    title, verdict = words
    up = 1 + 0.035 / high
    common: dict[str, Any] = {"transform": axes.transAxes, "fontsize": SMALL, "va": "bottom", "linespacing": 1.15}
    axes.text(0.0, up, verdict, fontweight="normal" if passed else "bold", **common)
    axes.text(0.0, up + LINE * line_count(verdict) / high, title, **common)


def _panel(axes: Axes, case: CaseNoise, kind: str) -> None:
    f, factor, worst = case.frequency_hz * 1e3, case.safety_factor, case.worst(kind)
    curve = factor * worst.asd
    limit = limit_named(case.limits, worst.requirement)
    bands(axes, case.limits_of(kind))
    tiny = np.finfo(np.float64).tiny  # a logarithmic axis has no zero
    axes.fill_between(f, np.maximum(factor * worst.bound_low, tiny), np.maximum(factor * worst.bound_high, tiny),
                      **ENVELOPE)  # fmt: skip
    over = curve > np.nan_to_num(limit.amplitude, nan=np.inf)
    if over.any():
        axes.fill_between(f, np.maximum(curve, tiny), limit.amplitude, where=over.tolist(), facecolor="none",
                          edgecolor=VERMILION, hatch="//////", linewidth=0)  # fmt: skip
    limit_lines(axes, case.frequency_hz, case.limits_of(kind), 1.8)
    axes.plot(f, curve, color=BLUE if worst.passed else VERMILION, linewidth=1.6, label=worst.output)
    at = float(np.interp(worst.binding_hz, case.frequency_hz, curve))
    axes.plot([worst.binding_hz * 1e3], [at], linestyle="none", marker="o" if worst.passed else "X", markersize=7,
              markerfacecolor="white", markeredgecolor="black", markeredgewidth=1.1, zorder=5)  # fmt: skip
    if not worst.passed:
        for spine in axes.spines.values():
            spine.set(linewidth=2.2, edgecolor=VERMILION)


def _axes(panels: Sequence[Axes], shown: Sequence[CaseNoise], kind: str, columns: int) -> None:
    """The same scales everywhere; numbers at the left and below the lowest panel of each column."""
    curves = [c.safety_factor * c.worst(kind).asd for c in shown]
    bounds = [c.safety_factor * c.worst(kind).bound_high for c in shown]
    low, high = log_range([*curves, *bounds, *(q.amplitude for c in shown for q in c.limits_of(kind))])
    for number, axes in enumerate(panels):
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlim(shown[0].frequency_hz[0] * 1e3, shown[0].frequency_hz[-1] * 1e3)
        axes.set_ylim(low, high)
        axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.yaxis.set_major_locator(LogLocator(base=10, numticks=5))
        axes.yaxis.set_major_formatter(FuncFormatter(power_of_ten))
        axes.yaxis.set_minor_locator(NullLocator())
        grid(axes)
        lowest = number + columns >= len(shown)
        axes.tick_params(labelsize=SMALL, labelbottom=lowest, labelleft=number % columns == 0)
        if lowest:
            axes.set_xlabel("frequency (mHz)", fontsize=SMALL, labelpad=1)
        if number % columns == 0:
            label = f"{shown[0].safety_factor:g} × noise ({unit_text(shown[0].worst(kind).unit)}/√Hz)"
            axes.set_ylabel(label, fontsize=SMALL)


def _samples(shown: Sequence[CaseNoise], kind: str) -> list[Artist]:
    samples = limit_samples(shown[0].limits_of(kind), 1.8)
    passed = {c.worst(kind).passed for c in shown}
    factor = f"{shown[0].safety_factor:g} × noise"
    ring: dict[str, Any] = {"linewidth": 1.6, "markerfacecolor": "white", "markeredgecolor": "black"}
    if True in passed:
        samples.append(
            Line2D([], [], color=BLUE, marker="o", markersize=6, label=f"{factor}; ring: largest ratio", **ring)
        )
    if False in passed:
        samples.append(Line2D([], [], color=VERMILION, marker="X", markersize=7,
                              label=f"{factor}, violated (thick frame)", **ring))  # fmt: skip
        samples.append(Patch(facecolor="none", edgecolor=VERMILION, hatch="//////", linewidth=0,
                             label="where it is violated"))  # fmt: skip
    samples.append(Patch(**ENVELOPE, label="any correlation of the active areas"))
    return samples
