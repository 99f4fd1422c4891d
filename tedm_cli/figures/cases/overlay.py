"""All cases in one panel: those that are likely in colour and named at their ends, the others as thin grey lines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from tedm_cli.arrays import FloatArray
from tedm_cli.figures.cases.spectra import bands, limit_lines, limit_samples, log_range, scales
from tedm_cli.figures.drawing.fit import line_count, widest, wrapped
from tedm_cli.figures.drawing.key import key
from tedm_cli.figures.drawing.labels import apart
from tedm_cli.figures.drawing.style import (
    COLOURS,
    DASHES,
    FLIGHT,
    LINE,
    SMALL,
    WIDTH,
    heading,
    heading_lines,
    inches,
    style,
)
from tedm_cli.noise.flight_results import FlightResult, flight_results
from tedm_cli.results.cases.deciding import DIAGNOSTIC, LIKELY, POSSIBLE, possible_of
from tedm_cli.results.cases.noise import CaseNoise
from tedm_cli.results.titles import outputs_title
from tedm_cli.results.wording import and_text, capital, power_text, quantity, ratio_text

_LEFT, _PANEL, _BELOW = 0.78, 3.6, 0.6  # inches
_NAMES = 1.75  # inches of the names beside the curves
_LEADER, _SAMPLE, _GAP = 0.16, 0.42, 0.06  # inches between curve and name
_GREY: dict[str, tuple[str, Any]] = {POSSIBLE: ("#8C8C8C", "-"), DIAGNOSTIC: ("#8C8C8C", (0, (2, 2)))}


def overlay_figure(cases: Sequence[CaseNoise], kind: str) -> Figure:
    """The worst judged output of every case in one panel; the likely ones stand out.

    Where no case is likely, those that are possible stand in for them, and else all.
    """
    with style():
        shown = [c for c in cases if c.of_kind(kind)]
        bold = [c for c in shown if c.role == LIKELY]
        if not bold:
            named = {c.id for c, _ in possible_of([(c, c.worst(kind)) for c in shown])}
            bold = [c for c in shown if c.id in named]
        others = [c for c in shown if c not in bold]
        names = [_name(c, kind) for c in bold]
        gap = LINE * max(map(line_count, names)) + 0.06
        flight = _flight(shown[0], kind)
        limits = shown[0].limits_of(kind)
        measured = [_flight_look(i, result) for i, (result, _) in enumerate(flight)]
        samples = [*limit_samples(limits), *(Line2D([], [], **look) for look in measured), *_grey_samples(others)]
        legend = key(samples, WIDTH - 0.3)
        title = f"{capital(quantity(kind, [c.worst(kind).output for c in shown]))}, the worst output of every case"
        top = heading_lines(title, "")[2] + 0.12
        panel = max(_PANEL, gap * len(bold))
        figure = Figure(figsize=(WIDTH, top + panel + _BELOW + legend.height))
        axes = figure.subplots()
        right = 0.08 + _LEADER + _SAMPLE + _GAP + widest(names, SMALL)
        inches(figure, left=_LEFT, right=right, top=top, bottom=_BELOW + legend.height)
        _curves(axes, shown, bold, kind)
        bands(axes, limits)
        limit_lines(axes, shown[0].frequency_hz, limits)
        for (result, band), look in zip(flight, measured, strict=True):
            axes.plot(np.array(band) * 1e3, [result.amplitude] * 2, **look)
        heading(figure, title)
        _name_ends(axes, names, [c.safety_factor * c.worst(kind).asd for c in bold], gap, panel)
        legend.draw(figure, 0.15, 0.08)
        return figure


def _name(case: CaseNoise, kind: str) -> str:
    """A case with its ratio, and below it all outputs that have it, in plain words."""
    ratio = wrapped(f"case {case.id}: {ratio_text(case.worst(kind).ratio)} × limit", _NAMES, SMALL)
    return f"{ratio}\n{wrapped(outputs_title(case.worst_outputs(kind)), _NAMES, SMALL)}"


def _look(i: int) -> dict[str, Any]:
    return {"color": COLOURS[i % 6], "linestyle": DASHES[i % len(DASHES)], "linewidth": 2.2}


def _curves(axes: Axes, shown: Sequence[CaseNoise], bold: Sequence[CaseNoise], kind: str) -> None:
    f = shown[0].frequency_hz
    curves = [c.safety_factor * c.worst(kind).asd for c in shown]
    flight = [np.array([r.amplitude]) for r, _ in _flight(shown[0], kind)]
    low, high = log_range([*curves, *(q.amplitude for q in shown[0].limits_of(kind)), *flight])
    for case, curve in zip(shown, curves, strict=True):
        if case in bold:
            axes.plot(f * 1e3, curve, zorder=2.4, label=f"case {case.id}", **_look(bold.index(case)))
        else:
            colour, dashes = _GREY[case.role]
            axes.plot(f * 1e3, curve, color=colour, linestyle=dashes, linewidth=0.9, label=f"case {case.id}")
    scales(axes, f, low, high, shown[0].worst(kind).unit, f"safety factor {shown[0].safety_factor:g} × noise")


def _grey_samples(others: Sequence[CaseNoise]) -> list[Artist]:
    """What the key says of the cases that are not named at their ends."""
    samples: list[Artist] = []
    for role, (colour, dashes) in _GREY.items():
        ids = [c.id for c in others if c.role == role]
        if ids:
            label = f"{role}: case{'s' * (len(ids) > 1)} {and_text(ids)}"
            samples.append(Line2D([], [], color=colour, linestyle=dashes, linewidth=0.9, label=label))
    return samples


def _flight(case: CaseNoise, kind: str) -> list[tuple[FlightResult, tuple[float, float]]]:
    return flight_results(kind, case.frequency_hz[0], case.frequency_hz[-1], case.limit_names)


def _flight_look(i: int, result: FlightResult) -> dict[str, Any]:
    label = f"{result.mission} in flight, {power_text(result.amplitude, 3)}"
    return {"color": FLIGHT, "linewidth": 3.2, "linestyle": DASHES[i % len(DASHES)], "alpha": 0.75, "label": label}


def _name_ends(axes: Axes, names: Sequence[str], curves: Sequence[FloatArray], gap: float, panel: float) -> None:
    """Names beside the right ends of the curves, moved apart where they would overlap and tied by thin lines."""
    low, high = np.log10(axes.get_ylim())
    ends = [float(np.clip((np.log10(max(c[-1], 1e-300)) - low) / (high - low), 0.0, 1.0)) for c in curves]
    places = apart([panel * e for e in ends], gap, panel - gap / 2, gap / 2)
    wide = axes.get_position().width * WIDTH
    for i, (name, end, place) in enumerate(zip(names, ends, places, strict=True)):
        y, look = place / panel, _look(i)
        x = [1.0 + d / wide for d in (0.0, _LEADER, _LEADER + 0.01, _LEADER + _SAMPLE, _LEADER + _SAMPLE + _GAP)]
        common: dict[str, Any] = {"transform": axes.transAxes, "clip_on": False}
        axes.plot(x[:2], [end, y], color=look["color"], linewidth=0.7, **common)
        axes.plot(x[2:4], [y, y], **look, **common)
        axes.text(x[4], y, name, transform=axes.transAxes, va="center", fontsize=SMALL, linespacing=1.1)
