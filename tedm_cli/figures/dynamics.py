"""The drag-free loop: its margins, what the noise of its outputs is made of, and the part of the temperatures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from matplotlib.ticker import FixedLocator

from tedm_cli.arrays import FloatArray
from tedm_cli.dynamics.judging import THERMAL
from tedm_cli.figures.fit import fitted
from tedm_cli.figures.spectra import bands, limit_lines, log_range, scales
from tedm_cli.figures.style import (
    COLOURS,
    DASHES,
    STACK,
    VERMILION,
    WIDTH,
    frequency_axis,
    grid,
    heading,
    inches,
    log_axis,
    style,
)
from tedm_cli.results.dynamics import ControlLoop, LoopOutput, LoopStability, SimulatedCase
from tedm_cli.results.wording import and_text, capital, mhz_text, ratio_text

_TITLE, _GAIN, _BETWEEN, _PHASE, _FOOT, _TOP = 0.3, 1.1, 0.1, 0.8, 0.5, 0.35  # inches of a family of loops
_LEFT, _BODE, _GAP, _NYQUIST, _LEGEND = 0.7, 3.1, 0.75, 1.6, 0.165
_SMALL = 8.0  # points
_AROUND = 30.0  # frequencies shown: so many times below the lowest crossover and above the highest
_GAINS = (1e-2, 1e4)
_SOURCES = ("#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#7A5C3E", "#6E6E6E", "#8C6BB1")
_TOTAL = COLOURS[0]


def loops_figure(stability: LoopStability) -> Figure:
    """Open-loop gain and phase of every family of loops, and their path near -1."""
    with style():
        families = stability.families()
        rows = {name: 0.42 + _LEGEND * -(-len(loops) // 2) for name, loops in families.items()}
        plots = _GAIN + _BETWEEN + _PHASE + _FOOT
        tall = {name: _TITLE + max(plots, _NYQUIST + below) for name, below in rows.items()}
        height = _TOP + sum(tall.values())
        figure = Figure(figsize=(WIDTH, height))
        span = _frequencies(stability)
        top = height - _TOP
        for name, loops in families.items():
            top -= _TITLE
            gain = _at(figure, _LEFT, top - _GAIN, _BODE, _GAIN)
            phase = _at(figure, _LEFT, top - _GAIN - _BETWEEN - _PHASE, _BODE, _PHASE)
            near = _at(figure, _LEFT + _BODE + _GAP, top - _NYQUIST, _NYQUIST * 1.5, _NYQUIST)
            figure.text(0.08 / WIDTH, (top + 0.08) / height, capital(name), fontsize=9.5)
            looks = [_look(i) for i in range(len(loops))]
            _bode(gain, phase, stability.frequency_hz, loops, looks, span)
            _nyquist(near, loops, looks)
            top += _TITLE - tall[name]
        heading(figure, "Loops of the controller, each broken while the others are closed")
        return figure


def _look(i: int) -> dict[str, Any]:
    """Of loop number `i`: later ones are narrower, so that those below them show."""
    return {
        "color": COLOURS[i % len(COLOURS)],
        "linestyle": DASHES[i % len(DASHES)],
        "linewidth": max(2.6 - 0.3 * i, 1.0),
    }


def _at(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Axes at a place in inches."""
    w, h = figure.get_size_inches()
    return figure.add_axes((left / w, bottom / h, width / w, height / h))


def _frequencies(stability: LoopStability) -> tuple[float, float]:
    """Frequencies around all crossovers; all of the file where there is none."""
    f = stability.frequency_hz
    crossed = [x.crossover_hz for x in stability.loops if x.crosses]
    if not crossed:
        return float(f[0]), float(f[-1])
    return max(float(f[0]), min(crossed) / _AROUND), min(float(f[-1]), max(crossed) * _AROUND)


