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

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.fem.surface import outer_surface
from tedm_cli.figures.colours import LEFT_OUT, area_colours
from tedm_cli.figures.gradient_arrows import GradientArrows, arrow_names, draw_arrows
from tedm_cli.figures.raster import BACKGROUND, Raster, outlines, rasterise
from tedm_cli.figures.style import style

_DPI = 150
_FINE = 2  # pixels per pixel of the figure, averaged
_LINE_PT, _RIM_PT = 2.2, 1.2  # width of bars, and of the edges of plates
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
_LIGHT = np.array([-0.30, 0.45, 0.84])  # from above, to the left of the viewer
_AMBIENT = 0.62  # brightness of a face that the light grazes; one that it meets straight has 1
_LINE_SHADE = 0.95  # brightness of lines, which have no side


@dataclass(frozen=True, eq=False)
class AreaModel:
    """What the figure is drawn from.

    position : [N, 3], m; card, node_offset, node_index : the elements, as `outer_surface` takes them.
    label : [M], row of the thermal area of each node of each element, -1: none. name, group : [k].
    gradient : areas under a gradient, which lie over the others.
    boxes : corners [8, 3] of every test mass in binary order, m.
    centre : [3], where sections are cut, m.
    """

    position: FloatArray
    card: Sequence[str]
    node_offset: IntArray
    node_index: IntArray
    label: IntArray
    name: Sequence[str]
    group: Sequence[str]
    boxes: Sequence[FloatArray]
    centre: FloatArray
    gradient: Sequence[GradientArrows] = ()


@dataclass(frozen=True)
class _View:
    """A direction of view: unit vectors to the right, upwards and towards the viewer, with the axes' names."""

    title: str
    right: tuple[float, float, float]
    up: tuple[float, float, float]
    labels: tuple[str, str] | None

    @property
    def frame(self) -> FloatArray:
        r, u = np.array(self.right), np.array(self.up)
        r, u = r / np.linalg.norm(r), u / np.linalg.norm(u)
        return np.array([r, u, np.cross(r, u)])


