"""Amplitude spectral densities: one case, all cases, and the temperatures they start from."""

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
from matplotlib.ticker import MaxNLocator

from tedm_cli.arrays import FloatArray
from tedm_cli.figures.drawing.fit import line_count, wrapped
from tedm_cli.figures.drawing.key import key
from tedm_cli.figures.drawing.style import (
    BAND,
    BAND_EDGE,
    BAND_GREY,
    DASHES,
    ENVELOPE,
    LINE,
    SMALL,
    STACK,
    VERMILION,
    WIDTH,
    frequency_axis,
    grid,
    heading,
    heading_lines,
    inches,
    log_axis,
    series_look,
    style,
)
from tedm_cli.results.cases.noise import CaseNoise, JudgedOutput, Limit, TemperatureSpectra, kinds_of
from tedm_cli.results.cases.series import thinned
from tedm_cli.results.wording import and_text, capital, mhz_text, quantity, ratio_text, unit_text

_MOST_DECADES = 9.0
_LEFT, _RIGHT, _PANEL, _STRIP = 0.74, 0.1, 2.45, 0.85  # inches of a case's figure


def case_figure(case: CaseNoise) -> Figure:
    """Noise of the judged outputs of one case, a panel for each quantity, with limits, bands and bounds.

    Where the case has been realised, a strip below shows the estimate over the exact curve.
    """
    with style():
        kinds = kinds_of([case])
        columns = min(2, len(kinds))
        width = (WIDTH - _RIGHT) / columns
        strip = any(j.realised is not None for j in case.judged)
        top = heading_lines(f"Case {case.id}: {case.title}", "")[2]
        titles = [_panel_title(case, kind, width - 0.15) for kind in kinds]
        head = 0.12 + LINE * max(map(line_count, titles))
        legends = [key(_samples(case, kind), width - 0.2, most=1) for kind in kinds]
        below = _STRIP * strip + max(legend.height for legend in legends) + 0.6
        rows = math.ceil(len(kinds) / columns)
        height = top + rows * (head + _PANEL + below)
        figure = Figure(figsize=(WIDTH, height))

        def axes_at(number: int, down: float, tall: float) -> Axes:
            row, column = divmod(number, columns)
            bottom = height - top - row * (head + _PANEL + below) - head - down - tall
            left = column * width + _LEFT
            return figure.add_axes((left / WIDTH, bottom / height, (width - _LEFT - 0.08) / WIDTH, tall / height))

        panels = [axes_at(n, 0.0, _PANEL) for n in range(len(kinds))]
        for number, (axes, kind) in enumerate(zip(panels, kinds, strict=True)):
            _case_panel(axes, case, kind)
            axes.set_title(titles[number], fontsize=SMALL, x=-(_LEFT - 0.1) / (width - 0.08 - _LEFT))
            if strip:
                _realised(axes_at(number, _PANEL + 0.12, _STRIP - 0.12), axes, case.worst(kind))
            row, column = divmod(number, columns)
            upper = height - top - row * (head + _PANEL + below) - head - _PANEL - _STRIP * strip - 0.45
            legends[number].draw(figure, column * width + 0.1, upper - legends[number].height)
        heading(figure, f"Case {case.id}: {case.title}")
        return figure


def _panel_title(case: CaseNoise, kind: str, width: float) -> str:
    """What a panel shows and its verdict, with all outputs that have the largest ratio."""
    worst = case.worst(kind)
    outputs = list(dict.fromkeys(j.output for j in case.of_kind(kind)))
    state = "met" if worst.passed else "VIOLATED"
    verdict = f"{ratio_text(worst.ratio)} × limit at {mhz_text(worst.binding_hz)}"
    return "\n".join(
        wrapped(line, width, SMALL)
        for line in (f"{capital(quantity(kind, outputs))}: {state}", f"{and_text(case.worst_outputs(kind))}: {verdict}")
    )


def _looks(case: CaseNoise, kind: str) -> list[tuple[JudgedOutput, dict[str, Any]]]:
    """Outputs of a panel, each with its line: a wide and light one shows below a narrow and dark one."""
    outputs = {j.output: j for j in case.of_kind(kind)}
    looks = []
    for i, (name, j) in enumerate(outputs.items()):
        colour, thickness, dashes = STACK[i % len(STACK)]
        label = f"{case.safety_factor:g} × {name}"
        looks.append((j, {"color": colour, "linewidth": thickness, "linestyle": dashes, "label": label}))
    return looks