def _bode(
    gain: Axes,
    phase: Axes,
    f: FloatArray,
    loops: Sequence[ControlLoop],
    looks: Sequence[dict[str, Any]],
    span: tuple[float, float],
) -> None:
    for x, look in zip(loops, looks, strict=True):
        angle = _phase_deg(f, x)
        gain.plot(f * 1e3, np.abs(x.open_loop), **look)
        phase.plot(f * 1e3, angle, **look)
        if x.crosses:
            ring: dict[str, Any] = {
                "linestyle": "none",
                "marker": "o",
                "markersize": 5,
                "markeredgecolor": "black",
                "zorder": 5,
            }
            at = float(np.interp(np.log(x.crossover_hz), np.log(f), angle))
            gain.plot([x.crossover_hz * 1e3], [1.0], markerfacecolor=look["color"], **ring)
            phase.plot([x.crossover_hz * 1e3], [at], markerfacecolor=look["color"], **ring)
    gain.axhline(1.0, color="black", linewidth=0.9)
    phase.axhline(-180.0, color="black", linewidth=0.9)
    gain.set_yscale("log")
    gain.set_ylim(*_GAINS)
    log_axis(gain.yaxis, decades=np.log10(_GAINS[1] / _GAINS[0]), label="gain |L| (1)")
    phase.set_ylim(-370.0, 10.0)
    phase.yaxis.set_major_locator(FixedLocator([-360.0, -270.0, -180.0, -90.0, 0.0]))
    phase.set_ylabel("phase (°)")
    for axes in (gain, phase):
        frequency_axis(axes, *span)
        axes.tick_params(labelsize=_SMALL)
        axes.xaxis.label.set_fontsize(8.5)
        axes.yaxis.label.set_fontsize(8.5)
        axes.yaxis.set_label_coords(-0.16, 0.5)
        grid(axes)
    gain.set_xlabel("")
    gain.tick_params(labelbottom=False)


def _phase_deg(f: FloatArray, x: ControlLoop) -> FloatArray:
    """Phase without jumps, [F]; above -360° and at most 0 where the gain is 1."""
    angle: FloatArray = np.degrees(np.unwrap(np.angle(x.open_loop)))
    if not x.crosses:
        return angle
    at = float(np.interp(np.log(x.crossover_hz), np.log(f), angle))
    turned: FloatArray = angle - 360.0 * np.ceil(at / 360.0)
    return turned


def _nyquist(axes: Axes, loops: Sequence[ControlLoop], looks: Sequence[dict[str, Any]]) -> None:
    """L near -1, and the circle around it that no loop of the family enters."""
    for x, look in zip(loops, looks, strict=True):
        axes.plot(x.open_loop.real, x.open_loop.imag, **look)
    closest = 1.0 / max(x.peak_sensitivity for x in loops)
    axes.add_patch(Circle((-1.0, 0.0), closest, fill=False, linestyle=DASHES[2], linewidth=1.0, edgecolor="black"))
    axes.plot([-1.0], [0.0], marker="+", markersize=9, markeredgewidth=1.8, color="black", linestyle="none")
    axes.set_xlim(-2.75, 1.0)
    axes.set_ylim(-1.25, 1.25)
    axes.set_aspect("equal")
    axes.tick_params(labelsize=_SMALL)
    axes.set_xlabel("real part of L (1)", fontsize=8.5, labelpad=1)
    axes.set_ylabel("imaginary part of L (1)", fontsize=8.5, labelpad=1)
    grid(axes)
    handles = [Line2D([], [], **look) for look in looks]
    axes.legend(
        handles,
        [fitted(_margin_words(x), 1.45, 7.5) for x in loops],
        loc="upper left",
        bbox_to_anchor=(-0.24, -0.25),
        ncols=2,
        fontsize=_SMALL,
        handlelength=2.2,
        columnspacing=0.8,
        labelspacing=0.25,
        borderaxespad=0.0,
        handletextpad=0.4,
    )


def _margin_words(x: ControlLoop) -> str:
    """Name and phase margin."""
    return f"{x.name} {x.phase_deg:.0f}°" if np.isfinite(x.phase_deg) else x.name


