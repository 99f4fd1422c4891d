"""All cases of one quantity as small panels with the same axes."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator

from tedm_cli.figures.fit import fitted, text_width, wrapped
from tedm_cli.figures.spectra import limit_lines, log_range
from tedm_cli.figures.style import (
    BAND,
    BLUE,
    DASHES,
    ENVELOPE,
    VERMILION,
    WIDTH,
    grid,
    heading,
    inches,
    power_of_ten,
    style,
)
from tedm_cli.results.noise import CaseNoise, Limit
from tedm_cli.results.wording import capital, quantity, ratio_text, unit_text

_LEFT, _RIGHT, _TOP, _FOOT, _GAP = 0.8, 0.12, 0.42, 1.1, 0.28  # inches, as are all below
_TITLE = 0.58  # three lines above each panel
_SMALL = 8.0  # points


def cases_figure(cases: Sequence[CaseNoise], kind: str) -> Figure:
    """A panel for each case: the output with the largest ratio, its bounds, and the requirement."""
    with style():
        shown = [c for c in cases if c.of_kind(kind)]
        columns = {1: 1, 2: 2, 4: 2}.get(len(shown), 3)
        rows = math.ceil(len(shown) / columns)
        height = {1: 2.4, 2: 1.8, 3: 1.5, 4: 1.3}.get(rows, 1.1)
        width = (WIDTH - _LEFT - _RIGHT - (columns - 1) * _GAP) / columns
        figure = Figure(figsize=(WIDTH, _TOP + rows * (_TITLE + height) + _FOOT))
        panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).reshape(-1).tolist()
        inches(figure, left=_LEFT, right=_RIGHT, top=_TOP + _TITLE, bottom=_FOOT, wspace=_GAP / width)
        figure.subplots_adjust(hspace=_TITLE / height)
        for axes, case in zip(panels, shown, strict=False):
            _panel(axes, case, kind, width)
        _axes(panels, shown, kind, columns)
        outputs = [c.worst(kind).output for c in shown]
        heading(figure, f"{capital(quantity(kind, outputs))} by case: the output with the largest ratio")
        _legend(figure, shown, kind)
        return figure


def _panel(axes: Axes, case: CaseNoise, kind: str, width: float) -> None:
    f, factor, worst = case.frequency_hz * 1e3, case.safety_factor, case.worst(kind)
    curve = factor * worst.asd
    colour = BLUE if worst.passed else VERMILION
    limit = next(q for q in case.limits if q.name == worst.requirement)
    for low_hz, high_hz in dict.fromkeys(q.band_hz for q in case.limits_of(kind)):
        axes.axvspan(low_hz * 1e3, high_hz * 1e3, color=BAND, linewidth=0, zorder=0)
    tiny = np.finfo(np.float64).tiny  # a logarithmic axis has no zero
    axes.fill_between(f, np.maximum(factor * worst.bound_low, tiny), np.maximum(factor * worst.bound_high, tiny),
                      color=ENVELOPE, alpha=0.18, linewidth=0)  # fmt: skip
    over = curve > np.nan_to_num(limit.amplitude, nan=np.inf)
    if over.any():
        axes.fill_between(f, np.maximum(curve, tiny), limit.amplitude, where=over.tolist(), facecolor="none",
                          edgecolor=VERMILION, hatch="//////", linewidth=0)  # fmt: skip
    limit_lines(axes, case.frequency_hz, case.limits_of(kind), 1.8)
    axes.plot(f, curve, color=colour, linewidth=1.6, label=worst.output)
    at = float(np.interp(worst.binding_hz, case.frequency_hz, curve))
    axes.plot([worst.binding_hz * 1e3], [at], linestyle="none", marker="o" if worst.passed else "X", markersize=7,
              markerfacecolor="white", markeredgecolor="black", markeredgewidth=1.1, zorder=5)  # fmt: skip
    name = wrapped(f"{case.id}  {case.title}", width, _SMALL, 2)
    axes.text(0.0, 1 + 14.5 / 72 / _height(axes), name, transform=axes.transAxes, fontsize=_SMALL, va="bottom",
              linespacing=1.15)  # fmt: skip
    verdict = f"{ratio_text(worst.ratio)} × limit, {'pass' if worst.passed else 'FAIL'}"
    output = fitted(worst.output, width - 1.15 * text_width(f": {verdict}", _SMALL), _SMALL)
    axes.text(0.0, 1 + 2.5 / 72 / _height(axes), f"{output}: {verdict}", transform=axes.transAxes, fontsize=_SMALL,
              va="bottom", fontweight="normal" if worst.passed else "bold")  # fmt: skip
    if not worst.passed:
        for spine in axes.spines.values():
            spine.set(linewidth=2.2, edgecolor=VERMILION)


def _height(axes: Axes) -> float:
    return float(axes.get_window_extent().height / axes.figure.dpi)


def _axes(panels: Sequence[Axes], shown: Sequence[CaseNoise], kind: str, columns: int) -> None:
    """The same scales everywhere; numbers at the left and below the lowest panel of each column."""
    curves = [c.safety_factor * c.worst(kind).asd for c in shown]
    bounds = [c.safety_factor * c.worst(kind).bound_high for c in shown]
    low, high = log_range([*curves, *bounds, *(q.amplitude for c in shown for q in c.limits_of(kind))])
    for number, axes in enumerate(panels):
        if number >= len(shown):
            axes.set_visible(False)
            continue
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
        axes.tick_params(labelsize=_SMALL, labelbottom=lowest, labelleft=number % columns == 0)
        if lowest:
            axes.set_xlabel("frequency (mHz)", fontsize=8.5, labelpad=1)
        if number % columns == 0:
            label = f"{shown[0].safety_factor:g} × noise ({unit_text(shown[0].worst(kind).unit)}/√Hz)"
            axes.set_ylabel(label, fontsize=8.5)


def _legend(figure: Figure, shown: Sequence[CaseNoise], kind: str) -> None:
    limits: list[Limit] = shown[0].limits_of(kind)
    handles: list[Line2D | Patch] = [
        Line2D([], [], color="black", linewidth=1.8, linestyle=DASHES[i % len(DASHES)], label=name)
        for i, name in enumerate(f"requirement {fitted(q.name, 1.9, 8.5)}" for q in limits)
    ]
    handles += [
        Patch(facecolor=BAND, label=f"its band, {low * 1e3:g} to {high * 1e3:g} mHz")
        for low, high in dict.fromkeys(q.band_hz for q in limits)
    ]
    passed = {c.worst(kind).passed for c in shown}
    factor = f"{shown[0].safety_factor:g} × noise"
    if True in passed:
        handles.append(Line2D([], [], color=BLUE, linewidth=1.6, marker="o", markersize=6, markerfacecolor="white",
                              markeredgecolor="black", label=f"{factor}; ring: largest ratio"))  # fmt: skip
    if False in passed:
        handles.append(Line2D([], [], color=VERMILION, linewidth=1.6, marker="X", markersize=7, markerfacecolor="white",
                              markeredgecolor="black", label=f"{factor}, violated (thick frame)"))  # fmt: skip
    handles.append(Patch(facecolor=ENVELOPE, alpha=0.18, label="any correlation of the active areas"))
    figure.legend(handles=handles, loc="lower left", ncols=2, fontsize=8.5, handlelength=2.6, columnspacing=1.5,
                  bbox_to_anchor=(0.06, 0.0), borderaxespad=0.2)  # fmt: skip
