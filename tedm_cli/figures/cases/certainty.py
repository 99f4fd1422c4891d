"""How sure the verdicts are: the range of each ratio over correlations and over temperature filters."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from tedm_cli.figures.drawing.fit import line_count, text_width, widest, wrapped
from tedm_cli.figures.drawing.key import key
from tedm_cli.figures.drawing.style import (
    BLUE,
    LINE,
    SMALL,
    VERMILION,
    WIDTH,
    grid,
    heading,
    heading_lines,
    inches,
    ratio_axis,
    style,
)
from tedm_cli.results.cases.noise import CaseNoise, JudgedOutput
from tedm_cli.results.wording import capital, quantity, ratio_text

_ROW, _FOOT = 0.4, 0.55  # inches
_NAMES = 2.4  # room of the titles of the cases
_THIN, _THICK, _FILTERS = "#7A7A7A", "#A9C7DE", "#6B4E00"
_LOWEST = 1e-4  # of the axis: what lies below is as good as nothing


def certainty_figure(cases: Sequence[CaseNoise], kind: str) -> Figure:
    """A row for each case: its ratio, the bounds over correlations, and the range over temperature filters."""
    with style():
        shown = [c for c in cases if c.of_kind(kind)]
        worst = [c.worst(kind) for c in shown]
        verdicts = [f"{ratio_text(j.ratio)} {'pass' if j.passed else 'FAIL'}" for j in worst]
        names = [wrapped(f"{c.id}  {c.title}", _NAMES, SMALL) for c in shown]
        title = f"{capital(quantity(kind, [j.output for j in worst]))}: how sure is the verdict of each case?"
        top = heading_lines(title, "")[2] + 0.1
        legend = key(_samples(worst), WIDTH - 0.3, sample=2.6)
        row = max(_ROW, 0.1 + LINE * max(map(line_count, names)))
        figure = Figure(figsize=(WIDTH, top + len(shown) * row + _FOOT + legend.height))
        axes = figure.subplots()
        right = 0.2 + 1.16 * max(text_width(v, SMALL) for v in verdicts)
        inches(figure, left=0.2 + widest(names, SMALL), right=right, top=top, bottom=_FOOT + legend.height)
        low, high = _scale(worst)
        axes.set_xscale("log")
        axes.set_xlim(low, high)
        axes.set_ylim(len(shown) - 0.5, -0.5)
        for place, j in enumerate(worst):
            _row(axes, place, j, low)
        axes.axvline(1.0, color="black", linewidth=1.5, zorder=3)
        axes.set_yticks(range(len(shown)), names)
        axes.tick_params(axis="y", length=0, labelsize=SMALL, pad=6)
        axes.tick_params(axis="x", labelsize=SMALL)
        ratio_axis(axes.xaxis, low, high)
        axes.set_xlabel("ratio to the requirement, safety factor included (1)", fontsize=SMALL)
        grid(axes)
        axes.grid(False, axis="y")
        for place, (j, verdict) in enumerate(zip(worst, verdicts, strict=True)):
            axes.text(1.02, place, verdict, transform=axes.get_yaxis_transform(), va="center", fontsize=SMALL,
                      fontweight="normal" if j.passed else "bold")  # fmt: skip
        heading(figure, title)
        legend.draw(figure, 0.15, 0.08)
        return figure


def _scale(worst: Sequence[JudgedOutput]) -> tuple[float, float]:
    """Ends of the axis: all ratios and bounds that are not nothing, and 1."""
    values = [j.ratio for j in worst] + [r for j in worst for r in j.bound_ratio.values()]
    for filters in (j.filter_ratio for j in worst):
        values += [] if filters is None else [float(filters.min()), float(filters.max())]
    high = max(1.0, *values)
    low = min([1.0, *(v for v in values if v >= _LOWEST)])
    return low / 3.0, high * 2.0


def _row(axes: Axes, row: int, j: JudgedOutput, low: float) -> None:
    b = {name: max(value, low) for name, value in j.bound_ratio.items()}
    axes.plot([b["minimum"], b["maximum"]], [row, row], color=_THIN, linewidth=1.3, solid_capstyle="butt", zorder=2)
    ends = [b["known_blocks_minimum"], b["known_blocks"]]
    axes.plot(ends, [row, row], color=_THICK, linewidth=8, solid_capstyle="butt", zorder=2.2)
    axes.plot([b["maximum_non_negative"]], [row], color="black", marker="|", markersize=11, markeredgewidth=1.6,
              linestyle="none", zorder=3.5)  # fmt: skip
    if min(j.bound_ratio["minimum"], j.bound_ratio["known_blocks_minimum"]) < low:
        axes.plot([low], [row], marker="<", markersize=6, color=_THIN, linestyle="none", clip_on=False, zorder=4)
    if j.filter_ratio is not None:
        ends = [max(float(r), low) for r in (j.filter_ratio.min(), j.filter_ratio.max())]
        axes.plot(ends, [row + 0.27, row + 0.27], color=_FILTERS, linewidth=1.1, linestyle=(0, (4, 1.5)), marker="|",
                  markersize=6, zorder=2.5)  # fmt: skip
    axes.plot([max(j.ratio, low)], [row], marker="o" if j.passed else "X", markersize=7.5, linestyle="none",
              color=BLUE if j.passed else VERMILION, markeredgecolor="black", markeredgewidth=0.8, zorder=5,
              clip_on=False, label="ratio")  # fmt: skip


def _samples(worst: Sequence[JudgedOutput]) -> list[Artist]:
    handles: list[Artist] = []
    for passed, marker, colour, text in ((True, "o", BLUE, "met"), (False, "X", VERMILION, "violated")):
        if passed in {j.passed for j in worst}:
            handles.append(Line2D([], [], marker=marker, color=colour, markeredgecolor="black", linestyle="none",
                                  markersize=7.5, label=f"the case as it is, {text}"))  # fmt: skip
    handles += [
        Patch(color=_THICK, label="its blocks, any correlation between"),
        Line2D([], [], color=_THIN, linewidth=1.3, label="any correlation of its areas"),
        Line2D([], [], marker="|", color="black", markersize=11, markeredgewidth=1.6, linestyle="none",
               label="largest without negative correlation"),
    ]  # fmt: skip
    if any(j.bound_ratio["minimum"] < _scale(worst)[0] for j in worst):
        handles.append(Line2D([], [], marker="<", color=_THIN, markersize=6, linestyle="none",
                              label="may cancel: goes on to the left"))  # fmt: skip
    if any(j.filter_ratio is not None for j in worst):
        handles.append(Line2D([], [], color=_FILTERS, linewidth=1.1, linestyle=(0, (4, 1.5)), marker="|", markersize=6,
                              label="the case with other filters"))  # fmt: skip
    return handles