def budget_figure(case: SimulatedCase, j: LoopOutput) -> Figure:
    """An output with the safety factor: in total, by group of sources, and the requirements with their bands."""
    with style():
        factor, limits = case.safety_factor, case.limits_of(j.output)
        seen = case.seen_groups(j)
        figure = Figure(figsize=(WIDTH, 4.6 + 0.17 * (len(limits) + -(-len(seen) // 3))))
        axes = figure.subplots()
        low, high = case.budget_range(j)
        bands(axes, limits)
        axes.plot(case.frequency_hz * 1e3, factor * j.asd, color=_TOTAL, linewidth=4.4, alpha=0.45, label="total")
        others = [name for name in j.group_asd if name != THERMAL]  # a group has one look in all budgets
        for name in seen:
            i = -1 if name == THERMAL else others.index(name)
            colour, dashes = (VERMILION, "-") if i < 0 else (_SOURCES[i % len(_SOURCES)], DASHES[i % len(DASHES)])
            curve = factor * j.group_asd[name]
            axes.plot(case.frequency_hz * 1e3, curve, color=colour, linestyle=dashes, linewidth=1.6,
                      label=fitted(name, 1.5, 8.5))  # fmt: skip
        limit_lines(axes, case.frequency_hz, limits, 1.8)
        scales(axes, case.frequency_hz, low, high, j.unit, f"{factor:g} × noise")
        below = [name for name in j.group_asd if name not in seen]
        said = f"{ratio_text(j.ratio)} × {j.requirement} at {mhz_text(j.binding_hz)}"
        said += f". Below the axis: {and_text(below)}" if below else ""
        heading(figure, f"{j.output} in closed loop, case {case.id}", more=fitted(said, WIDTH - 0.3, 8.5))
        _legend_below(figure, axes, len(limits) + len({q.band_hz for q in limits}) + len(seen) + 1, 3)
        return figure


def thermal_figure(case: SimulatedCase, j: LoopOutput) -> Figure:
    """The part of the temperatures in an output: gravity and read-out as they add, apart, and gravity alone."""
    with style():
        factor, limits = case.safety_factor, case.limits_of(j.output)
        figure = Figure(figsize=(WIDTH, 4.6 + 0.17 * len(limits)))
        axes = figure.subplots()
        curves = {
            "gravity and read-out without phases": j.incoherent_asd,
            "gravity alone": j.gravity_asd,
            "gravity and read-out together": j.thermal_asd,
        }
        low, high = log_range([*(factor * c for c in curves.values()), *(q.amplitude for q in limits)])
        bands(axes, limits)
        for (name, curve), (colour, width, dashes) in zip(curves.items(), (*STACK[:2], STACK[3]), strict=True):
            axes.plot(case.frequency_hz * 1e3, factor * curve, color=colour, linewidth=width, linestyle=dashes,
                      label=name)  # fmt: skip
        limit_lines(axes, case.frequency_hz, limits, 1.8)
        scales(axes, case.frequency_hz, low, high, j.unit, f"{factor:g} × noise")
        more = (
            f"Without phases, the power at {mhz_text(j.binding_hz)} would be {ratio_text(j.incoherent)} times as large"
        )
        heading(figure, f"Temperatures in {j.output}, closed loop, case {case.id}", more=more)
        _legend_below(figure, axes, len(limits) + len({q.band_hz for q in limits}) + len(curves), 2)
        return figure


def _legend_below(figure: Figure, axes: Axes, entries: int, columns: int) -> None:
    """A legend of so many columns under the axes."""
    rows = -(-entries // columns)
    bottom = 0.6 + 0.19 * rows
    inches(figure, left=0.75, right=0.15, top=0.68, bottom=bottom)
    height = float(figure.get_size_inches()[1]) - 0.68 - bottom
    axes.legend(
        loc="upper left",
        bbox_to_anchor=(-0.09, -0.48 / height),
        ncols=columns,
        handlelength=3.2,
        columnspacing=1.2,
        fontsize=_SMALL,
        borderaxespad=0.0,
    )
