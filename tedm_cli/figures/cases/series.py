"""What became of a temperature series: time series and spectra of the worst outputs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter, NullLocator

from tedm_cli.figures.cases.spectra import band_sample, bands, limit_lines, log_range
from tedm_cli.figures.drawing.fit import line_count, wrapped
from tedm_cli.figures.drawing.key import key
from tedm_cli.figures.drawing.style import (
    BLUE,
    COLOURS,
    LINE,
    SMALL,
    VERMILION,
    WIDTH,
    frequency_axis,
    grid,
    heading,
    heading_lines,
    power_of_ten,
    style,
)
from tedm_cli.results.cases.noise import limit_named
from tedm_cli.results.cases.series import SeriesNoise, SeriesOutput, thinned
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import capital, mhz_text, power_text, ratio_text, unit_text

_ROW, _BETWEEN = 1.9, 0.5  # inches
_LEFT, _TIME, _MIDDLE, _SPECTRUM = 0.78, 2.6, 0.94, 2.53
_PART_COLOURS = (COLOURS[3], COLOURS[2])  # of what makes an output together: wide and light, below it


def series_figure(series: SeriesNoise) -> Figure:
    """A row for each output: its time series, and its spectrum with requirement, band and interval."""
    with style():
        # bold type is wider than what is measured
        titles = [wrapped(_title(o), (WIDTH - 0.2) / 1.16, SMALL) for o in series.outputs]
        heading_text, more = f"Series {series.source}", series.treatment
        above = 0.12 + LINE * max(map(line_count, titles))
        top = heading_lines(heading_text, more)[2] + 0.08
        each = above + _ROW + _BETWEEN
        samples = _samples(series)
        legend = key(samples, WIDTH - 0.3) if samples else None
        total = top + len(series.outputs) * each + 0.1 + (0.0 if legend is None else legend.height)
        figure = Figure(figsize=(WIDTH, total))
        for row, (output, title) in enumerate(zip(series.outputs, titles, strict=True)):
            bottom = total - top - row * each - above - _ROW
            box = (bottom / total, _ROW / total)
            left = figure.add_axes((_LEFT / WIDTH, box[0], _TIME / WIDTH, box[1]))
            right = figure.add_axes(((_LEFT + _TIME + _MIDDLE) / WIDTH, box[0], _SPECTRUM / WIDTH, box[1]))
            _time(left, output)
            _spectrum(right, output, series)
            failed = output.verdict is not None and not output.verdict.passed
            figure.text(0.08 / WIDTH, (bottom + _ROW + 0.07) / total, title, fontsize=SMALL, va="bottom",
                        fontweight="bold" if failed else "normal")  # fmt: skip
        heading(figure, heading_text, more=more)
        if legend is not None:
            legend.draw(figure, 0.15, 0.08)
        return figure


def _title(o: SeriesOutput) -> str:
    rms = f"rms {power_text(o.rms, 3) if o.rms > 0 else '0'} {unit_text(o.unit)}"
    rms = f"{capital(output_title(o.output))} ({o.output}): {rms}"
    if o.verdict is None:
        return f"{rms}; not judged"
    v = o.verdict
    return (
        f"{rms}; {ratio_text(v.ratio)} times its limit at {mhz_text(v.binding_hz)}"
        f" ({limit_named(o.limits, v.requirement).plain}), {'pass' if v.passed else 'FAIL'}"
        f"{'' if v.whole_band else f' over {v.band_text}'}"
    )


def _time(axes: Axes, o: SeriesOutput) -> None:
    span = float(o.time_s[-1] - o.time_s[0])
    unit, second = ("s", 1.0) if span < 7200 else ("h", 3600.0) if span < 4 * 86400 else ("days", 86400.0)
    size = max(float(np.abs(o.low).max()), float(np.abs(o.high).max()))
    exponent = math.floor(math.log10(size)) if size > 0.0 else 0
    x, scale = o.time_s / second, 10.0**-exponent
    axes.fill_between(x, scale * o.low, scale * o.high, color=BLUE, linewidth=0.5)
    axes.set_xlim(x[0], x[-1])
    axes.xaxis.set_major_locator(MaxNLocator(5))
    axes.yaxis.set_major_locator(MaxNLocator(5))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}".replace("-", "−")))
    axes.tick_params(labelsize=SMALL)
    axes.set_xlabel(f"time ({unit})", fontsize=SMALL, labelpad=1)
    power = "" if exponent == 0 else f"{power_of_ten(10.0**exponent)} "
    axes.set_ylabel(wrapped(f"{o.output} ({power}{unit_text(o.unit)})", _ROW, SMALL), fontsize=SMALL)
    grid(axes)


def _spectrum(axes: Axes, o: SeriesOutput, series: SeriesNoise) -> None:
    if not len(o.spectrum.frequency_hz):
        axes.set_axis_off()
        axes.text(0.5, 0.5, "too short for a spectrum", ha="center", fontsize=SMALL, transform=axes.transAxes)
        return
    thin, factor = thinned(o.spectrum), series.safety_factor
    x, y = thin.trace()
    low, high = _range(o, series)
    tiny = np.finfo(np.float64).tiny  # a logarithmic axis has no zero
    bands(axes, o.limits)
    low_end, high_end = (np.maximum(factor * end, tiny) for end in (thin.low, thin.high))
    axes.fill_between(thin.frequency_hz * 1e3, low_end, high_end, color="#9A9A9A", linewidth=0, alpha=0.7)
    for part, colour in zip(o.parts.values(), _PART_COLOURS, strict=False):
        along, above = thinned(part).trace()
        axes.plot(along * 1e3, np.maximum(factor * above, tiny), color=colour, linewidth=3.5, alpha=0.6)
    passed = o.verdict is None or o.verdict.passed
    axes.plot(x * 1e3, np.maximum(factor * y, tiny), color=BLUE if passed else VERMILION, linewidth=0.9)
    limit_lines(axes, o.limit_hz, o.limits, 1.8)
    if o.verdict is not None:
        ratio, at = o.verdict.ratio, o.verdict.binding_hz
        limit = limit_named(o.limits, o.verdict.requirement)
        inside = np.isfinite(limit.amplitude)
        height = ratio * np.exp(np.interp(np.log(at), np.log(o.limit_hz[inside]), np.log(limit.amplitude[inside])))
        axes.plot([at * 1e3], [height], linestyle="none", marker="o" if passed else "X", markersize=7,
                  markerfacecolor="white", markeredgecolor="black", markeredgewidth=1.1, zorder=5,
                  clip_on=False)  # fmt: skip
    axes.set_yscale("log")
    axes.set_ylim(low, high)
    axes.yaxis.set_major_locator(LogLocator(base=10, numticks=6))
    axes.yaxis.set_major_formatter(FuncFormatter(power_of_ten))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_minor_formatter(NullFormatter())
    frequency_axis(axes, o.spectrum.frequency_hz[0], o.spectrum.frequency_hz[-1])
    if o.spectrum.frequency_hz[-1] < 300 * o.spectrum.frequency_hz[0]:
        axes.xaxis.set_major_locator(LogLocator(base=10, subs=(1.0, 2.0, 5.0)))
    axes.set_xlabel("frequency (mHz)", fontsize=SMALL, labelpad=1)
    axes.set_ylabel(f"{factor:g} × noise ({unit_text(o.unit)}/√Hz)", fontsize=SMALL)
    axes.tick_params(labelsize=SMALL)
    grid(axes)


def _range(o: SeriesOutput, series: SeriesNoise) -> tuple[float, float]:
    """Ends of the axis of a spectrum."""
    return log_range([series.safety_factor * thinned(o.spectrum).trace()[1], *(q.amplitude for q in o.limits)])


def _samples(series: SeriesNoise) -> list[Artist]:
    outputs = [o for o in series.outputs if len(o.spectrum.frequency_hz)]
    verdicts = [o.verdict for o in outputs]
    samples: list[Artist] = []
    if not outputs:
        return samples
    estimate = f"{series.safety_factor:g} × estimate"
    edge: dict[str, Any] = {"linewidth": 1.2, "markerfacecolor": "white", "markeredgecolor": "black"}
    if any(v is not None and v.passed for v in verdicts):
        label = f"{estimate}; ring: largest ratio"
        samples.append(Line2D([], [], color=BLUE, marker="o", markersize=6, label=label, **edge))
    elif any(v is None for v in verdicts):
        samples.append(Line2D([], [], color=BLUE, label=estimate, **edge))
    if any(v is not None and not v.passed for v in verdicts):
        samples.append(Line2D([], [], color=VERMILION, marker="X", markersize=7, label=f"{estimate}, violated", **edge))
    samples.append(Patch(color="#9A9A9A", alpha=0.7, label=f"its {100 * series.confidence:g} % interval"))
    parts = dict.fromkeys(name for o in outputs for name in o.parts)
    for name, colour in zip(parts, _PART_COLOURS, strict=False):
        seen = any(series.safety_factor * o.parts[name].asd.max() > _range(o, series)[0] for o in outputs)
        label = f"part of {name}" + ", below the axes" * (not seen)
        samples.append(Line2D([], [], color=colour, linewidth=3.5, alpha=0.6, label=label))
    limits = {q.name: q for o in outputs for q in o.limits}
    if limits:
        named = f"requirement{'s' if len(limits) > 1 else ''}: {'; '.join(q.plain for q in limits.values())}"
        samples.append(Line2D([], [], color="black", linewidth=1.8, label=named))
        samples.append(band_sample("band of the requirement"))
    return samples
