"""What each disturbance of the thermal network does to the outputs of a case, and how stable it has to be."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, MaxNLocator

from tedm_cli.arrays import FloatArray
from tedm_cli.figures.cases.improvement import factor_bars
from tedm_cli.figures.cases.spectra import bands, limit_lines, limit_samples, log_range, scales
from tedm_cli.figures.drawing.fit import line_count, widest, wrapped
from tedm_cli.figures.drawing.key import key
from tedm_cli.figures.drawing.spec import PAGE_HEIGHT
from tedm_cli.figures.drawing.style import (
    COLOURS,
    LINE,
    SMALL,
    WIDTH,
    grid,
    heading,
    heading_lines,
    inches,
    series_look,
    style,
)
from tedm_cli.results.cases.deciding import without_repeats
from tedm_cli.results.cases.noise import CaseNoise, JudgedDisturbances, JudgedOutput, kinds_of
from tedm_cli.results.thermal.disturbances import Strictest
from tedm_cli.results.wording import and_text, mhz_text, power_text, ratio_text

_APART = 7  # disturbances that are told apart; the smaller ones of more are one
MOST_OUTPUTS = 24  # bars of a figure
_ROW, _FOOT, _NAMES, _WORDS = 0.26, 0.55, 2.6, 2.4  # inches
_LEFT, _RIGHT, _PANEL, _BELOW = 0.8, 0.12, 2.5, 0.55
_HATCHES = ("", "////", "||||", "\\\\\\\\", "xxxx", "----", "++")
_REST: dict[str, Any] = {"facecolor": "#DDDDDD", "hatch": "", "edgecolor": "black", "linewidth": 0.6}


def _of(j: JudgedOutput) -> JudgedDisturbances:
    assert j.disturbances is not None
    return j.disturbances


def _bar_look(i: int) -> dict[str, Any]:
    return {"facecolor": COLOURS[i % 6], "hatch": _HATCHES[i % len(_HATCHES)], "edgecolor": "black", "linewidth": 0.6}


def _told_apart(size: FloatArray) -> list[int]:
    """The largest of some disturbances, by their size [u]; all where they are few."""
    order = [int(d) for d in np.argsort(-size, kind="stable")]
    return order if len(order) <= _APART else order[: _APART - 1]


def shares_figure(case: CaseNoise) -> Figure:
    """A bar of each judged output, of the shares of the disturbances at the frequency that binds."""
    with style():
        judged = without_repeats([case])[0].judged
        judged = tuple(sorted(judged, key=lambda j: -j.ratio))[:MOST_OUTPUTS]
        names = _of(judged[0]).names
        share = np.array([_of(j).share for j in judged])
        told = _told_apart(np.abs(share).max(axis=0))
        rest = [d for d in range(len(names)) if d not in told]
        parts = [(names[d], share[:, d], _bar_look(i)) for i, d in enumerate(told)]
        if rest:
            parts.append((f"{len(rest)} others", share[:, rest].sum(axis=1), _REST))
        title = f"Shares of the disturbances in the noise of case {case.id}"
        more = "of the power at the frequency that binds; sum: 100 %. Negative: cancels others it is correlated with"
        rows = [wrapped(f"{j.output}, {mhz_text(j.contribution_hz)}", _NAMES, SMALL) for j in judged]
        row = max(_ROW, 0.09 + LINE * max(map(line_count, rows)))
        samples = [Patch(**look, label=wrapped(name, WIDTH - 0.8, SMALL)) for name, _, look in parts]
        legend = key(samples, WIDTH - 0.3, sample=2.6)
        top, foot = heading_lines(title, more)[2] + 0.1, _FOOT + legend.height
        figure = Figure(figsize=(WIDTH, top + row * len(rows) + foot))
        axes = figure.subplots()
        inches(figure, left=0.2 + widest(rows, SMALL), right=0.25, top=top, bottom=foot)
        _stack(axes, parts)
        axes.set_yticks(range(len(rows)), rows, fontsize=SMALL)
        axes.set_ylim(len(rows) - 0.5, -0.5)
        axes.tick_params(axis="y", length=0)
        axes.tick_params(axis="x", labelsize=SMALL)
        axes.xaxis.set_major_locator(MaxNLocator(8, steps=[1, 2, 5, 10]))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}".replace("-", "−")))
        axes.set_xlabel("share of the noise power (%)", fontsize=9)
        grid(axes)
        axes.grid(False, axis="y")
        axes.axvline(0.0, color="black", linewidth=0.8)
        heading(figure, title, more=more)
        legend.draw(figure, 0.15, 0.08)
        return figure


def _stack(axes: Axes, parts: Sequence[tuple[str, FloatArray, dict[str, Any]]]) -> None:
    """Positive parts from zero to the right, negative ones to the left."""
    ends = np.zeros((2, len(parts[0][1])))
    for _, share, look in parts:
        for place, value in enumerate(100.0 * share):
            side = int(value < 0.0)
            if abs(value) >= 0.05:
                axes.barh([place], [value], left=[ends[side, place]], height=0.66, **look)
            ends[side, place] += value
    low, high = float(ends[1].min()), float(ends[0].max())
    room = 0.02 * (high - low) or 1.0
    axes.set_xlim(low - room if low < 0.0 else 0.0, high + room)


def stability_figure(case: CaseNoise, strictest: Sequence[Strictest], together: Strictest) -> Figure:
    """A bar of each disturbance: the noise that it may have over that assumed, for the output that asks for most."""
    with style():
        shown = [*strictest[: _rows_that_fit(strictest)], together]
        title = f"Required stability of the disturbances, case {case.id}"
        more = (
            "noise that each disturbance may have, the others unchanged, over the assumed noise; right: that factor,"
            " and the output that asks for it"
        )
        if len(shown) <= len(strictest):
            more += f". {len(strictest) - len(shown) + 1} others may have more, or are not felt"
        names = [wrapped(s.name, _NAMES, SMALL) for s in shown]
        words = [wrapped(_factor_words(s), _WORDS, SMALL) for s in shown]
        row = max(_ROW, 0.09 + LINE * max(map(line_count, [*names, *words])))
        top = heading_lines(title, more)[2] + 0.1
        figure = Figure(figsize=(WIDTH, top + row * len(names) + _FOOT))
        axes = figure.subplots()
        right = 0.2 + 1.16 * widest(words, SMALL)
        inches(figure, left=0.2 + widest(names, SMALL), right=right, top=top, bottom=_FOOT)
        factor_bars(axes, [s.factor for s in shown], words, names)
        axes.set_xlabel("allowed / assumed (1)", fontsize=9)
        heading(figure, title, more=more)
        return figure


def _rows_that_fit(strictest: Sequence[Strictest]) -> int:
    """How many disturbances a page holds, whose names and words may have several lines."""
    names = [wrapped(s.name, _NAMES, SMALL) for s in strictest]
    words = [wrapped(_factor_words(s), _WORDS, SMALL) for s in strictest]
    row = max(_ROW, 0.09 + LINE * max(map(line_count, [*names, *words])))
    return int((PAGE_HEIGHT - _FOOT - 1.2) / row) - 1


def _factor_words(s: Strictest) -> str:
    if math.isinf(s.factor):
        return "not felt"
    if math.isnan(s.factor):
        return f"cannot meet it alone, {s.output}"
    return f"× {power_text(s.factor, 3)}, {s.output}"


def spectra_figure(case: CaseNoise) -> Figure:
    """Noise of the worst output of each quantity, by each disturbance alone, and its requirements."""
    with style():
        kinds = kinds_of([case])
        worst = [case.worst(kind) for kind in kinds]
        names = _of(worst[0]).names
        size = np.max([_of(j).asd.max(axis=1) / max(float(j.asd.max()), 1e-300) for j in worst], axis=0)
        told = _told_apart(size)
        title = f"Noise by each disturbance alone, case {case.id}"
        more = "the output with the largest ratio, with the safety factor"
        if len(told) < len(names):
            more += f"; {len(names) - len(told)} disturbances that do less are left out"
        columns = min(2, len(kinds))
        cell = (WIDTH - _RIGHT) / columns
        looks: list[dict[str, Any]] = [
            {**series_look(i), "linewidth": 1.5, "label": names[d]} for i, d in enumerate(told)
        ]
        total: dict[str, Any] = {"color": "#9A9A9A", "linewidth": 4.2, "alpha": 0.7, "label": "all together"}
        legend = key([Line2D([], [], **look) for look in (total, *looks)], WIDTH - 0.3)
        keys = [key(limit_samples(case.limits_of(kind), 2.0), cell - 0.2, most=1) for kind in kinds]
        words = [_panel_words(case, kind, cell - 0.15) for kind in kinds]
        head = 0.1 + LINE * max(map(line_count, words))
        block = head + _PANEL + _BELOW + max(k.height for k in keys)
        rows = math.ceil(len(kinds) / columns)
        top = heading_lines(title, more)[2]
        height = top + rows * block + 0.15 + legend.height
        figure = Figure(figsize=(WIDTH, height))
        for number, (kind, j) in enumerate(zip(kinds, worst, strict=True)):
            row, column = divmod(number, columns)
            bottom = height - top - row * block - head - _PANEL
            left = column * cell + _LEFT
            axes = figure.add_axes((left / WIDTH, bottom / height, (cell - _LEFT - 0.1) / WIDTH, _PANEL / height))
            _panel(
                axes,
                case,
                kind,
                [(total, j.asd), *((look, _of(j).asd[d]) for look, d in zip(looks, told, strict=True))],
            )
            axes.set_title(words[number], fontsize=SMALL, x=-(_LEFT - 0.1) / (cell - _LEFT - 0.1))
            keys[number].draw(figure, column * cell + 0.1, bottom - _BELOW - keys[number].height + 0.1)
        heading(figure, title, more=more)
        legend.draw(figure, 0.15, 0.08)
        return figure


def _panel_words(case: CaseNoise, kind: str, width: float) -> str:
    j = case.worst(kind)
    return wrapped(
        f"{and_text(case.worst_outputs(kind))}: {ratio_text(j.ratio)} × limit at {mhz_text(j.binding_hz)}", width, SMALL
    )


def _panel(axes: Axes, case: CaseNoise, kind: str, curves: Sequence[tuple[dict[str, Any], FloatArray]]) -> None:
    f, factor, limits = case.frequency_hz, case.safety_factor, case.limits_of(kind)
    low, high = log_range([factor * curves[0][1], *(q.amplitude for q in limits)])
    low = max(low * 1e-2, high * 1e-9)  # parts that do little, two decades below the smallest of the whole
    bands(axes, limits)
    for look, asd in (c for c in curves if c[1].any()):
        axes.plot(f * 1e3, np.where(asd > 0.0, factor * asd, np.nan), **look)
    limit_lines(axes, f, limits, 2.0)
    scales(axes, f, low, high, case.worst(kind).unit, f"{factor:g} × noise")
