"""The field at rest against its limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from tedm_cli.figures.drawing.fit import line_count, text_width, wrapped
from tedm_cli.figures.drawing.key import key
from tedm_cli.figures.drawing.spec import PAGE_HEIGHT
from tedm_cli.figures.drawing.style import (
    BLUE,
    SMALL,
    VERMILION,
    WIDTH,
    grid,
    heading,
    heading_lines,
    power_of_ten,
    ratio_axis,
    style,
)
from tedm_cli.gravity.requirements import AT_REST_UNITS, DcVerdict
from tedm_cli.results.gravity.field import place_text, symbol
from tedm_cli.results.titles import subsystem_label
from tedm_cli.results.wording import ratio_text

_HEADING = "Field at rest against its limits"
_ROW, _BETWEEN, _FOOT, _GUTTER = 0.46, 0.5, 0.6, 0.15  # inches
_AXIS, _TEXT = 0.25, 0.13  # inches: name of an axis, a line of text
_LEAST = 1e-4  # of the limit: what lies below is as good as nothing
_LABEL = 1.0  # inches beside the last mark
_SHAPES = ("o", "s", "D", "^", "v", "P", "X", "<", ">", "p", "*", "h")
_EDGE: dict[str, Any] = {"markeredgecolor": "black", "markeredgewidth": 0.7, "markersize": 5.5, "linestyle": "none"}


def at_rest_figure(verdicts: Sequence[DcVerdict]) -> Figure:
    """A panel for each test mass and difference, a row for each quantity, a mark for each subsystem.

    The shape of a mark says which subsystem it is of, its colour whether the limit is met. Two panels of the same
    quantities stand side by side.
    """
    with style():
        places = list(dict.fromkeys(v.place for v in verdicts))
        subsystems = list(dict.fromkeys(v.subsystem for v in verdicts))
        of = {place: [v for v in verdicts if v.place == place] for place in places}
        quantities = {p: [q for q in AT_REST_UNITS if any(v.quantity == q for v in of[p])] for p in places}
        rows = _side_by_side(places, quantities)
        columns = max(map(len, rows))
        row = max(_ROW, 0.15 * len(subsystems) / 0.84)
        left = 0.25 + max(text_width(symbol(v.quantity), 9) for v in verdicts)
        wide = (WIDTH - left - 0.15 - _GUTTER * (columns - 1)) / columns
        low, _ = _scale(verdicts, wide)
        titles = {place: _title(place, verdicts, wide) for place in places}
        above = 0.1 + 0.15 * max(map(line_count, titles.values()))
        top = heading_lines(_HEADING, "")[2] + above
        legend = key(_samples(subsystems, verdicts, low), WIDTH - 0.3, sample=1.4)
        between = _BETWEEN if above < 0.3 else _BETWEEN + above
        lines = [len(quantities[line[0]]) for line in rows]
        labelled = [line for line in rows if line is rows[-1] or len(line) != len(rows[-1])]
        around = top + (len(rows) - 1) * between + (len(labelled) - 1) * _AXIS + _FOOT + legend.height
        heights = [min(row, (PAGE_HEIGHT - around) / sum(lines)) * n for n in lines]
        tall = around + sum(heights)
        figure = Figure(figsize=(WIDTH, tall))
        from_top = top
        for line, height in zip(rows, heights, strict=True):
            span = (WIDTH - left - 0.15 - _GUTTER * (len(line) - 1)) / len(line)
            high = _scale(verdicts, span)[1]
            close = 0.84 * height / len(quantities[line[0]]) / len(subsystems) < _TEXT
            for number, place in enumerate(line):
                start = left + number * (span + _GUTTER)
                axes = figure.add_axes((start / WIDTH, 1.0 - (from_top + height) / tall, span / WIDTH, height / tall))
                _panel(axes, of[place], quantities[place], subsystems, low, close)
                axes.set_xscale("log")
                axes.set_xlim(low, high)
                ratio_axis(axes.xaxis, low, high)
                grid(axes)
                axes.grid(False, axis="y")
                axes.tick_params(axis="x", labelsize=SMALL, labelbottom=line in labelled)
                if line in labelled:
                    axes.set_xlabel("|value| / limit (1)", fontsize=9)
                axes.set_title(titles[place], fontsize=9, pad=4)
                axes.set_ylim(len(quantities[place]) - 0.5, -0.5)
                names = [symbol(q) for q in quantities[place]] if number == 0 else []
                axes.set_yticks(range(len(names)), names, fontsize=9)
                axes.tick_params(axis="y", pad=7)
            from_top += height + between + _AXIS * (line in labelled)
        heading(figure, _HEADING)
        legend.draw(figure, 0.15, 0.08)
        return figure


def _side_by_side(places: Sequence[str], quantities: Mapping[str, Sequence[str]]) -> list[list[str]]:
    """Rows of one place or of two with the same quantities."""
    rows: list[list[str]] = []
    for place in places:
        if rows and len(rows[-1]) == 1 and quantities[rows[-1][0]] == quantities[place]:
            rows[-1].append(place)
        else:
            rows.append([place])
    return rows


def _title(place: str, verdicts: Sequence[DcVerdict], wide: float) -> str:
    of_place = [v for v in verdicts if v.place == place]
    return wrapped(f"{place_text(place)}: {sum(v.passed for v in of_place)} of {len(of_place)} within", wide, 9)


def _scale(verdicts: Sequence[DcVerdict], width: float) -> tuple[float, float]:
    """Ends of an axis of `width` inches, with room for a label beside the largest ratio."""
    low = max(_LEAST, min([0.1, *(v.ratio for v in verdicts if v.ratio >= _LEAST)]) / 2.0)
    most, part = max([1.0, *(v.ratio for v in verdicts)]), _LABEL / width
    return low, low * (most / low) ** (1.0 / (1.0 - part))


def _panel(
    axes: Axes,
    verdicts: Sequence[DcVerdict],
    quantities: Sequence[str],
    subsystems: Sequence[str],
    low: float,
    close: bool,
) -> None:
    """One panel; where marks are `close` only the worst of a quantity has its ratio beside it."""
    worst = {q: max(v.ratio for v in verdicts if v.quantity == q) for q in quantities}
    step = 0.84 / len(subsystems)
    for v in verdicts:
        place = subsystems.index(v.subsystem)
        y = quantities.index(v.quantity) + step * (place - (len(subsystems) - 1) / 2)
        colour = "white" if v.ratio < low else BLUE if v.passed else VERMILION
        axes.plot([max(v.ratio, low)], [y], marker=_SHAPES[place % len(_SHAPES)], color=colour, clip_on=False, zorder=4,
                  **_EDGE)  # fmt: skip
        if not v.passed:
            axes.plot([1.0, v.ratio], [y, y], color=VERMILION, linewidth=1.0, zorder=3)
        if not v.passed and (not close or v.ratio == worst[v.quantity]):
            axes.annotate(f"{ratio_text(v.ratio)} FAIL", (v.ratio, y), xytext=(5, 0), textcoords="offset points",
                          fontsize=SMALL, fontweight="bold", va="center_baseline", zorder=5)  # fmt: skip
    for edge in range(1, len(quantities)):
        axes.axhline(edge - 0.5, color="#B0B0B0", linewidth=0.7)
    axes.axvline(1.0, color="black", linewidth=1.5, zorder=2.5)
    axes.tick_params(axis="y", length=0)


def _samples(subsystems: Sequence[str], verdicts: Sequence[DcVerdict], low: float) -> list[Artist]:
    """Shapes in grey, then colours on the first of the shapes."""

    def sample(shape: str, colour: str, label: str) -> Line2D:
        return Line2D([], [], marker=shape, color=colour, label=label, **_EDGE)

    samples: list[Artist] = [
        sample(_SHAPES[i % len(_SHAPES)], "#B0B0B0", subsystem_label(name)) for i, name in enumerate(subsystems)
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