def _ring(case: CaseNoise, kind: str) -> dict[str, Any]:
    return {
        "linestyle": "none",
        "marker": "o",
        "markersize": 9,
        "markerfacecolor": "none",
        "markeredgecolor": "black",
        "markeredgewidth": 1.4,
        "label": f"largest ratio, {mhz_text(case.worst(kind).binding_hz)}",
    }


def _samples(case: CaseNoise, kind: str) -> list[Artist]:
    """The key of a panel."""
    bounds = f"{and_text(case.worst_outputs(kind))} with any correlation of the areas"
    return [
        *(Line2D([], [], **look) for _, look in _looks(case, kind)),
        Line2D([], [], **_ring(case, kind)),
        Patch(**ENVELOPE, label=bounds),
        *limit_samples(case.limits_of(kind), 2.0),
    ]


def _case_panel(axes: Axes, case: CaseNoise, kind: str) -> None:
    f = case.frequency_hz * 1e3
    factor = case.safety_factor
    worst = case.worst(kind)
    limits = case.limits_of(kind)
    looks = _looks(case, kind)
    low, high = log_range(
        [*(factor * j.asd for j, _ in looks), *(q.amplitude for q in limits), factor * worst.bound_high]
    )
    bands(axes, limits)
    least, most = (np.maximum(factor * bound, low / 10) for bound in (worst.bound_low, worst.bound_high))
    axes.fill_between(f, least, most, **ENVELOPE)
    for j, look in looks:
        axes.plot(f, factor * j.asd, **look)
    limit_lines(axes, case.frequency_hz, limits, 2.0)
    at = float(np.interp(worst.binding_hz, case.frequency_hz, factor * worst.asd))
    axes.plot([worst.binding_hz * 1e3], [at], **_ring(case, kind))
    scales(axes, case.frequency_hz, low, high, worst.unit, f"{factor:g} × noise")


def _realised(axes: Axes, above: Axes, j: JudgedOutput) -> None:
    """The estimate from a realisation over the exact curve: its interval should hold 1."""
    above.tick_params(labelbottom=False)
    above.set_xlabel("")
    if j.realised is None:
        return
    thin = thinned(j.realised)
    x, y = thin.trace()
    axes.fill_between(thin.frequency_hz * 1e3, thin.low, thin.high, color="#B5B5B5", linewidth=0)
    axes.plot(x * 1e3, y, color=VERMILION, linewidth=0.6)
    axes.axhline(1.0, color="black", linewidth=1.0)
    frequency_axis(axes, *(edge / 1e3 for edge in above.get_xlim()))
    spread = max(float(np.abs(thin.high - 1).max()), float(np.abs(thin.low - 1).max()))
    axes.set_ylim(max(0.0, 1 - 1.1 * spread), 1 + 1.1 * spread)
    axes.yaxis.set_major_locator(MaxNLocator(3))
    axes.tick_params(labelsize=SMALL)
    axes.set_xlabel("frequency (mHz)", fontsize=SMALL, labelpad=1)
    axes.set_ylabel("estimate /\nexact (1)", fontsize=SMALL, labelpad=1)
    grid(axes)


def temperature_figure(spectra: TemperatureSpectra) -> Figure:
    """Distinct temperature spectra of the areas; those of gradients, which have another unit, in a panel below."""
    with style():
        title = "Temperature noise of the thermal areas (no safety factor)"
        found = zip(spectra.name, spectra.asd, spectra.unit, strict=True)
        order = sorted(found, key=lambda s: (s[2] != "K", -s[1][0]))
        looks: list[dict[str, Any]] = [
            {**series_look(i), "linewidth": 2.0, "label": name} for i, (name, _, _) in enumerate(order)
        ]
        legend = key([Line2D([], [], **look) for look in looks], WIDTH - 0.3, most=1)
        top = heading_lines(title, "")[2] + 0.1
        units = list(dict.fromkeys(unit for _, _, unit in order))
        panels = [2.9] * len(units)
        figure = Figure(figsize=(WIDTH, top + sum(panels) + 0.55 * len(units) + legend.height))
        for axes, unit in zip(figure.subplots(len(units), 1, squeeze=False)[:, 0], units, strict=True):
            low, high = log_range([asd for _, asd, of in order if of == unit])
            for look, (_, asd, of) in zip(looks, order, strict=True):
                if of == unit:
                    axes.plot(spectra.frequency_hz * 1e3, asd, **look)
            what = "temperature" if unit == "K" else "temperature gradient"
            scales(axes, spectra.frequency_hz, low, high, unit, what)
        heading(figure, title)
        between = 0.55 / 2.9 if len(units) > 1 else None
        inches(figure, left=_LEFT, right=0.25, top=top, bottom=0.55 + legend.height)
        figure.subplots_adjust(hspace=between)
        legend.draw(figure, 0.15, 0.08)
        return figure


