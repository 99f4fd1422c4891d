"""Amplitude spectral densities: one case, all cases, and the temperatures they start from."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from tedm_cli.arrays import FloatArray
from tedm_cli.figures.fit import fitted, text_width, wrapped
from tedm_cli.figures.style import (
    BAND,
    COLOURS,
    DASHES,
    ENVELOPE,
    FLIGHT,
    STACK,
    WIDTH,
    frequency_axis,
    grid,
    heading,
    inches,
    log_axis,
    style,
)
from tedm_cli.noise.flight_results import flight_results
from tedm_cli.results.noise import CaseNoise, JudgedOutput, Limit, TemperatureSpectra, kinds_of
from tedm_cli.results.series import thinned
from tedm_cli.results.wording import capital, mhz_text, power_text, quantity, ratio_text, unit_text

_MOST_DECADES = 9.0
_LEFT, _RIGHT, _TITLE, _PANEL, _STRIP, _LEGEND = 0.68, 0.1, 0.42, 2.45, 0.85, 0.165  # inches of a case's figure


def case_figure(case: CaseNoise) -> Figure:
    """Noise of the judged outputs of one case, a panel for each quantity, with limits, bands and bounds.

    Where the case has been realised, a strip below shows the estimate over the exact curve.
    """
    with style():
        kinds = kinds_of([case])
        columns = min(2, len(kinds))
        width = (WIDTH - _RIGHT) / columns
        strip = any(j.realised is not None for j in case.judged)
        below = _STRIP * strip + _LEGEND * max(_entries(case, kind) for kind in kinds) + 0.6
        rows = math.ceil(len(kinds) / columns)
        lines = wrapped(f"Case {case.id}: {case.title}", WIDTH - 1.1, 10.5, 3)
        top = 0.3 + 0.17 * lines.count("\n")
        height = top + rows * (_TITLE + _PANEL + below)
        figure = Figure(figsize=(WIDTH, height))

        def axes_at(number: int, down: float, tall: float) -> Axes:
            row, column = divmod(number, columns)
            bottom = height - top - row * (_TITLE + _PANEL + below) - _TITLE - down - tall
            left = column * width + _LEFT
            return figure.add_axes((left / WIDTH, bottom / height, (width - _LEFT - 0.08) / WIDTH, tall / height))

        panels = [axes_at(n, 0.0, _PANEL) for n in range(len(kinds))]
        for number, (axes, kind) in enumerate(zip(panels, kinds, strict=True)):
            _case_panel(axes, case, kind, width - 0.15)
            down = 0.4
            if strip:
                _realised(axes_at(number, _PANEL + 0.12, _STRIP - 0.12), axes, case.worst(kind))
                down += _STRIP
            corner = (-0.37 / (width - _LEFT), -down / _PANEL)
            axes.legend(loc="upper left", bbox_to_anchor=corner, handlelength=3.4, fontsize=8, labelspacing=0.3,
                        borderaxespad=0.0)  # fmt: skip
        figure.text(0.08 / WIDTH, 1 - 0.08 / height, lines, fontsize=10.5, fontweight="bold", va="top")
        return figure


def _entries(case: CaseNoise, kind: str) -> int:
    """Lines of the legend of a panel."""
    limits = case.limits_of(kind)
    return len({j.output for j in case.of_kind(kind)}) + len(limits) + len({q.band_hz for q in limits}) + 2


def _case_panel(axes: Axes, case: CaseNoise, kind: str, width: float) -> None:
    f = case.frequency_hz * 1e3
    factor = case.safety_factor
    worst = case.worst(kind)
    limits = case.limits_of(kind)
    outputs = {j.output: j for j in case.of_kind(kind)}
    curves = [factor * j.asd for j in outputs.values()]
    low, high = log_range([*curves, *(q.amplitude for q in limits), factor * worst.bound_high])
    bands(axes, limits)
    axes.fill_between(
        f,
        np.maximum(factor * worst.bound_low, low / 10),
        np.maximum(factor * worst.bound_high, low / 10),
        color=ENVELOPE,
        alpha=0.16,
        linewidth=0,
        label=fitted(f"bounds over correlations, {worst.output}", width - 0.95, 8),
    )
    for i, (name, curve) in enumerate(zip(outputs, curves, strict=True)):
        colour, thickness, dashes = STACK[i % len(STACK)]
        axes.plot(
            f,
            curve,
            color=colour,
            linestyle=dashes,
            linewidth=thickness,
            label=fitted(f"{factor:g} × {name}", width - 0.95, 8),
        )
    limit_lines(axes, case.frequency_hz, limits, 2.0)
    at = float(np.interp(worst.binding_hz, case.frequency_hz, factor * worst.asd))
    axes.plot(
        [worst.binding_hz * 1e3],
        [at],
        linestyle="none",
        marker="o",
        markersize=9,
        markerfacecolor="none",
        markeredgecolor="black",
        markeredgewidth=1.4,
        label=f"largest ratio, {mhz_text(worst.binding_hz)}",
    )
    scales(axes, case.frequency_hz, low, high, worst.unit, f"{factor:g} × noise")
    state = ": met" if worst.passed else ": VIOLATED"
    room = width - text_width(state, 8.5)
    verdict = f": {ratio_text(worst.ratio)} × limit at {mhz_text(worst.binding_hz)}"
    axes.set_title(
        f"{fitted(capital(quantity(kind, list(outputs))), room, 8.5)}{state}\n"
        f"{fitted(worst.output, width - text_width(verdict, 8.5), 8.5)}{verdict}",
        fontsize=8.5,
        x=-(_LEFT - 0.1) / (width + 0.07 - _LEFT),
    )


def _realised(axes: Axes, above: Axes, j: JudgedOutput) -> None:
    """The estimate from a realisation over the exact curve: its interval should hold 1."""
    above.tick_params(labelbottom=False)
    above.set_xlabel("")
    if j.realised is None:
        return
    thin = thinned(j.realised)
    x, y = thin.trace()
    axes.fill_between(thin.frequency_hz * 1e3, thin.low, thin.high, color="#B5B5B5", linewidth=0)
    axes.plot(x * 1e3, y, color=COLOURS[1], linewidth=0.6)
    axes.axhline(1.0, color="black", linewidth=1.0)
    frequency_axis(axes, *(edge / 1e3 for edge in above.get_xlim()))
    spread = max(float(np.abs(thin.high - 1).max()), float(np.abs(thin.low - 1).max()))
    axes.set_ylim(max(0.0, 1 - 1.1 * spread), 1 + 1.1 * spread)
    axes.yaxis.set_major_locator(MaxNLocator(3))
    axes.tick_params(labelsize=8)
    axes.set_xlabel("frequency (mHz)", fontsize=8.5, labelpad=1)
    axes.set_ylabel("estimate /\nexact (1)", fontsize=8, labelpad=1)
    grid(axes)


def overlay_figure(cases: Sequence[CaseNoise], kind: str) -> Figure:
    """The worst judged output of every case in one panel, each named at its right end."""
    with style():
        figure = Figure(figsize=(WIDTH, 5.2))
        axes = figure.subplots()
        shown = [c for c in cases if c.of_kind(kind)]
        worst = [c.worst(kind) for c in shown]
        curves = [c.safety_factor * j.asd for c, j in zip(shown, worst, strict=True)]
        limits = shown[0].limits_of(kind)
        f = shown[0].frequency_hz
        flight = flight_results(kind, f[0], f[-1])
        levels = [np.array([result.amplitude]) for result, _ in flight]
        low, high = log_range([*curves, *(q.amplitude for q in limits), *levels])
        bands(axes, limits)
        looks = [(COLOURS[i % len(COLOURS)], DASHES[i // 2 % len(DASHES)]) for i in range(len(curves))]
        for curve, (colour, dashes) in zip(curves, looks, strict=True):
            axes.plot(f * 1e3, curve, color=colour, linestyle=dashes, linewidth=1.7)
        limit_lines(axes, f, limits)
        for result, band in flight:
            label = f"{result.mission} in flight, {power_text(result.amplitude, 3)}"
            axes.plot(
                np.array(band) * 1e3, [result.amplitude] * 2, color=FLIGHT, linewidth=3.2, alpha=0.75, label=label
            )
        scales(axes, f, low, high, worst[0].unit, f"safety factor {shown[0].safety_factor:g} × noise")
        outputs = [j.output for j in worst]
        title = f"{capital(quantity(kind, outputs))}, the worst output of every case"
        heading(figure, title)
        names = [f"{c.id}: {j.output}, {ratio_text(j.ratio)}" for c, j in zip(shown, worst, strict=True)]
        names = [fitted(name, 1.9, 8.5) for name in names]
        right = 0.62 + max(1.3, *(text_width(name, 8.5) for name in names))
        inches(figure, left=0.72, right=right, top=0.45, bottom=1.15)
        _name_ends(figure, axes, names, curves, looks)
        axes.legend(loc="upper left", bbox_to_anchor=(-0.1, -0.11), ncols=2, handlelength=3.4)
        return figure


def _name_ends(
    figure: Figure, axes: Axes, names: Sequence[str], curves: Sequence[FloatArray], looks: Sequence[tuple[str, Any]]
) -> None:
    """Names beside the right ends of the curves, moved apart where they would overlap and tied by thin lines."""
    low, high = np.log10(axes.get_ylim())
    height = axes.get_position().height * figure.get_size_inches()[1]
    ends = [np.clip((np.log10(max(c[-1], 1e-300)) - low) / (high - low), 0.0, 1.0) for c in curves]
    order = np.argsort(ends, kind="stable")
    gap = min(0.17 / height, 1.0 / max(len(ends) - 1, 1))
    placed = np.array(ends)[order]
    for i in range(1, len(placed)):
        placed[i] = max(placed[i], placed[i - 1] + gap)
    over = max(placed[-1] - 1.0, 0.0)
    placed[-1] -= over
    for i in range(len(placed) - 2, -1, -1):
        placed[i] = min(placed[i], placed[i + 1] - gap)
    for number, y in zip(order, placed, strict=True):
        colour, dashes = looks[number]
        common = {"transform": axes.transAxes, "clip_on": False, "color": colour}
        axes.plot([1.0, 1.03], [ends[number], y], linewidth=0.7, **common)
        axes.plot([1.035, 1.095], [y, y], linewidth=1.7, linestyle=dashes, **common)
        axes.text(1.105, y, names[number], transform=axes.transAxes, va="center", fontsize=8.5)
    heading: dict[str, Any] = {"transform": axes.transAxes, "va": "center", "fontsize": 8.5, "fontstyle": "italic"}
    axes.text(1.105, placed[-1] + 1.3 * gap, "case: output, ratio", **heading)


def temperature_figure(spectra: TemperatureSpectra) -> Figure:
    """Distinct temperature spectra of the areas."""
    with style():
        figure = Figure(figsize=(WIDTH, 4.2))
        axes = figure.subplots()
        low, high = log_range(list(spectra.asd))
        for i, (name, asd) in enumerate(sorted(zip(spectra.name, spectra.asd, strict=True), key=lambda s: -s[1][0])):
            axes.plot(
                spectra.frequency_hz * 1e3,
                asd,
                color=COLOURS[i % 7],
                linestyle=DASHES[i % len(DASHES)],
                linewidth=2.0,
                label=name,
            )
        scales(axes, spectra.frequency_hz, low, high, "K", "temperature")
        axes.set_title("Temperature noise of the thermal areas (no safety factor)")
        rows = len(spectra.name)
        inches(figure, left=1.0, right=0.25, top=0.4, bottom=0.75 + 0.19 * rows)
        axes.legend(loc="upper left", bbox_to_anchor=(-0.02, -0.15), handlelength=3.4)
        return figure


def scales(axes: Axes, frequency_hz: FloatArray, low: float, high: float, unit: str, what: str) -> None:
    """Logarithmic axes of amplitude spectral densities `what` in `unit` per √Hz, from `low` to `high`."""
    axes.set_yscale("log")
    axes.set_ylim(low, high)
    label = f"{what} ({unit_text(unit)}/√Hz)"
    log_axis(axes.yaxis, decades=np.log10(high / low), label=label)
    frequency_axis(axes, frequency_hz[0], frequency_hz[-1])
    axes.tick_params(labelsize=8.5)
    axes.xaxis.label.set_fontsize(9)
    axes.yaxis.label.set_fontsize(9)
    grid(axes)


def bands(axes: Axes, limits: Sequence[Limit]) -> None:
    """Bands of requirements as grey strips with dotted edges."""
    for low_hz, high_hz in dict.fromkeys(q.band_hz for q in limits):
        label = f"band {low_hz * 1e3:g} to {high_hz * 1e3:g} mHz"
        axes.axvspan(low_hz * 1e3, high_hz * 1e3, color=BAND, linewidth=0, zorder=0, label=label)
        for edge in (low_hz, high_hz):
            axes.axvline(edge * 1e3, color="#808080", linewidth=0.9, linestyle=DASHES[2], zorder=1)


def limit_lines(axes: Axes, frequency_hz: FloatArray, limits: Sequence[Limit], width: float = 2.4) -> None:
    """Requirements inside their bands, told apart by dashes."""
    for i, limit in enumerate(limits):
        inside = np.isfinite(limit.amplitude)
        axes.plot(
            frequency_hz[inside] * 1e3,
            limit.amplitude[inside],
            color="black",
            linestyle=DASHES[i % len(DASHES)],
            linewidth=width,
            label=f"requirement {fitted(limit.name, 1.5, 8)}",
        )


def log_range(curves: Sequence[FloatArray]) -> tuple[float, float]:
    """Limits of a logarithmic axis that hold all curves, at most nine decades below the highest."""
    positive = np.concatenate([c[np.isfinite(c) & (c > 0)] for c in curves])
    if not positive.size:
        return 1e-3, 1.0
    high = 2.0 * positive.max()
    return float(max(positive.min() / 2, high * 10**-_MOST_DECADES)), float(high)
