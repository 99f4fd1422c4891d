"""What would bring a verdict down: areas improved, and the factor on its temperatures that each group may have."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tedm_cli.figures.fit import fitted, text_width, wrapped
from tedm_cli.figures.style import BLUE, COLOURS, DASHES, VERMILION, WIDTH, grid, heading, ratio_axis, style
from tedm_cli.results.noise import SILENCED, CaseNoise, JudgedOutput
from tedm_cli.results.wording import mhz_text, power_text, ratio_text

_TOP, _CURVES, _BETWEEN, _ROW, _FOOT = 0.6, 2.0, 1.05, 0.25, 0.5  # inches
_SMALL = 8.0  # points
_LOOKS = {
    "silenced": ("silent", COLOURS[0], "o", DASHES[0]),
    "quieter": ("at a tenth", COLOURS[1], "s", DASHES[1]),
    "matched": ("matched", COLOURS[2], "^", DASHES[2]),
}
_LEAST = 1e-4  # of the first ratio: what lies below is as good as nothing
_FACTORS = (1e-4, 1e4)  # widest axis of factors


def improvement_figure(case: CaseNoise, j: JudgedOutput) -> Figure:
    """Above, the ratio with more and more areas improved; below, the factor that each group's temperatures may have."""
    with style():
        m = j.improvement
        names = "Worst first: " + (", ".join(m.chosen[SILENCED]) or "no area brings relief")
        lines = wrapped(names, WIDTH - 0.3, _SMALL, 3)
        between = _BETWEEN + 0.135 * lines.count("\n")
        factors = {**m.group_factor, "all together": m.all_factor}
        bars = _ROW * len(factors)
        total = _TOP + _CURVES + between + bars + _FOOT
        figure = Figure(figsize=(WIDTH, total))
        left = max(0.75, 0.2 + min(2.2, max(text_width(g, _SMALL) for g in factors)))
        words = [_words(f, m.group_level.get(g, np.nan)) for g, f in factors.items()]
        right = 0.25 + 1.15 * max(text_width(w, _SMALL) for w in words)
        upper, lower = figure.subplots(2, 1)
        upper.set_position((0.75 / WIDTH, 1 - (_TOP + _CURVES) / total, (WIDTH - 2.2) / WIDTH, _CURVES / total))
        lower.set_position((left / WIDTH, _FOOT / total, (WIDTH - left - right) / WIDTH, bars / total))
        _curves(upper, j)
        _factors(lower, factors, words, left)
        levels = f"right: K/√Hz at {mhz_text(j.binding_hz)}; " * any(v > 0.0 for v in m.group_level.values())
        lower.set_xlabel(f"{levels}bars: factor on the amplitude assumed (1)", fontsize=9)
        heading(figure, f"{j.output}, case {case.id}: what would lower {ratio_text(j.ratio)} × {j.requirement}?")
        notes = (
            (0.38, "The worst areas without noise (silent) or with a tenth of it, the best blocks matched"),
            (_TOP + _CURVES + 0.5, lines),
            (total - _FOOT - bars - 0.2, "The temperatures of one group: the factor that just meets the requirement"),
        )
        for down, text in notes:
            size = _SMALL if text == lines else 9
            figure.text(0.08 / WIDTH, 1 - down / total, text, fontsize=size, va="top")
        return figure


def _curves(axes: Axes, j: JudgedOutput) -> None:
    m = j.improvement
    least = _LEAST * max(j.ratio, 1e-300)
    ends = {}
    shown = m.count <= max(max(map(len, m.chosen.values())), 1)  # no further area brings relief
    shown[np.flatnonzero(~shown)[:1]] = True
    for name, ratio in m.ratio.items():
        label, colour, marker, dashes = _LOOKS[name]
        y = np.maximum(ratio[shown], least)
        axes.plot(m.count[shown], y, color=colour, marker=marker, linestyle=dashes, linewidth=1.6, markersize=5.5,
                  markeredgecolor="black", markeredgewidth=0.6, label=name)  # fmt: skip
        ends[label] = (float(y[-1]), float(ratio[shown][-1]), colour)
    axes.axhline(1.0, color="black", linewidth=1.5)
    axes.set_yscale("log")
    low, high = axes.get_ylim()
    low, high = min(low, 0.5), max(high, 2.0)
    axes.set_ylim(low, high)
    ratio_axis(axes.yaxis, low, high)
    axes.set_xticks(m.count[shown].tolist())
    axes.set_xlim(-0.3, float(m.count[shown][-1]) + 0.3)
    axes.tick_params(labelsize=8.5)
    axes.set_xlabel("number of areas improved (1)", fontsize=9)
    axes.set_ylabel("ratio to the requirement (1)", fontsize=9)
    grid(axes)
    axes.grid(False, which="minor")
    scale = _CURVES / math.log10(high / low)
    wanted = {f"{label}: {ratio_text(ratio)}": math.log10(y / low) * scale for label, (y, ratio, _) in ends.items()}
    colours = [colour for _, _, colour in ends.values()]
    limit = math.log10(1 / low) * scale
    heights = apart([*wanted.values(), limit], 0.15, _CURVES)
    named = [*wanted.items(), ("limit", limit)]
    for (text, place), colour, at in zip(named, [*colours, "black"], heights, strict=True):
        axes.plot([1.0, 1.03], [place / _CURVES, at / _CURVES], transform=axes.transAxes, clip_on=False, color=colour,
                  linewidth=0.7)  # fmt: skip
        axes.text(1.04, at / _CURVES, text, transform=axes.transAxes, va="center", fontsize=_SMALL)


def apart(places: Sequence[float], gap: float, room: float) -> list[float]:
    """Places moved up and down as little as keeps them `gap` apart and within 0 to `room`."""
    order = np.argsort(places, kind="stable")
    done = np.asarray(places, dtype=np.float64)[order]
    for i in range(1, len(done)):
        done[i] = max(done[i], done[i - 1] + gap)
    done[-1] = min(done[-1], room)
    for i in range(len(done) - 2, -1, -1):
        done[i] = min(done[i], done[i + 1] - gap)
    out = np.empty_like(done)
    out[order] = done
    return [float(v) for v in out]


def _factors(axes: Axes, factors: dict[str, float], words: Sequence[str], left: float) -> None:
    finite = [f for f in factors.values() if math.isfinite(f) and f > 0.0]
    low = max(min([0.5, *finite]) / 2.0, _FACTORS[0])
    high = min(max([2.0, *finite]) * 2.0, _FACTORS[1])
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    axes.set_ylim(len(factors) - 0.5, -0.5)
    for row, (factor, text) in enumerate(zip(factors.values(), words, strict=True)):
        axes.text(1.02, row, text, va="center", fontsize=_SMALL, transform=axes.get_yaxis_transform(),
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
    axes.set_yticks(range(len(factors)), [fitted(g, left - 0.15, _SMALL) for g in factors], fontsize=_SMALL)
    axes.tick_params(axis="y", length=0)
    axes.tick_params(axis="x", labelsize=8.5)
    ratio_axis(axes.xaxis, low, high)
    grid(axes)
    axes.grid(False, axis="y")


def _words(factor: float, level: float) -> str:
    """`1.6 × 10⁻⁵ × 0.3 = 4.8 × 10⁻⁶`: level at present, factor, level allowed."""
    known = power_text(level) if level > 0.0 else ""
    if math.isnan(factor) or math.isinf(factor):
        return f"{known}{', ' if known else ''}{'cannot alone' if math.isnan(factor) else 'not felt'}"
    times = f"× {power_text(factor, 3)}"
    return f"{known} {times} = {power_text(level * factor)}" if known else times
