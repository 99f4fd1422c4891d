"""What would bring a verdict down: areas improved, and the factor on its temperatures that each group may have."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tedm_cli.arrays import BoolArray
from tedm_cli.figures.cases.contributors import twins
from tedm_cli.figures.drawing.fit import line_count, text_width, widest, wrapped
from tedm_cli.figures.drawing.labels import apart
from tedm_cli.figures.drawing.style import (
    BLUE,
    COLOURS,
    DASHES,
    LINE,
    SMALL,
    VERMILION,
    WIDTH,
    grid,
    heading,
    heading_lines,
    ratio_axis,
    style,
)
from tedm_cli.figures.drawing.titles import judged_title, labels_words, limit_words
from tedm_cli.results.cases.noise import SILENCED, CaseNoise, JudgedOutput, level_unit
from tedm_cli.results.wording import mhz_text, power_text, ratio_text

_CURVES, _ROW, _NAMES = 2.0, 0.27, 2.2  # inches; the names at most
_LOOKS = {
    "silenced": ("silent", COLOURS[0], "o", DASHES[0]),
    "quieter": ("at a tenth", COLOURS[1], "s", DASHES[1]),
    "matched": ("matched", COLOURS[2], "^", DASHES[2]),
}
_LEAST = 1e-4  # of the first ratio: what lies below is as good as nothing
_FACTORS = (1e-4, 1e4)  # widest axis of factors
_WORDS = {
    "silenced": "the worst areas do not vary (silent)",
    "quieter": "they vary a tenth as much (at a tenth)",
    "matched": "the worst blocks vary as one (matched)",
}
_BELOW = (
    "Below: how much the temperatures of one group, all else unchanged, may vary so that the requirement is just met."
)
_LEVELS = " On the right: their noise as assumed ({}, at {}), the factor, and what is allowed."


def improvement_figure(case: CaseNoise, j: JudgedOutput) -> Figure:
    """Above, the ratio with more and more areas improved; below, the factor that each group's temperatures may have."""
    with style():
        m = j.improvement
        title = f"{judged_title(j.output, case.id)}: what would lower it?"
        limit = limit_words(j.ratio, case.limits, j.requirement, j.binding_hz)
        more = f"{limit}{twins(case, j)} {labels_words(j.output, j.requirement)}\n"
        more += "Above: " + "; ".join(_WORDS[name] for name in m.ratio) + "."
        chosen = "Worst first: " + (", ".join(m.chosen[SILENCED]) or "no area brings relief")
        chosen = wrapped(chosen, WIDTH - 0.3, SMALL)
        factors = {**m.group_factor, "all together": m.all_factor}
        names = [wrapped(name, _NAMES, SMALL) for name in factors]
        row = max(_ROW, 0.08 + LINE * max(map(line_count, names)))
        levels = any(v > 0.0 for v in m.group_level.values())
        said = _LEVELS.format(level_unit(m.group_level), mhz_text(j.binding_hz))
        below = wrapped(_BELOW + said * levels, WIDTH - 0.2, SMALL)
        top = heading_lines(title, more)[2] + 0.1
        notes = 0.55 + LINE * line_count(chosen) + 0.22 + LINE * line_count(below) + 0.12
        bars = row * len(factors)
        total = top + _CURVES + notes + bars + 0.55
        figure = Figure(figsize=(WIDTH, total))
        left = max(0.85, 0.2 + widest(names, SMALL))
        words = [_factor_words(f, m.group_level.get(g, np.nan)) for g, f in factors.items()]
        right = 0.2 + 1.16 * max(text_width(w, SMALL) for w in words)
        beside = 0.35 + max(text_width(w, SMALL) for w in ("requirement", *_end_words(j)))
        upper, lower = figure.subplots(2, 1)
        upper.set_position(
            (0.85 / WIDTH, 1 - (top + _CURVES) / total, (WIDTH - 0.85 - beside) / WIDTH, _CURVES / total)
        )
        lower.set_position((left / WIDTH, 0.55 / total, (WIDTH - left - right) / WIDTH, bars / total))
        _curves(upper, j)
        factor_bars(lower, list(factors.values()), words, names)
        lower.set_xlabel("allowed temperature noise / assumed (1)", fontsize=9)
        heading(figure, title, more=more)
        down = top + _CURVES + 0.55
        for text in (chosen, below):
            figure.text(0.08 / WIDTH, 1 - down / total, text, fontsize=SMALL, va="top", linespacing=1.15)
            down += LINE * line_count(text) + 0.22
        return figure


def _shown(j: JudgedOutput) -> BoolArray:
    """Which numbers of areas are drawn: up to where no further area brings relief."""
    most = _most(j)
    shown: BoolArray = j.improvement.count <= most
    if most not in j.improvement.count:
        shown[np.flatnonzero(~shown)[:1]] = True
    return shown


def _most(j: JudgedOutput) -> int:
    """The largest number of areas, or blocks, that there are to improve with any effect."""
    return max(max(map(len, j.improvement.chosen.values())), 1)


