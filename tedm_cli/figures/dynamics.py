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
from tedm_cli.figures.cases.spectra import bands, limit_lines, limit_samples, log_range, scales
from tedm_cli.figures.drawing.key import Key, key
from tedm_cli.figures.drawing.spec import PAGE_WIDTH
from tedm_cli.figures.drawing.style import (
    COLOURS,
    DASHES,
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
from tedm_cli.figures.drawing.titles import judged_title, labels_words, limit_words
from tedm_cli.results.cases.noise import Limit
from tedm_cli.results.dynamics.loop import ControlLoop, LoopOutput, LoopStability, SimulatedCase
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import and_text, capital, mhz_text, ratio_text

_HEADING = "Loops of the controller, each broken while the others are closed"
_TITLE, _GAIN, _BETWEEN, _PHASE, _FOOT = 0.3, 1.2, 0.1, 0.85, 0.5  # inches of a family of loops
_LEFT, _BODE, _GAP, _NYQUIST, _BESIDE = 0.8, 4.0, 0.85, 1.75, 3.5
_AROUND = 30.0  # frequencies shown: so many times below the lowest crossover and above the highest
_GAINS = (1e-2, 1e4)
_SOURCES = ("#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#7A5C3E", "#6E6E6E", "#8C6BB1")
_THERMAL_LOOK = {"color": VERMILION, "linestyle": "-"}
_SPECTRUM = 3.5  # inches


def loops_figure(stability: LoopStability) -> Figure:
    """Open-loop gain and phase of every family of loops, and their path near -1."""
    with style():
        families = stability.families()
        looks = {name: [_look(i, x) for i, x in enumerate(loops)] for name, loops in families.items()}
        keys = {name: key([Line2D([], [], **look) for look in each], _BESIDE, most=2) for name, each in looks.items()}
        plots = _GAIN + _BETWEEN + _PHASE + _FOOT
        tall = {name: _TITLE + max(plots, _NYQUIST + 0.45 + legend.height + 0.1) for name, legend in keys.items()}
        upper = heading_lines(_HEADING, "")[2]
        height = upper + sum(tall.values())
        figure = Figure(figsize=(PAGE_WIDTH, height))
        span = _frequencies(stability)
        top = height - upper
        for name, loops in families.items():
            top -= _TITLE
            gain = _at(figure, _LEFT, top - _GAIN, _BODE, _GAIN)
            phase = _at(figure, _LEFT, top - _GAIN - _BETWEEN - _PHASE, _BODE, _PHASE)
            near = _at(figure, _LEFT + _BODE + _GAP, top - _NYQUIST, _NYQUIST * 1.5, _NYQUIST)
            figure.text(0.08 / PAGE_WIDTH, (top + 0.08) / height, capital(name), fontsize=9.5)
            _bode(gain, phase, stability.frequency_hz, loops, looks[name], span)
            _nyquist(near, loops, looks[name])
            keys[name].draw(figure, _LEFT + _BODE + 0.3, top - _NYQUIST - 0.45 - keys[name].height)
            top += _TITLE - tall[name]
        heading(figure, _HEADING)
        return figure


def _look(i: int, x: ControlLoop) -> dict[str, Any]:
    """Of loop number `i`: later ones are narrower, so that those below them show."""
    return {
        **series_look(i),
        "linewidth": max(4.2 - 0.6 * i, 1.0),
        "label": _margin_words(x),
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
        axes.tick_params(labelsize=SMALL)
        axes.xaxis.label.set_fontsize(SMALL)
        axes.yaxis.label.set_fontsize(SMALL)
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
    axes.tick_params(labelsize=SMALL)
    axes.set_xlabel("real part of L (1)", fontsize=SMALL, labelpad=1)
    axes.set_ylabel("imaginary part of L (1)", fontsize=SMALL, labelpad=1)
    grid(axes)


def _margin_words(x: ControlLoop) -> str:
    """Name and phase margin."""
    return f"{x.name} {x.phase_deg:.0f}°" if np.isfinite(x.phase_deg) else x.name


def budget_figure(case: SimulatedCase, j: LoopOutput) -> Figure:
    """An output with the safety factor: in total, by group of sources, and the requirements with their bands."""
    with style():
        factor, limits = case.safety_factor, case.limits_of(j.output)
        seen = case.seen_groups(j)
        below = [name for name in j.group_asd if name not in seen]
        said = f"{limit_words(j.ratio, limits, j.requirement, j.binding_hz)} {labels_words(j.output, j.requirement)}"
        said += f" Below the axis: {and_text(below)}." if below else ""
        others = [name for name in j.group_asd if name != THERMAL]  # a group has one look in all budgets
        looks: dict[str, dict[str, Any]] = {
            "total": {"color": COLOURS[0], "linewidth": 5.0, "alpha": 0.45, "label": "total"}
        }
        for name in seen:
            look = _THERMAL_LOOK if name == THERMAL else series_look(1 + others.index(name), _SOURCES)
            looks[name] = {**look, "linewidth": 1.6, "label": name}
        figure, axes, legend = _spectrum(
            f"{judged_title(j.output, case.id)}, in closed loop", said, [*looks.values()], limits
        )
        low, high = case.budget_range(j)
        bands(axes, limits)
        curves = {"total": j.asd, **j.group_asd}
        for name, look in looks.items():
            axes.plot(case.frequency_hz * 1e3, factor * curves[name], **look)
        limit_lines(axes, case.frequency_hz, limits, 1.8)
        scales(axes, case.frequency_hz, low, high, j.unit, f"{factor:g} × noise")
        legend.draw(figure, 0.15, 0.08)
        return figure


def thermal_figure(case: SimulatedCase, j: LoopOutput) -> Figure:
    """The part of the temperatures in an output: gravity and read-out as they add, apart, and gravity alone."""
    with style():
        factor, limits = case.safety_factor, case.limits_of(j.output)
        curves = {
            "gravity and read-out without phases": j.incoherent_asd,
            "gravity alone": j.gravity_asd,
            "gravity and read-out together": j.thermal_asd,
        }
        looks: list[dict[str, Any]] = [
            {"color": colour, "linewidth": width, "linestyle": dashes, "label": name}
            for name, (colour, width, dashes) in zip(curves, (*STACK[:2], STACK[3]), strict=True)
        ]
        more = (
            f"Without phases, the power at {mhz_text(j.binding_hz)} would be {ratio_text(j.incoherent)} times as large."
            f" {labels_words(j.output, j.requirement)}"
        )
        figure, axes, legend = _spectrum(
            f"Temperatures in the {output_title(j.output)}, closed loop, case {case.id}", more, looks, limits
        )
        low, high = log_range([*(factor * c for c in curves.values()), *(q.amplitude for q in limits)])
        bands(axes, limits)
        for curve, look in zip(curves.values(), looks, strict=True):
            axes.plot(case.frequency_hz * 1e3, factor * curve, **look)
        limit_lines(axes, case.frequency_hz, limits, 1.8)
        scales(axes, case.frequency_hz, low, high, j.unit, f"{factor:g} × noise")
        legend.draw(figure, 0.15, 0.08)
        return figure


def _spectrum(
    title: str, more: str, looks: Sequence[dict[str, Any]], limits: Sequence[Limit]
) -> tuple[Figure, Axes, Key]:
    """A figure of one spectrum with its heading, and the key that goes below it."""
    legend = key([*(Line2D([], [], **look) for look in looks), *limit_samples(limits, 1.8)], WIDTH - 0.3)
    top = heading_lines(title, more)[2] + 0.12
    figure = Figure(figsize=(WIDTH, top + _SPECTRUM + 0.6 + legend.height))
    axes = figure.subplots()
    inches(figure, left=0.8, right=0.15, top=top, bottom=0.6 + legend.height)
    heading(figure, title, more=more)
    return figure, axes, legend
