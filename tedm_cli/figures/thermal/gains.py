"""Gain and phase of the disturbances of a thermal network to groups of its nodes, and the low-passes that fit them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, MultipleLocator

from tedm_cli.figures.cases.spectra import log_range
from tedm_cli.figures.drawing.fit import line_count, wrapped
from tedm_cli.figures.drawing.key import key
from tedm_cli.figures.drawing.spec import PAGE_HEIGHT
from tedm_cli.figures.drawing.style import (
    LINE,
    SMALL,
    WIDTH,
    frequency_axis,
    grid,
    heading,
    heading_lines,
    log_axis,
    series_look,
    style,
)
from tedm_cli.results.thermal.groups import GroupGains
from tedm_cli.results.wording import count

UNIT = {"temperature": "K/K", "power": "K/W"}
_LEFT, _RIGHT, _GAP, _FOOT = 0.78, 0.2, 0.36, 0.5  # inches, as are all below
_GAIN, _PHASE, _BETWEEN, _ABOVE = 1.42, 0.78, 0.08, 0.1
_DECADES = 8.0  # of gains that are shown
_FIT: dict[str, Any] = {"color": "black", "linewidth": 1.0, "linestyle": (0, (0.9, 1.9))}


def gains_figure(found: GroupGains, disturbances: Sequence[int]) -> Figure:
    """Panels of gain and of phase for each of some disturbances of one kind, a line for each group of nodes."""
    with style():
        unit = UNIT[found.kind[disturbances[0]]]
        columns = min(2, len(disturbances))
        rows = math.ceil(len(disturbances) / columns)
        width = (WIDTH - _LEFT - _RIGHT - (columns - 1) * _GAP) / columns
        titles = [wrapped(found.disturbance[d], width, SMALL) for d in disturbances]
        above = [_ABOVE + LINE * max(map(line_count, titles[i : i + columns])) for i in range(0, len(titles), columns)]
        title = f"Gain of {_what(found.kind[disturbances[0]])} to groups of thermal nodes"
        more = "mean temperature of each group, by heat capacity; dotted: the low-pass that fits its gain best"
        top = heading_lines(title, more)[2]
        legend = key(_samples(found), WIDTH - 0.3)
        around = top + sum(above) + rows * _BETWEEN + _FOOT + legend.height
        scale = min(1.0, (PAGE_HEIGHT - around) / (rows * (_GAIN + _PHASE)))  # a long key takes room from the panels
        tall = scale * (_GAIN + _PHASE) + _BETWEEN
        height = around + rows * scale * (_GAIN + _PHASE)
        figure = Figure(figsize=(WIDTH, height))
        low, high = _range(found, disturbances)
        panels: list[tuple[Axes, Axes]] = []
        upper = height - top
        for number, d in enumerate(disturbances):
            row, column = divmod(number, columns)
            if column == 0:
                upper -= above[row] + (tall if row else 0.0)
            x = _LEFT + column * (width + _GAP)
            gain, phase = (
                figure.add_axes((x / WIDTH, bottom / height, width / WIDTH, high_ / height))
                for bottom, high_ in ((upper - scale * _GAIN, scale * _GAIN), (upper - tall, scale * _PHASE))
            )
            panels.append((gain, phase))
            _draw(gain, phase, found, d, low)
            gain.set_title(titles[number], fontsize=SMALL, pad=3)
        _axes(panels, found, columns, (low, high), unit)
        heading(figure, title, more=more)
        legend.draw(figure, 0.15, 0.08)
        return figure


def _what(kind: str) -> str:
    return "temperatures of boundaries" if kind == "temperature" else "powers"


def _range(found: GroupGains, disturbances: Sequence[int]) -> tuple[float, float]:
    """Gains that are shown; all of nothing where there is none."""
    size = np.abs(found.gain[:, :, list(disturbances)])
    if not size.max() > 0.0:
        return 0.1, 10.0
    low, high = log_range([size[size > 0.0]])
    return max(low, high * 10.0**-_DECADES), high


def _look(i: int) -> dict[str, Any]:
    """Of the line of group number `i`."""
    return {**series_look(i), "linewidth": 1.5}


def _draw(gain: Axes, phase: Axes, found: GroupGains, d: int, low: float) -> None:
    f = found.frequency_hz * 1e3
    for g in range(len(found.group)):
        size = np.abs(found.gain[:, g, d])
        if not size.any():
            continue
        seen = size >= low  # what is below the axis has no phase to look at
        gain.plot(f, np.where(size > 0.0, size, np.nan), **_look(g))
        gain.plot(f, found.fit[:, g, d], **_FIT, zorder=3)
        if seen.any():
            phase.plot(f, np.where(seen, found.phase_deg[:, g, d], np.nan), **_look(g))


def _axes(
    panels: Sequence[tuple[Axes, Axes]], found: GroupGains, columns: int, limits: tuple[float, float], unit: str
) -> None:
    """The same scales everywhere; numbers at the left and below the lowest panel of each column."""
    seen = [np.asarray(line.get_ydata(), dtype=np.float64) for _, phase in panels for line in phase.get_lines()]
    values = np.concatenate([*seen, [0.0]])
    least, most = float(np.nanmin(values)), float(np.nanmax(values))
    step = next((s for s in (90.0, 180.0, 360.0, 720.0) if (most - least) / s <= 4.5), 1440.0)
    f = found.frequency_hz
    for number, (gain, phase) in enumerate(panels):
        left, lowest = number % columns == 0, number + columns >= len(panels)
        gain.set_yscale("log")
        gain.set_ylim(*limits)
        log_axis(gain.yaxis, decades=math.log10(limits[1] / limits[0]), label="")
        phase.set_ylim(least - 0.1 * step, most + 0.25 * step)
        phase.yaxis.set_major_locator(MultipleLocator(step))
        phase.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}".replace("-", "−")))
        for axes in (gain, phase):
            frequency_axis(axes, float(f[0]), float(f[-1]))
            axes.set_xlabel("")
            grid(axes)
            axes.tick_params(labelsize=SMALL, labelleft=left, labelbottom=axes is phase and lowest)
        if left:
            gain.set_ylabel(f"gain ({unit})", fontsize=SMALL)
            phase.set_ylabel("phase (°)", fontsize=SMALL)
        if lowest:
            phase.set_xlabel("frequency (mHz)", fontsize=SMALL, labelpad=1)


def _samples(found: GroupGains) -> list[Artist]:
    named = zip(found.group, found.nodes, strict=True)
    lines: list[Artist] = [
        Line2D([], [], **_look(g), label=f"{group} ({count(n, 'node')})") for g, (group, n) in enumerate(named)
    ]
    return [*lines, Line2D([], [], **_FIT, label="fitted low-pass")]