def _end_words(j: JudgedOutput) -> list[str]:
    """What stands at the ends of the curves."""
    shown = _shown(j)
    return [f"{_LOOKS[name][0]}: {ratio_text(float(r[shown][-1]))}" for name, r in j.improvement.ratio.items()]


def _curves(axes: Axes, j: JudgedOutput) -> None:
    m = j.improvement
    least = _LEAST * max(j.ratio, 1e-300)
    shown = _shown(j)
    count = np.minimum(m.count[shown], _most(j))
    ends = []
    for name, ratio in m.ratio.items():
        _, colour, marker, dashes = _LOOKS[name]
        y = np.maximum(ratio[shown], least)
        axes.plot(count, y, color=colour, marker=marker, linestyle=dashes, linewidth=1.6, markersize=5.5,
                  markeredgecolor="black", markeredgewidth=0.6, label=name)  # fmt: skip
        ends.append((float(y[-1]), colour, marker))
    axes.axhline(1.0, color="black", linewidth=1.5)
    axes.set_yscale("log")
    low, high = axes.get_ylim()
    low, high = min(low, 0.5), max(high, 2.0)
    axes.set_ylim(low, high)
    ratio_axis(axes.yaxis, low, high)
    axes.set_xticks(count.tolist())
    axes.set_xlim(-0.3, float(count[-1]) + 0.3)
    axes.tick_params(labelsize=SMALL)
    axes.set_xlabel("number of areas (matched: blocks) improved, the worst first (1)", fontsize=9)
    axes.set_ylabel("noise / requirement (1)", fontsize=9)
    grid(axes)
    axes.grid(False, which="minor")
    named = [(text, *end) for text, end in zip(_end_words(j), ends, strict=True)]
    named.append(("requirement", 1.0, "black", ""))
    places = [_CURVES * math.log10(y / low) / math.log10(high / low) for _, y, _, _ in named]
    for (text, _, colour, marker), place, at in zip(named, places, apart(places, 0.155, _CURVES), strict=True):
        common: dict[str, Any] = {"transform": axes.transAxes, "clip_on": False, "color": colour}
        axes.plot([1.0, 1.03], [place / _CURVES, at / _CURVES], linewidth=0.7, **common)
        if marker:
            axes.plot([1.03], [at / _CURVES], marker=marker, markersize=5, markeredgecolor="black",
                      markeredgewidth=0.6, **common)  # fmt: skip
        axes.text(1.05, at / _CURVES, text, transform=axes.transAxes, va="center", fontsize=SMALL)


def factor_bars(axes: Axes, factors: Sequence[float], words: Sequence[str], names: Sequence[str]) -> None:
    """A bar from 1 to each factor that just meets a requirement, with words behind it; NaN is a cross."""
    finite = [f for f in factors if math.isfinite(f) and f > 0.0]
    low = max(min([0.5, *finite]) / 2.0, _FACTORS[0])
    high = min(max([2.0, *finite]) * 2.0, _FACTORS[1])
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    axes.set_ylim(len(factors) - 0.5, -0.5)
    for row, (factor, text) in enumerate(zip(factors, words, strict=True)):
        axes.text(1.02, row, text, va="center", fontsize=SMALL, transform=axes.get_yaxis_transform(),
                  fontweight="bold" if factor < 1.0 else "normal")  # fmt: skip
        if math.isnan(factor):
            axes.plot([1.0], [row], marker="X", color="#7A7A7A", markersize=6, linestyle="none", zorder=4)
            continue
        quieter = factor < 1.0
        end = float(np.clip(factor, low, high))
        axes.barh([row], [end - 1.0], left=[1.0], color=VERMILION if quieter else BLUE, hatch="////" if quieter else "",
                  edgecolor="black", linewidth=0.6, height=0.62)  # fmt: skip
        if end != factor:
            axes.plot([end], [row], marker="<" if quieter else ">", color="black", markersize=5, linestyle="none",
                      clip_on=False, zorder=4)  # fmt: skip
    axes.axvline(1.0, color="black", linewidth=1.5)
    axes.set_yticks(range(len(factors)), names, fontsize=SMALL)
    axes.tick_params(axis="y", length=0)
    axes.tick_params(axis="x", labelsize=SMALL)
    ratio_axis(axes.xaxis, low, high)
    grid(axes)
    axes.grid(False, axis="y")


def _factor_words(factor: float, level: float) -> str:
    """`1.6 × 10⁻⁵ × 0.3 = 4.8 × 10⁻⁶`: level at present, factor, level allowed."""
    known = power_text(level) if level > 0.0 else ""
    if math.isnan(factor) or math.isinf(factor):
        return f"{known}{', ' if known else ''}{'cannot meet it alone' if math.isnan(factor) else 'not felt'}"
    times = f"× {power_text(factor, 3)}"
    return f"{known} {times} = {power_text(level * factor)}" if known else times
