"""The field at rest against its allocations."""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from tedm_cli.figures.fit import fitted, text_width
from tedm_cli.figures.style import COLOURS, VERMILION, WIDTH, grid, heading, inches, ratio_axis, style
from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.results.field import SUBSYSTEM, symbol
from tedm_cli.results.wording import ratio_text

_ROW, _TOP, _BETWEEN, _FOOT = 0.44, 0.62, 0.5, 1.02  # inches
_SMALL = 8.0  # points
_LEAST = 1e-4  # of the limit: what lies below is as good as nothing
_LABEL = 1.0  # inches beside the last mark
_LOOKS = (("o", COLOURS[4]), ("s", COLOURS[5]), ("D", COLOURS[0]), ("^", COLOURS[2]))


def at_rest_figure(verdicts: Sequence[DcVerdict]) -> Figure:
    """A panel for each test mass, a row for each quantity, a mark for each subsystem."""
    with style():
        masses = list(dict.fromkeys(v.test_mass for v in verdicts))
        quantities = list(dict.fromkeys(v.quantity for v in verdicts))
        subsystems = list(dict.fromkeys(v.subsystem for v in verdicts))
        columns = min(2, len(masses))
        rows = math.ceil(len(masses) / columns)
        panel = _ROW * len(quantities)
        total = _TOP + rows * panel + (rows - 1) * _BETWEEN + _FOOT
        figure = Figure(figsize=(WIDTH, total))
        left = 0.25 + max(text_width(symbol(q), 9) for q in quantities)
        panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).reshape(-1)
        inches(figure, left=left, right=0.15, top=_TOP, bottom=_FOOT, wspace=0.06)
        figure.subplots_adjust(hspace=_BETWEEN / panel)
        low, high = _scale(verdicts, (WIDTH - left - 0.15) / columns)
        for number, (axes, mass) in enumerate(zip(panels, masses, strict=False)):
            _panel(axes, [v for v in verdicts if v.test_mass == mass], quantities, subsystems, low)
            axes.set_xscale("log")
            axes.set_xlim(low, high)
            ratio_axis(axes.xaxis, low, high)
            axes.tick_params(axis="x", labelsize=8.5, labelbottom=number + columns >= len(masses))
            if number + columns >= len(masses):
                axes.set_xlabel("|value| / limit (1)", fontsize=9)
            of_mass = [v for v in verdicts if v.test_mass == mass]
            met = sum(v.passed for v in of_mass)
            title = f": {met} of {len(of_mass)} within"
            axes.set_title(f"{fitted(mass, 2.8 - text_width(title, 9), 9)}{title}", fontsize=9, pad=4)
        panels[0].set_ylim(len(quantities) - 0.5, -0.5)
        panels[0].set_yticks(range(len(quantities)), [symbol(q) for q in quantities], fontsize=9)
        for axes in panels[len(masses) :]:
            axes.set_visible(False)
        heading(figure, "Field at rest against its allocation")
        low_marks = any(v.ratio < low for v in verdicts)
        figure.legend(handles=_legend(subsystems, low_marks), loc="lower left", ncols=4, fontsize=8.5,
                      columnspacing=1.3, bbox_to_anchor=(0.01, 0.0), borderaxespad=0.2)  # fmt: skip
        return figure


def _scale(verdicts: Sequence[DcVerdict], width: float) -> tuple[float, float]:
    """Ends of an axis of `width` inches, with room for a label beside the largest ratio."""
    low = max(_LEAST, min([0.1, *(v.ratio for v in verdicts if v.ratio >= _LEAST)]) / 2.0)
    most, part = max([1.0, *(v.ratio for v in verdicts)]), _LABEL / width
    return low, low * (most / low) ** (1.0 / (1.0 - part))


def _panel(
    axes: Axes, verdicts: Sequence[DcVerdict], quantities: Sequence[str], subsystems: Sequence[str], low: float
) -> None:
    step = 0.84 / len(subsystems)
    for v in verdicts:
        place = subsystems.index(v.subsystem)
        y = quantities.index(v.quantity) + step * (place - (len(subsystems) - 1) / 2)
        marker, colour = _LOOKS[place % len(_LOOKS)]
        nothing = v.ratio < low
        axes.plot([max(v.ratio, low)], [y], linestyle="none", marker="<" if nothing else marker, markersize=5.5,
                  color="white" if nothing else colour, markeredgecolor="black" if v.passed else VERMILION,
                  markeredgewidth=0.7 if v.passed else 1.6, clip_on=False, zorder=4)  # fmt: skip
        if not v.passed:
            axes.plot([1.0, v.ratio], [y, y], color=VERMILION, linewidth=1.0, zorder=3)
            axes.annotate(f"{ratio_text(v.ratio)} FAIL", (v.ratio, y), xytext=(5, 0), textcoords="offset points",
                          fontsize=_SMALL, fontweight="bold", va="center_baseline", zorder=5)  # fmt: skip
    for edge in range(1, len(quantities)):
        axes.axhline(edge - 0.5, color="#B0B0B0", linewidth=0.7)
    axes.axvline(1.0, color="black", linewidth=1.5, zorder=2.5)
    axes.tick_params(axis="y", length=0)
    grid(axes)
    axes.grid(False, axis="y")


def _legend(subsystems: Sequence[str], low_marks: bool) -> list[Line2D]:
    handles = [
        Line2D([], [], linestyle="none", marker=marker, markersize=5.5, color=colour, markeredgecolor="black",
               markeredgewidth=0.7, label=SUBSYSTEM.get(name, name))
        for name, (marker, colour) in zip(subsystems, (_LOOKS[i % len(_LOOKS)] for i in range(len(subsystems))),
                                          strict=True)
    ]  # fmt: skip
    if low_marks:
        handles.append(Line2D([], [], linestyle="none", marker="<", markersize=5.5, color="white",
                              markeredgecolor="black", label="less than 10⁻⁴"))  # fmt: skip
    return handles
