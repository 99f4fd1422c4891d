"""Figure 6.2 of Montemurro (2004): acceleration noise of test masses with imposed positions, and what it is made of."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from tedm_cli.arrays import FloatArray
from tedm_cli.figures.cases.spectra import limit_lines, scales
from tedm_cli.figures.drawing.fit import wrapped
from tedm_cli.figures.drawing.key import key
from tedm_cli.figures.drawing.style import SMALL, STACK, WIDTH, grid, heading, heading_lines, log_axis, style
from tedm_cli.gravity.field import OTHER_TEST_MASS
from tedm_cli.results.dynamics.imposed import ImposedMotion, ImposedNoise

_LEFT, _SPECTRA, _GAP, _BARS, _TALL, _FOOT = 0.78, 2.75, 1.45, 1.85, 2.6, 0.6  # inches
_DECADES = 0.5  # above and below all that is shown
_MARKS = ("o", "s", "D", "^")


def imposed_figure(found: ImposedMotion) -> Figure:
    """Spectra of all sources and of the other test mass against the requirement; beside them each source alone."""
    with style():
        title = "Self-gravity force noise of imposed positions"
        more = f"Independent positions of {1e9 * found.motion[0]:.3g} nm/√Hz along x, no loop, no safety factor"
        noise, alone = key(_noise_samples(found), _LEFT + _SPECTRA, most=1), key(_source_samples(found), 2.9, most=1)
        foot = _FOOT + max(noise.height, alone.height)
        height = heading_lines(title, more)[2] + 0.1 + _TALL + foot
        figure = Figure(figsize=(WIDTH, height))
        spectra = figure.add_axes((_LEFT / WIDTH, foot / height, _SPECTRA / WIDTH, _TALL / height))
        left = (_LEFT + _SPECTRA + _GAP) / WIDTH
        parts = figure.add_axes((left, foot / height, _BARS / WIDTH, _TALL / height))
        _spectra(spectra, found)
        _parts(parts, found)
        heading(figure, title, more=more)
        noise.draw(figure, 0.1, foot - _FOOT + 0.08 - noise.height)
        alone.draw(figure, WIDTH - 3.0, foot - _FOOT + 0.08 - alone.height)
        return figure


def _name(n: ImposedNoise) -> str:
    return f"{n.test_mass}, {n.model}"


def _shown(found: ImposedMotion) -> list[tuple[str, FloatArray]]:
    """Spectra with their names: of all sources, and of the other test mass alone as the thesis has it."""
    shown = [(_name(n), n.asd) for n in found.noises]
    first = found.noises[0]
    if OTHER_TEST_MASS in first.alone:
        shown.append((f"{_name(first)}: {OTHER_TEST_MASS}", first.alone[OTHER_TEST_MASS]))
    return shown


def _noise_samples(found: ImposedMotion) -> list[Line2D]:
    lines = [
        Line2D([], [], color=colour, linewidth=width, linestyle=dashes, label=name)
        for (name, _), (colour, width, dashes) in zip(_shown(found), STACK, strict=False)
    ]
    return [*lines, Line2D([], [], color="black", linewidth=2.0, label=f"requirement: {found.limit.plain}")]


def _source_samples(found: ImposedMotion) -> list[Line2D]:
    marks = [Line2D([], [], label=_name(n), **_mark(i)) for i, n in enumerate(found.noises)]
    return [*marks, Line2D([], [], color="black", linewidth=1.4, label="requirement, lowest frequency")]


def _mark(i: int) -> dict[str, Any]:
    return {
        "linestyle": "none", "marker": _MARKS[i % len(_MARKS)], "markersize": 6, "color": STACK[i % len(STACK)][0],
        "markeredgecolor": "black", "markeredgewidth": 0.6,
    }  # fmt: skip


def _spectra(axes: Axes, found: ImposedMotion) -> None:
    f, shown = found.frequency_hz, _shown(found)
    for (_, asd), (colour, width, dashes) in zip(shown, STACK, strict=False):
        axes.plot(f * 1e3, asd, color=colour, linewidth=width, linestyle=dashes)
    limit_lines(axes, f, [found.limit], 2.0)
    heights = np.concatenate([asd for _, asd in shown if asd.any()] + [found.limit.amplitude])
    scales(axes, f, heights.min() / 10**_DECADES, heights.max() * 10**_DECADES, "m s^-2", "noise")


def _parts(axes: Axes, found: ImposedMotion) -> None:
    """Noise by each source alone at the lowest frequency, a row for each source and a mark for each test mass."""
    sources = list(dict.fromkeys(s for n in found.noises for s in n.alone))
    for i, n in enumerate(found.noises):
        y = [sources.index(s) + 0.22 * (i - (len(found.noises) - 1) / 2) for s in n.alone]
        x = [asd[0] for asd in n.alone.values()]
        axes.plot(x, y, **_mark(i))
    level = float(found.limit.amplitude[0])
    axes.axvline(level, color="black", linewidth=1.4)
    values = [level, *(a[0] for n in found.noises for a in n.alone.values())]
    low, high = min(values) / 10**_DECADES, max(values) * 10**_DECADES
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    log_axis(axes.xaxis, decades=np.log10(high / low), label="each source alone (m s⁻²/√Hz)")
    axes.set_yticks(range(len(sources)), [wrapped(s, 1.1, SMALL) for s in sources])
    axes.set_ylim(len(sources) - 0.5, -0.5)
    axes.tick_params(labelsize=SMALL)
    axes.xaxis.label.set_fontsize(SMALL)
    grid(axes)
