"""Views of a finite-element mesh from outside and cut open, as images of labels; shaded, with their axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.fem.surface import outer_surface
from tedm_cli.figures.drawing.raster import BACKGROUND, Raster, outlines, rasterise

DPI = 150
FINE = 2  # pixels per pixel of the figure, averaged
_LINE_PT, _RIM_PT = 2.2, 1.2  # width of bars, and of the edges of plates
_LIGHT = np.array([-0.30, 0.45, 0.84])  # from above, to the left of the viewer
_AMBIENT = 0.62  # brightness of a face that the light grazes; one that it meets straight has 1
_LINE_SHADE = 0.95  # brightness of lines, which have no side


@dataclass(frozen=True, eq=False, kw_only=True)
class Mesh:
    """A mesh with what its views need.

    position : [N, 3], m. card, node_offset, node_index : the elements, as `outer_surface` takes them, M corners in all.
    boxes : corners [8, 3] of every test mass in binary order, m.
    centre : [3], where sections are cut, m.
    """

    position: FloatArray
    card: Sequence[str]
    node_offset: IntArray
    node_index: IntArray
    boxes: Sequence[FloatArray]
    centre: FloatArray


@dataclass(frozen=True)
class View:
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
PLAN = View("from +z", (1, 0, 0), (0, 1, 0), ("x", "y"))
FRONT = View("from −y", (1, 0, 0), (0, 0, 1), ("x", "z"))
SIDE = View("from +x", (0, 1, 0), (0, 0, 1), ("y", "z"))
ISOMETRIC = View("isometric, from +x, −y, +z", (1, 1, 0), (-1, 1, 2), None)
_NORMAL = {"from +z": 2, "from −y": 1, "from +x": 0}


@dataclass(frozen=True, eq=False)
class Seen:
    """A view: what is at each pixel, the edges of its image (left, right, bottom, top; m), where it is cut, if along an
    axis."""

    view: View
    cut: bool
    raster: Raster
    edge: tuple[float, float, float, float]
    place: float | None


def seen_in(mesh: Mesh, label: IntArray, none: int, view: View, room: FloatArray, *, cut: bool) -> Seen:
    """A view of a mesh.

    Parameters
    ----------
    label : [M], of each corner of each element, -1: none, which is shown as `none`. room : [2], inches.
    """
    frame = view.frame
    elements, place = _section(mesh, view) if cut else (None, None)
    flat = mesh.position @ frame[:2].T
    low, high = flat.min(axis=0), flat.max(axis=0)
    per_m = float(np.min(room / (1.05 * (high - low)))) * DPI * FINE
    width, height = (int(v) for v in np.round(room * DPI * FINE))
    corner, shown, half, shade = _triangles(mesh, label, elements, frame, per_m)
    shift = np.array([width, height]) / 2 - (low + high) / 2 * per_m
    corner[:, :, :2] += shift
    raster = rasterise(corner, np.where(shown < 0, none, shown), half, shade, width, height)
    left, low_edge = -shift / per_m
    return Seen(view, cut, raster, (left, left + width / per_m, low_edge, low_edge + height / per_m), place)


def room_of(axes: Axes) -> FloatArray:
    """Width and height of axes in inches."""
    figure = axes.get_figure()
    assert isinstance(figure, Figure)
    box = axes.get_position()
    return np.asarray(np.array([box.width, box.height]) * figure.get_size_inches())


def show(axes: Axes, mesh: Mesh, seen: Seen, table: FloatArray, *, borders: bool, sizes: tuple[float, float]) -> None:
    """Draw a view with the colour of each label; sizes of the numbers and of the other words in points.

    Parameters
    ----------
    table : RGB [labels, 3]. borders : whether labels have lines between them.
    """
    axes.imshow(_image(seen.raster, table, borders), extent=seen.edge, aspect="equal", interpolation="none")
    for corners in mesh.boxes:
        _outline(axes, corners @ seen.view.frame[:2].T)
    numbers, words = sizes
    view, place = seen.view, seen.place
    axes.tick_params(labelsize=numbers, length=2.5)
    if view.labels is None:
        axes.set_axis_off()
        axes.set(xticks=[], yticks=[])
        axes.set_title("isometric, a quarter cut away" if seen.cut else view.title, fontsize=9)
    else:
        axes.set_xlabel(f"{view.labels[0]} (m)", fontsize=words, labelpad=1)
        axes.set_ylabel(f"{view.labels[1]} (m)", fontsize=words, labelpad=1)
        where = f", cut at {'xyz'[_NORMAL[view.title]]} = {place:.4g} m".replace("-", "−") if seen.cut else ""
        axes.set_title(view.title + where, fontsize=9)


def _section(mesh: Mesh, view: View) -> tuple[IntArray, float | None]:
    """Elements that are left when all in front of a plane through the first test mass are taken away, and its place."""
    centre = mesh.centre
    counts = np.diff(mesh.node_offset)
    middle = np.add.reduceat(mesh.position[mesh.node_index], mesh.node_offset[:-1], axis=0) / counts[:, None]
    if view.title not in _NORMAL:
        # A quarter is taken away: what the plan and the front view leave, together.
        return np.flatnonzero((middle[:, 2] < centre[2]) | (middle[:, 1] > centre[1])), None
    towards = view.frame[2]
    return np.flatnonzero(middle @ towards < centre @ towards), round(float(centre[_NORMAL[view.title]]), 9) + 0.0


def _triangles(
    mesh: Mesh, label: IntArray, elements: IntArray | None, frame: FloatArray, per_m: float
) -> tuple[FloatArray, IntArray, BoolArray, FloatArray]:
    """Corners (pixels and depth), labels, halves and shades of what is drawn of the elements, for `rasterise`."""
    card, offset, index = mesh.card, mesh.node_offset, mesh.node_index
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
    projected = mesh.position @ frame.T * per_m
    corner = projected[rows]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    length = np.linalg.norm(normal, axis=1)
    # Faces of solids that look away are behind others; the second triangle of a triangle has no area.
    seen = (length > 0) & ((normal[:, 2] > 0) | ~np.tile(surface.solid, 2))
    light = np.abs(normal[seen] @ _LIGHT) / length[seen]
    line = np.concatenate([surface.line, surface.rim])  # a plate seen from its edge has no area
    wide = np.repeat([_LINE_PT, _RIM_PT], [len(surface.line), len(surface.rim)]) / 144 * DPI * FINE
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


def _image(raster: Raster, colours: FloatArray, borders: bool) -> FloatArray:
    """RGB [H, W, 3] of a raster, smoothed from its finer pixels."""
    table = np.concatenate([colours, [(1.0, 1.0, 1.0)]])  # the background is the last row
    image = np.take(table, raster.label, axis=0, mode="wrap")
    image *= np.where(raster.label == BACKGROUND, 1.0, raster.shade)[..., None]
    border, step = outlines(raster, jump=4.0 * FINE)
    image[step] *= 0.55
    if borders:
        image[border] = 0.12
    height, width = (n // FINE * FINE for n in raster.label.shape)
    parts = [image[row:height:FINE, column:width:FINE] for row in range(FINE) for column in range(FINE)]
    return np.asarray(sum(parts[1:], start=parts[0]) / len(parts))


def _outline(axes: Axes, corners: FloatArray) -> None:
    """Edges of a cuboid whose corners are in binary order, dashed."""
    for i in range(8):
        for bit in (1, 2, 4):
            if not i & bit:
                pair = corners[[i, i | bit]]
                axes.plot(pair[:, 0], pair[:, 1], color="black", linewidth=0.6, linestyle=(0, (3, 2)), alpha=0.7)