def scales(axes: Axes, frequency_hz: FloatArray, low: float, high: float, unit: str, what: str) -> None:
    """Logarithmic axes of amplitude spectral densities `what` in `unit` per √Hz, from `low` to `high`."""
    axes.set_yscale("log")
    axes.set_ylim(low, high)
    label = f"{what} ({unit_text(unit)}/√Hz)"
    log_axis(axes.yaxis, decades=np.log10(high / low), label=label)
    frequency_axis(axes, frequency_hz[0], frequency_hz[-1])
    axes.tick_params(labelsize=SMALL)
    axes.xaxis.label.set_fontsize(9)
    axes.yaxis.label.set_fontsize(9)
    grid(axes)


def bands(axes: Axes, limits: Sequence[Limit]) -> None:
    """Bands of requirements: where there is one, a grey strip; several are told apart by the lines of their limits."""
    found = list(dict.fromkeys(q.band_hz for q in limits))
    for low_hz, high_hz in found:
        if len(found) == 1:
            axes.axvspan(low_hz * 1e3, high_hz * 1e3, color=BAND, linewidth=0, zorder=0)
        for edge in (low_hz, high_hz):
            axes.axvline(edge * 1e3, color=BAND_GREY, zorder=1, **BAND_EDGE)


def limit_lines(axes: Axes, frequency_hz: FloatArray, limits: Sequence[Limit], width: float = 2.4) -> None:
    """Requirements inside their bands, told apart by dashes, on white so that they stand out from what they cross."""
    for i, limit in enumerate(limits):
        inside = np.isfinite(limit.amplitude)
        x, y = frequency_hz[inside] * 1e3, limit.amplitude[inside]
        axes.plot(x, y, color="white", linewidth=width + 1.6, alpha=0.85, zorder=2.8)
        axes.plot(x, y, zorder=2.9, **_limit_look(i, limit, width))


def limit_samples(limits: Sequence[Limit], width: float = 2.4) -> list[Artist]:
    """What keys say of requirements and their bands: one that all share by its strip, several beside their names."""
    looks = [_limit_look(i, limit, width) for i, limit in enumerate(limits)]
    spans = [" to ".join(f"{edge * 1e3:g}" for edge in limit.band_hz) + " mHz" for limit in limits]
    if len(set(spans)) == 1:
        strip = f"band of the requirement{'s' * (len(limits) > 1)}, {spans[0]}"
        return [*(Line2D([], [], **look) for look in looks), band_sample(strip)]
    return [
        Line2D([], [], **{**look, "label": f"{look['label']} ({span})"})
        for look, span in zip(looks, spans, strict=True)
    ]


def band_sample(label: str) -> Patch:
    """What keys say of the grey strip of a band."""
    return Patch(facecolor=BAND, edgecolor=BAND_GREY, **BAND_EDGE, label=label)


def _limit_look(i: int, limit: Limit, width: float) -> dict[str, Any]:
    return {
        "color": "black",
        "linestyle": DASHES[i % len(DASHES)],
        "linewidth": width,
        "label": f"requirement: {limit.plain}",
    }


def log_range(curves: Sequence[FloatArray]) -> tuple[float, float]:
    """Limits of a logarithmic axis that hold all curves, at most nine decades below the highest."""
    positive = np.concatenate([c[np.isfinite(c) & (c > 0)] for c in curves])
    if not positive.size:
        return 1e-3, 1.0
    high = 2.0 * positive.max()
    return float(max(positive.min() / 2, high * 10**-_MOST_DECADES)), float(high)
