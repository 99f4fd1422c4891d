"""Figure of a finite-element model coloured by thermal area: views from outside, and sections."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke
from scipy import ndimage

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.figures.drawing.colours import LEFT_OUT, area_colours
from tedm_cli.figures.drawing.raster import BACKGROUND, Raster
from tedm_cli.figures.drawing.style import style
from tedm_cli.figures.model.gradient_arrows import GradientArrows, arrow_names, draw_arrows
from tedm_cli.figures.model.views import (
    DPI,
    FINE,
    FRONT,
    ISOMETRIC,
    PLAN,
    SIDE,
    Mesh,
    View,
    room_of,
    seen_in,
    show,
)

_WIDTH = 15.0  # inches of the drawings
_NAME_PT, _NUMBER_PT = 5.6, 6.4
# Half the box of a line of DejaVu Sans, by its size: characters of names are 0.6 wide on average, capitals 0.73 high;
# the rest of the height is margin.
_HALF_WIDTH, _HALF_HEIGHT = 0.31, 0.42
# Part of that box that must lie on the area itself (of a number: or on the background) for it to be written there.
_NAME_INSIDE, _NUMBER_INSIDE = 0.98, 0.6
_ROOMY = 0.75  # of the largest distance to an area's edge: from here on, places count as equally good for its name
_KEY_PT = 7.2
_GRADIENTS = "gradients"
_KEY_ROW = 0.13  # inches


@dataclass(frozen=True, eq=False, kw_only=True)
class AreaModel(Mesh):
    """What the figure is drawn from.

    label : [M], row of the thermal area of each node of each element, -1: none. name, group : [k].
    gradient : areas under a gradient, which lie over the others.
    """

    label: IntArray
    name: Sequence[str]
    group: Sequence[str]
    gradient: Sequence[GradientArrows] = ()


def area_figure(model: AreaModel, title: str) -> Figure:
    """Four views from outside, the same cut through the first test mass, and a key of all areas by group."""
    with style():
        colours = area_colours(model.group, _neighbours(model))
        extent = np.ptp(model.position, axis=0)
        most = 0.3 * extent.max()
        columns = [max(extent[0], most), max(extent[1], most)]
        rows = [max(extent[1], most), max(extent[2], most)]
        scale = (_WIDTH / 2 - 1.3) / sum(columns)  # inches per metre
        key = _KEY_ROW * (2 + max(len(c) for c in _key_columns(model, set())))
        drawings = scale * sum(rows) + 1.1
        height = 0.5 + drawings + key
        figure = Figure(figsize=(_WIDTH, height), dpi=DPI)
        top, bottom = 1 - 0.65 / height, (key + 0.45) / height
        seen: set[int] = set()
        for half, cut in ((0.0, False), (0.5, True)):
            grid = figure.add_gridspec(
                2, 2, width_ratios=columns, height_ratios=rows, left=half + 0.55 / _WIDTH, right=half + 0.49, top=top,
                bottom=bottom, wspace=0.65 / (scale * np.mean(columns)), hspace=0.55 / (scale * np.mean(rows)),
            )  # fmt: skip
            for view, place in (
                (PLAN, grid[0, 0]),
                (FRONT, grid[1, 0]),
                (SIDE, grid[1, 1]),
                (ISOMETRIC, grid[0, 1]),
            ):
                seen |= _draw(figure.add_subplot(place), model, view, colours, cut)
        figure.text(0.012, 1 - 0.12 / height, title, fontsize=11.5, fontweight="bold", va="top")
        _key(figure, model, colours, seen)
        return figure


def _neighbours(model: AreaModel) -> set[tuple[int, int]]:
    """Pairs of areas, lower row first, that share an element."""
    element = np.repeat(np.arange(len(model.card)), np.diff(model.node_offset))
    pairs = np.unique(np.column_stack([element, model.label]), axis=0)
    first = np.flatnonzero(np.diff(pairs[:, 0], prepend=-1))
    found: set[tuple[int, int]] = set()
    for members in np.split(pairs[:, 1], first[1:]):
        if len(members) > 1:
            found |= {(int(a), int(b)) for i, a in enumerate(members) for b in members[i + 1 :] if a >= 0}
    return found


def _draw(axes: Axes, model: AreaModel, view: View, colours: FloatArray, cut: bool) -> set[int]:
    """Draw one view; the rows of the areas that are seen in it."""
    seen = seen_in(model, model.label, len(model.name), view, room_of(axes), cut=cut)
    show(axes, model, seen, np.concatenate([colours, [LEFT_OUT]]), borders=True, sizes=(7.5, 8.5))
    _annotate(axes, model, seen.raster, seen.edge)
    if not cut:
        draw_arrows(axes, model.gradient, view.frame, float(np.ptp(model.position, axis=0).max()))
    return {int(i) for i in np.unique(seen.raster.label) if 0 <= i < len(model.name)}


def _annotate(axes: Axes, model: AreaModel, raster: Raster, edge: Sequence[float]) -> None:
    """Name or number of every area, in the middle of what is seen of it, where it fits."""
    height, width = raster.label.shape
    taken = np.zeros(raster.label.shape, dtype=bool)
    point = DPI * FINE / 72
    places = []
    coarse = raster.label[::FINE, ::FINE]
    for area, found in enumerate(ndimage.find_objects(coarse + 1, max_label=len(model.name))):
        if found is not None:
            inner = ndimage.distance_transform_edt(np.pad(coarse[found] == area, 1))[1:-1, 1:-1]
            # Where there is about as much room as anywhere, next to the middle.
            roomy, whole = np.argwhere(inner >= _ROOMY * inner.max()), np.argwhere(inner > 0).mean(axis=0)
            y, x = roomy[((roomy - whole) ** 2).sum(axis=1).argmin()]
            row, column = (int(y) + found[0].start) * FINE, (int(x) + found[1].start) * FINE
            places.append((-float(inner.max()), area, row, column))
    for _, area, row, column in sorted(places):  # those with most room first
        name, number = model.name[area], str(area + 1)
        # A name must lie inside its area; a number may hang over the outline of the model, as areas are often thinner.
        for text, size, need, ground in (
            (name, _NAME_PT, _NAME_INSIDE, area),
            (number, _NUMBER_PT, _NUMBER_INSIDE, BACKGROUND),
        ):
            wide = int(_HALF_WIDTH * size * point * len(text)) + 2
            high = int(_HALF_HEIGHT * size * point) + 1
            rows, columns = slice(max(row - high, 0), row + high), slice(max(column - wide, 0), column + wide)
            under = raster.label[rows, columns]
            if ((under == area) | (under == ground)).mean() < need or taken[rows, columns].any():
                continue
            taken[rows, columns] = True
            u = edge[0] + (column + 0.5) / width * (edge[1] - edge[0])
            v = edge[3] - (row + 0.5) / height * (edge[3] - edge[2])
            axes.text(u, v, text, fontsize=size, ha="center", va="center_baseline",
                      path_effects=[withStroke(linewidth=1.6, foreground="white", alpha=0.85)])  # fmt: skip
            break


def _key_columns(model: AreaModel, seen: set[int]) -> list[list[tuple[int | None, str]]]:
    """The key, column by column: a group's name (None), then its areas; a star marks those that no view shows.

    Areas under a gradient have no colour, and a row of -1.
    """
    names = [*model.name, *(area.name for area in model.gradient)]
    most = max(1, min(7, int(_WIDTH / (0.55 + 0.066 * max(len(name) for name in names)))))
    parts: dict[str, list[tuple[int | None, str]]] = {}
    for i, (name, group) in enumerate(zip(model.name, model.group, strict=True)):
        parts.setdefault(group, []).append((i, f"{i + 1}  {name}{'' if i in seen else ' *'}"))
    for short, area in zip(arrow_names(model.gradient), model.gradient, strict=True):
        parts.setdefault(_GRADIENTS, []).append((-1, f"{short}  {area.name}"))
    rows = max(2, -(-(len(names) + 2 * len(parts)) // most))
    columns: list[list[tuple[int | None, str]]] = [[]]
    for group, lines in parts.items():
        if len(columns[-1]) > rows - 2:  # room for the group's name and one area
            columns.append([])
        columns[-1].append((None, group))
        for line in lines:
            if len(columns[-1]) == rows:
                columns.append([])
            columns[-1].append(line)
    return columns


def _key(figure: Figure, model: AreaModel, colours: FloatArray, seen: set[int]) -> None:
    """Names of all areas with their numbers and colours, group by group."""
    columns = _key_columns(model, seen)
    rows = max(len(c) for c in columns)
    axes = figure.add_axes((0.0, 0.0, 1.0, (rows + 2) * _KEY_ROW / figure.get_size_inches()[1]))
    axes.set(xlim=(0.0, _WIDTH), ylim=(rows + 1.5, -0.5))
    axes.set_axis_off()
    for column, lines in enumerate(columns):
        x = 0.2 + column * (_WIDTH - 0.2) / max(len(columns), 4)
        for y, (area, text) in enumerate(lines):
            if area is None:
                axes.text(x, y, text, fontsize=8.5, fontweight="bold", va="center")
                continue
            if area < 0:
                axes.text(x, y, text, fontsize=_KEY_PT, va="center")
                continue
            axes.add_patch(Rectangle((x, y - 0.36), 0.2, 0.72, fc=colours[area], ec="black", linewidth=0.4))
            axes.text(x + 0.27, y, text, fontsize=_KEY_PT, va="center")
    notes = ["dashed: test masses"]
    notes += ["arrows: gradients, to the warm side"] if model.gradient else []
    notes += ["* in no view"] if len(seen) < len(model.name) else []
    notes += ["magenta: grids in no area"] if (model.label < 0).any() else []
    axes.text(0.2, rows + 0.6, "; ".join(notes), fontsize=_KEY_PT, va="center")
