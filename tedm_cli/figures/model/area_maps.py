"""Maps over thermal areas: areas in rows by group, outputs in columns; a panel and colour scale for each unit."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tedm_cli.arrays import AnyArray, FloatArray, IntArray
from tedm_cli.figures.drawing.cells import draw_cells, is_light, signed_bar, signed_colours, size_bar, size_colours
from tedm_cli.figures.drawing.fit import text_width
from tedm_cli.figures.drawing.pages import BESIDE, CELL, GAP, HEAD, ROW, MapPage
from tedm_cli.figures.drawing.style import SMALL, TITLE, style
from tedm_cli.noise.areas import AreaTable
from tedm_cli.results.wording import number_text, unit_text

_NUMBER = 0.07  # inches beside the widest number of a cell
_SCALE = 1.6  # inches of a colour scale: it has to be read


def map_figure(page: MapPage, areas: AreaTable, title: str) -> Figure:
    """|sensitivity|, one panel and colour scale for each unit."""
    return _figure(page, areas, title, numbers=False)


def noise_map(page: MapPage, areas: AreaTable, title: str) -> Figure:
    """Values with signs and numbers, one panel and colour scale for each unit."""
    return _figure(page, areas, title, numbers=True)


def _figure(page: MapPage, areas: AreaTable, title: str, *, numbers: bool) -> Figure:
    with style():
        left = BESIDE + max(text_width(str(areas.name[i]), SMALL) for rows in page.blocks for i in rows)
        wide = [len(m.labels) * (_number_cell(m.value) if numbers else CELL) for m in page.maps]
        left = max(left, 0.4 + _SCALE - wide[0])  # the scale of the first panel, too
        block = left + sum(wide) + GAP * (len(wide) - 1)
        lines = [_lines(areas, rows) for rows in page.blocks]
        tall = ROW * max(map(len, lines))
        foot = 0.2 + max(text_width(label, SMALL) for m in page.maps for label in m.labels)
        # the scale of the last panel may be wider than the panel
        beside = max(_SCALE - wide[-1], 0.0) if len(lines) == 1 and len(wide) > 1 else 0.0
        width = len(lines) * block + (len(lines) - 1) * GAP + 0.2 + beside
        width = max(width, 0.3 + 1.16 * text_width(title, TITLE))
        height = HEAD + tall + foot
        figure = Figure(figsize=(width, height))
        colours = [signed_colours(m.value) if numbers else size_colours(np.abs(m.value)) for m in page.maps]
        for number, rows in enumerate(lines):
            x, high = number * (block + GAP) + left, ROW * len(rows)
            for panel, m in enumerate(page.maps):
                place = (x / width, (foot + tall - high) / height, wide[panel] / width, high / height)
                axes = figure.add_axes(place)
                value = np.full((len(rows), len(m.labels)), np.nan)
                for line, row in enumerate(rows):
                    if isinstance(row, int):
                        value[line] = m.value[:, row]
                draw_cells(axes, value if numbers else np.abs(value), colours[panel])
                _labels(axes, m.labels, rows if panel == 0 else [], areas, -(left - 0.1) / wide[panel])
                if numbers:
                    _write(axes, value, colours[panel].hex(value))
                if number == 0:
                    scale = max(_SCALE, wide[panel]) if len(wide) < 3 else wide[panel]
                    start = x if panel else x + wide[0] - scale
                    label = f"{m.title} ({unit_text(m.unit)})"
                    bar = signed_bar if numbers else partial(size_bar, least=float(np.abs(m.value).min()))
                    bar(figure, colours[panel], (start, height - HEAD + 0.13, scale), label)
                x += wide[panel] + GAP
        figure.text(0.08 / width, 1 - 0.1 / height, title, fontsize=TITLE, fontweight="bold", va="top")
        return figure


def _number_cell(value: FloatArray) -> float:
    """Width of a cell that holds any of the numbers, inches."""
    return _NUMBER + max(text_width(number_text(float(v)), SMALL) for v in np.unique(value))


def _lines(areas: AreaTable, rows: IntArray) -> list[int | str]:
    """What stands in each line of a block: an area, or the name of the group that begins."""
    lines: list[int | str] = []
    groups = areas.group_by_unit
    for place, row in enumerate(rows):
        if place == 0 or groups[row] != groups[rows[place - 1]]:
            lines.append(str(groups[row]))
        lines.append(int(row))
    return lines


def _labels(axes: Axes, columns: Sequence[str], lines: Sequence[int | str], areas: AreaTable, left: float) -> None:
    """Names of outputs below, of areas and groups on the left; those of groups begin at `left`, of the width."""
    axes.set_xticks(np.arange(len(columns)) + 0.5, columns, rotation=90, fontsize=SMALL)
    named = [(line + 0.5, areas.name[row]) for line, row in enumerate(lines) if isinstance(row, int)]
    axes.set_yticks([y for y, _ in named], [name for _, name in named], fontsize=SMALL)
    axes.tick_params(length=0)
    for line, name in enumerate(lines):
        if isinstance(name, str):
            axes.text(left, line + 0.5, name, transform=axes.get_yaxis_transform(), fontsize=SMALL, fontweight="bold",
                      va="center")  # fmt: skip


def _write(axes: Axes, value: FloatArray, shade: AnyArray) -> None:
    for (row, column), v in np.ndenumerate(value):
        if np.isnan(v):  # the name of a group
            continue
        axes.text(column + 0.5, row + 0.5, number_text(float(v)), fontsize=SMALL, ha="center", va="center_baseline",
                  color="black" if is_light(str(shade[row, column])) else "white")  # fmt: skip
