"""The field at rest against its allocations."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from tedm_cli.figures.fit import line_count, text_width, wrapped
from tedm_cli.figures.key import key
from tedm_cli.figures.style import (
    BLUE,
    SMALL,
    VERMILION,
    WIDTH,
    grid,
    heading,
    heading_lines,
    inches,
    power_of_ten,
    ratio_axis,
    style,
)
from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.results.field import SUBSYSTEM, symbol
from tedm_cli.results.wording import ratio_text

_HEADING = "Field at rest against its allocation"
_ROW, _BETWEEN, _FOOT = 0.46, 0.5, 0.6  # inches
_LEAST = 1e-4  # of the limit: what lies below is as good as nothing
_LABEL = 1.0  # inches beside the last mark
_SHAPES = ("o", "s", "D", "^", "v", "P")
_EDGE: dict[str, Any] = {"markeredgecolor": "black", "markeredgewidth": 0.7, "markersize": 5.5, "linestyle": "none"}


def at_rest_figure(verdicts: Sequence[DcVerdict]) -> Figure:
    """A panel for each test mass, a row for each quantity, a mark for each subsystem.

    The shape of a mark says which subsystem it is of, its colour whether the allocation is met.
    """
    with style():
        masses = list(dict.fromkeys(v.test_mass for v in verdicts))
        quantities = list(dict.fromkeys(v.quantity for v in verdicts))
        subsystems = list(dict.fromkeys(v.subsystem for v in verdicts))
        columns = min(2, len(masses))
        rows = math.ceil(len(masses) / columns)
        row = max(_ROW, 0.15 * len(subsystems) / 0.84)
        panel = row * len(quantities)
        left = 0.25 + max(text_width(symbol(q), 9) for q in quantities)
        wide = (WIDTH - left - 0.15 - 0.15 * (columns - 1)) / columns
        low, high = _scale(verdicts, wide)
        titles = {mass: _title(mass, verdicts, wide) for mass in masses}
        above = 0.1 + 0.15 * max(map(line_count, titles.values()))
        top = heading_lines(_HEADING, "")[2] + above
        legend = key(_samples(subsystems, verdicts, low), WIDTH - 0.3, sample=1.4)
        between = _BETWEEN if above < 0.3 else _BETWEEN + above
        figure = Figure(figsize=(WIDTH, top + rows * panel + (rows - 1) * between + _FOOT + legend.height))
        panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).reshape(-1)
        inches(figure, left=left, right=0.15, top=top, bottom=_FOOT + legend.height, wspace=0.15 / wide)
        figure.subplots_adjust(hspace=between / panel)
        for number, (axes, mass) in enumerate(zip(panels, masses, strict=False)):
            axes.tick_params(axis="y", pad=7)
            _panel(axes, [v for v in verdicts if v.test_mass == mass], quantities, subsystems, low)
            axes.set_xscale("log")
            axes.set_xlim(low, high)
            ratio_axis(axes.xaxis, low, high)
            axes.tick_params(axis="x", labelsize=SMALL, labelbottom=number + columns >= len(masses))
            if number + columns >= len(masses):
                axes.set_xlabel("|value| / limit of its allocation (1)", fontsize=9)
            axes.set_title(titles[mass], fontsize=9, pad=4)
        panels[0].set_ylim(len(quantities) - 0.5, -0.5)
        panels[0].set_yticks(range(len(quantities)), [symbol(q) for q in quantities], fontsize=9)
        for axes in panels[len(masses) :]:
            axes.set_visible(False)
        heading(figure, _HEADING)
        legend.draw(figure, 0.15, 0.08)
        return figure


def _title(mass: str, verdicts: Sequence[DcVerdict], wide: float) -> str:
    of_mass = [v for v in verdicts if v.test_mass == mass]
    return wrapped(f"{mass}: {sum(v.passed for v in of_mass)} of {len(of_mass)} within", wide, 9)


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
        colour = "white" if v.ratio < low else BLUE if v.passed else VERMILION
        axes.plot([max(v.ratio, low)], [y], marker=_SHAPES[place % len(_SHAPES)], color=colour, clip_on=False, zorder=4,
                  **_EDGE)  # fmt: skip
        if not v.passed:
            axes.plot([1.0, v.ratio], [y, y], color=VERMILION, linewidth=1.0, zorder=3)
            axes.annotate(f"{ratio_text(v.ratio)} FAIL", (v.ratio, y), xytext=(5, 0), textcoords="offset points",
                          fontsize=SMALL, fontweight="bold", va="center_baseline", zorder=5)  # fmt: skip
    for edge in range(1, len(quantities)):
        axes.axhline(edge - 0.5, color="#B0B0B0", linewidth=0.7)
    axes.axvline(1.0, color="black", linewidth=1.5, zorder=2.5)
    axes.tick_params(axis="y", length=0)
    grid(axes)
    axes.grid(False, axis="y")


def _samples(subsystems: Sequence[str], verdicts: Sequence[DcVerdict], low: float) -> list[Artist]:
    """Shapes in grey, then colours on the first of the shapes."""

    def sample(shape: str, colour: str, label: str) -> Line2D:
        return Line2D([], [], marker=shape, color=colour, label=label, **_EDGE)

    samples: list[Artist] = [
        sample(_SHAPES[i % len(_SHAPES)], "#B0B0B0", SUBSYSTEM.get(name, name)) for i, name in enumerate(subsystems)
    ]
    seen = [v for v in verdicts if v.ratio >= low]
    if any(v.passed for v in seen):
        samples.append(Patch(facecolor=BLUE, edgecolor="black", linewidth=0.7, label="within"))
    if any(not v.passed for v in seen):
        samples.append(Patch(facecolor=VERMILION, edgecolor="black", linewidth=0.7, label="outside (FAIL)"))
    if len(seen) < len(verdicts):
        label = f"less than {power_of_ten(_LEAST)}"
        samples.append(Patch(facecolor="white", edgecolor="black", linewidth=0.7, label=label))
    return samples