# Third-angle projection: the plan above the front view, the view from the right on its right.
_PLAN = _View("from +z", (1, 0, 0), (0, 1, 0), ("x", "y"))
_FRONT = _View("from −y", (1, 0, 0), (0, 0, 1), ("x", "z"))
_SIDE = _View("from +x", (0, 1, 0), (0, 0, 1), ("y", "z"))
_ISOMETRIC = _View("isometric, from +x, −y, +z", (1, 1, 0), (-1, 1, 2), None)
_NORMAL = {"from +z": 2, "from −y": 1, "from +x": 0}


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
        figure = Figure(figsize=(_WIDTH, height), dpi=_DPI)
        top, bottom = 1 - 0.65 / height, (key + 0.45) / height
        seen: set[int] = set()
        for half, cut in ((0.0, False), (0.5, True)):
            grid = figure.add_gridspec(
                2, 2, width_ratios=columns, height_ratios=rows, left=half + 0.55 / _WIDTH, right=half + 0.49, top=top,
                bottom=bottom, wspace=0.65 / (scale * np.mean(columns)), hspace=0.55 / (scale * np.mean(rows)),
            )  # fmt: skip
            for view, place in (
                (_PLAN, grid[0, 0]),
                (_FRONT, grid[1, 0]),
                (_SIDE, grid[1, 1]),
                (_ISOMETRIC, grid[0, 1]),
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


def _section(model: AreaModel, view: _View) -> tuple[IntArray, float | None]:
    """Elements that are left when all in front of a plane through the first test mass are taken away, and its place."""
    centre = model.centre
    counts = np.diff(model.node_offset)
    middle = np.add.reduceat(model.position[model.node_index], model.node_offset[:-1], axis=0) / counts[:, None]
    if view.title not in _NORMAL:
        # A quarter is taken away: what the plan and the front view leave, together.
        return np.flatnonzero((middle[:, 2] < centre[2]) | (middle[:, 1] > centre[1])), None
    towards = view.frame[2]
    return np.flatnonzero(middle @ towards < centre @ towards), round(float(centre[_NORMAL[view.title]]), 9) + 0.0


def _triangles(
    model: AreaModel, elements: IntArray | None, frame: FloatArray, per_m: float
) -> tuple[FloatArray, IntArray, BoolArray, FloatArray]:
    """Corners (pixels and depth), labels, halves and shades of what is drawn of the elements, for `rasterise`."""
    card, offset, index, label = model.card, model.node_offset, model.node_index, model.label
    if elements is not None:
        keep = np.zeros(len(card), dtype=bool)
        keep[elements] = True
        counts = np.diff(offset)
        card = [card[i] for i in elements]
        members = np.repeat(keep, counts)
        index, label, offset = index[members], label[members], np.cumsum([0, *counts[elements]])
    surface = outer_surface(card, offset, index)
    rows, at = (np.concatenate([f[:, [1, 2, 0]], f[:, [3, 0, 2]]]) for f in (surface.face, surface.face_at))
    half = np.tile(surface.face[:, 2] != surface.face[:, 3], 2)
    projected = model.position @ frame.T * per_m
    corner = projected[rows]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    length = np.linalg.norm(normal, axis=1)
    # Faces of solids that look away are behind others; the second triangle of a triangle has no area.
    seen = (length > 0) & ((normal[:, 2] > 0) | ~np.tile(surface.solid, 2))
    light = np.abs(normal[seen] @ _LIGHT) / length[seen]
    line = np.concatenate([surface.line, surface.rim])  # a plate seen from its edge has no area
    wide = np.repeat([_LINE_PT, _RIM_PT], [len(surface.line), len(surface.rim)]) / 144 * _DPI * _FINE
    ends = projected[line]
    along = ends[:, 1, :2] - ends[:, 0, :2]
    across = np.column_stack([-along[:, 1], along[:, 0], np.zeros(len(along))])
    across *= (wide / np.maximum(np.linalg.norm(along, axis=1), 1e-9))[:, None]
    quad = np.stack([ends[:, 0] - across, ends[:, 0] + across, ends[:, 1] + across, ends[:, 1] - across], axis=1)
    quad[:, :, 2] += 2.0  # just in front of the plate or solid that the line may lie in
    owner = label[np.concatenate([surface.line_at, surface.rim_at])[:, [0, 0, 1, 1]]]
    return (
        np.concatenate([corner[seen], quad[:, [1, 2, 0]], quad[:, [3, 0, 2]]]),
        np.concatenate([label[at[seen]], owner[:, [1, 2, 0]], owner[:, [3, 0, 2]]]),
        np.concatenate([half[seen], np.ones(2 * len(quad), dtype=bool)]),
        np.concatenate([_AMBIENT + (1.0 - _AMBIENT) * light, np.full(2 * len(quad), _LINE_SHADE)]),
    )


def _draw(axes: Axes, model: AreaModel, view: _View, colours: FloatArray, cut: bool) -> set[int]:
    """Draw one view; the rows of the areas that are seen in it."""
    frame = view.frame
    elements, place = _section(model, view) if cut else (None, None)
    figure = axes.get_figure()
    assert isinstance(figure, Figure)
    box = axes.get_position()
    room = np.array([box.width, box.height]) * figure.get_size_inches()
    flat = model.position @ frame[:2].T
    low, high = flat.min(axis=0), flat.max(axis=0)
    per_m = float(np.min(room / (1.05 * (high - low)))) * _DPI * _FINE
    width, height = (int(v) for v in np.round(room * _DPI * _FINE))
    corner, label, half, shade = _triangles(model, elements, frame, per_m)
    shift = np.array([width, height]) / 2 - (low + high) / 2 * per_m
    corner[:, :, :2] += shift
    # No area is a label of its own, beside the background.
    raster = rasterise(corner, np.where(label < 0, len(model.name), label), half, shade, width, height)
    left, low_edge = -shift / per_m
    edge = (left, left + width / per_m, low_edge, low_edge + height / per_m)
    axes.imshow(_image(raster, colours), extent=edge, aspect="equal", interpolation="none")
    for corners in model.boxes:
        _outline(axes, corners @ frame[:2].T)
    _annotate(axes, model, raster, edge)
    if not cut:
        draw_arrows(axes, model.gradient, frame, float(np.ptp(model.position, axis=0).max()))
    axes.tick_params(labelsize=7.5, length=2.5)
    if view.labels is None:
        axes.set_axis_off()
        axes.set_title("isometric, a quarter cut away" if cut else view.title, fontsize=9)
    else:
        axes.set_xlabel(f"{view.labels[0]} (m)", fontsize=8.5, labelpad=1)
        axes.set_ylabel(f"{view.labels[1]} (m)", fontsize=8.5, labelpad=1)
        where = f", cut at {'xyz'[_NORMAL[view.title]]} = {place:.4g} m".replace("-", "−") if cut else ""
        axes.set_title(view.title + where, fontsize=9)
    return {int(i) for i in np.unique(raster.label) if 0 <= i < len(model.name)}


def _image(raster: Raster, colours: FloatArray) -> FloatArray:
    """RGB [H, W, 3] of a raster, smoothed from its finer pixels."""
    table = np.concatenate([colours, [LEFT_OUT, (1.0, 1.0, 1.0)]])  # the background is the last row
    image = table[raster.label] * np.where(raster.label == BACKGROUND, 1.0, raster.shade)[..., None]
    border, step = outlines(raster, jump=4.0 * _FINE)
    image[step] *= 0.55
    image[border] = 0.12
    height, width = (n // _FINE * _FINE for n in raster.label.shape)
    fine = image[:height, :width].reshape(height // _FINE, _FINE, width // _FINE, _FINE, 3)
    return np.asarray(fine.mean(axis=(1, 3)))


def _outline(axes: Axes, corners: FloatArray) -> None:
    """Edges of a cuboid whose corners are in binary order, dashed."""
    for i in range(8):
        for bit in (1, 2, 4):
            if not i & bit:
                pair = corners[[i, i | bit]]
                axes.plot(pair[:, 0], pair[:, 1], color="black", linewidth=0.6, linestyle=(0, (3, 2)), alpha=0.7)


def _annotate(axes: Axes, model: AreaModel, raster: Raster, edge: Sequence[float]) -> None:
    """Name or number of every area, in the middle of what is seen of it, where it fits."""
    height, width = raster.label.shape
    taken = np.zeros(raster.label.shape, dtype=bool)
    point = _DPI * _FINE / 72
    places = []
    coarse = raster.label[::_FINE, ::_FINE]
    for area, found in enumerate(ndimage.find_objects(coarse + 1, max_label=len(model.name))):
        if found is not None:
            inner = ndimage.distance_transform_edt(np.pad(coarse[found] == area, 1))[1:-1, 1:-1]
            # Where there is about as much room as anywhere, next to the middle.
            roomy, whole = np.argwhere(inner >= _ROOMY * inner.max()), np.argwhere(inner > 0).mean(axis=0)
            y, x = roomy[((roomy - whole) ** 2).sum(axis=1).argmin()]
            row, column = (int(y) + found[0].start) * _FINE, (int(x) + found[1].start) * _FINE
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
