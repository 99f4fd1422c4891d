"""The optical bench to scale: beams, elements and their names; and the same under a load, motions exaggerated."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch, Polygon
from matplotlib.path import Path

from tedm_cli.arrays import FloatArray
from tedm_cli.figures.drawing.key import key
from tedm_cli.figures.drawing.labels import place_labels
from tedm_cli.figures.drawing.spec import PAGE_WIDTH
from tedm_cli.figures.drawing.style import COLOURS, SMALL, heading, heading_lines, style
from tedm_cli.figures.optics.bench_shapes import (
    ABOVE,
    SIDE,
    Shown,
    View,
    beam_segments,
    each_bench,
    interferometers,
    out_of_plane,
    outline,
    whole,
)
from tedm_cli.optics.bodies import body
from tedm_cli.optics.exaggerated import ExaggeratedBench, TracedBench
from tedm_cli.optics.layout import Beam, Kind, OpticalLayout
from tedm_cli.results.wording import SUPERSCRIPT

SHARED, GHOST, INK = "#4D4D4D", "#B4B4B4", "#000000"
_OWN = (COLOURS[0], COLOURS[1], COLOURS[2], COLOURS[3], COLOURS[5], COLOURS[4])
# Dashes of the beams of each interferometer; of reference beams, which are wide, and of measurement beams.
_REFERENCE: tuple[Any, ...] = ((0, (2.6, 1.3)), (0, (1.0, 1.0)), (0, (2.6, 1.0, 1.0, 1.0)), (0, (4.0, 2.6)))
_MEASUREMENT: tuple[Any, ...] = ("-", (0, (11, 1.5)), (0, (8, 1.5, 1.5, 1.5)), (0, (5, 1.5)))
_HIGH = 5.6  # inches that the view from above may take
_LEFT, _RIGHT, _GAP = 0.68, 0.12, 0.66
_ENDS = ("test_mass", "photodiode", "injector")  # where beams end, or turn back: what the view from the side names
_SIDE, _MOST_STRETCH = 1.6, 6  # inches that heights are stretched to in the view from the side, and how much at most


def tint(colour: str, white: float) -> tuple[float, float, float]:
    """A colour mixed with so much white."""
    r, g, b = (v + white * (1.0 - v) for v in to_rgb(colour))
    return r, g, b


_BEAMS: tuple[tuple[Beam, str], ...] = (("meas", "measurement beam"), ("ref", "reference beam"))
#: Fill, edge, and name of each kind of element.
KINDS: dict[Kind, tuple[Any, str, str]] = {
    "test_mass": (tint(COLOURS[5], 0.7), INK, "test mass"),
    "window": (tint(COLOURS[4], 0.6), COLOURS[0], "window or beam-splitter"),
    "beamsplitter": (tint(COLOURS[4], 0.6), COLOURS[0], "window or beam-splitter"),
    "mirror": (SHARED, INK, "mirror"),
    "injector": (COLOURS[5], INK, "injector"),
    "photodiode": (COLOURS[3], INK, "photodiode"),
}


def bench_figure(layout: OpticalLayout, bench: TracedBench) -> Figure:
    """The bench from above, and from the side where it leaves the plane."""
    with style():
        solid = out_of_plane(layout, bench)
        handles = _beam_handles(layout, bench) + _kind_handles(layout)
        canvas = _Canvas(layout, [bench], _views(layout, solid), handles, layout.title, "")
        for sheet in canvas.sheets:
            _draw_beams(sheet, layout, bench)
            shapes = _draw_bodies(sheet, layout, bench, solid)
            _draw_names(sheet, layout, shapes, [bench])
        _scale_bar(canvas.sheets[0])
        return canvas.figure


def exaggerated_figure(layout: OpticalLayout, benches: ExaggeratedBench, load: str, read_outs: Sequence[str]) -> Figure:
    """The bench before (grey) and after a load whose motions are exaggerated; arrows show how elements move.

    `load` names the load in the title, `read_outs` says what is read, in words.
    """
    with style():
        before, after = benches.before, benches.after
        solid = out_of_plane(layout, before)
        handles = [
            *_beam_handles(layout, before),
            *_kind_handles(layout),
            Line2D([], [], color=GHOST, linewidth=1.2, label="before"),
            Line2D([], [], color=INK, linewidth=1.4, marker=">", markersize=5, label="motion of an element"),
        ]
        title = f"{load}: motions × {factor_text(benches.factor)}"
        views = _views(layout, out_of_plane(layout, after))
        canvas = _Canvas(layout, [before, after], views, handles, title, "\n".join(read_outs))
        for sheet in canvas.sheets:
            _draw_ghost(sheet, layout, before)
            _draw_beams(sheet, layout, after)
            shapes = _draw_bodies(sheet, layout, after, solid or sheet.view is SIDE)
            _draw_arrows(sheet, before, after)
            _draw_names(sheet, layout, shapes, [before, after])
        _scale_bar(canvas.sheets[0], benches.factor)
        return canvas.figure


def _views(layout: OpticalLayout, solid: bool) -> list[tuple[View, Shown]]:
    """All from above; where the layout leaves its plane, each of its benches from the side."""
    return [(ABOVE, whole(layout)), *((SIDE, shown) for shown in each_bench(layout) if solid)]


def factor_text(factor: float) -> str:
    """A factor of exaggeration: `20 000`, `2 × 10⁻³`."""
    if 1.0 <= factor < 1e8:
        return f"{factor:,.0f}".replace(",", "\N{NO-BREAK SPACE}")
    mantissa, exponent = f"{factor:.0e}".split("e")
    return f"{mantissa} × 10{str(int(exponent)).translate(SUPERSCRIPT)}"


def length_text(length_m: float) -> str:
    """A length with the unit that keeps its number small."""
    units = (("m", 1.0), ("mm", 1e-3), ("µm", 1e-6), ("nm", 1e-9), ("pm", 1e-12))
    name, size = next((u for u in units if length_m >= 0.9999 * u[1]), units[-1])
    return f"{length_m / size:.3g} {name}"


@dataclass(frozen=True, eq=False)
class _Sheet:
    """Axes in mm of a view; `per_pt` mm are one point to the right, `stretch` [2] is what one mm is drawn as."""

    axes: Axes
    view: View
    shown: Shown
    per_pt: float
    stretch: FloatArray

    def drawn(self, points_mm: FloatArray) -> FloatArray:
        """Points [..., 2] mm as they are drawn, in mm to the right."""
        return np.asarray(points_mm * self.stretch)

    def data(self, drawn_mm: FloatArray) -> FloatArray:
        """The way back."""
        return np.asarray(drawn_mm / self.stretch)


class _Canvas:
    """A figure with empty sheets of one scale, its heading, and a key below them."""

    def __init__(
        self, layout: OpticalLayout, benches: Sequence[TracedBench], views: Sequence[tuple[View, Shown]],
        handles: Sequence[Artist], title: str, more: str,
    ) -> None:  # fmt: skip
        boxes = []
        for view, shown in views:
            points = [view.flat(body(layout, i, b.poses)) for b in benches for i in shown.elements]
            points += [view.flat(b.beam(i)) for b in benches for i in shown.paths]
            every = np.concatenate(points)
            boxes.append((every.min(axis=0), every.max(axis=0)))
        low, high = (np.array([b[i] for b in boxes]) for i in (0, 1))
        width = float((high - low)[:, 0].max())
        per_inch = max(width / (PAGE_WIDTH - _LEFT - _RIGHT - 1.2), float((high - low)[0, 1]) / (_HIGH - 0.9))
        stretch = np.ones((len(views), 2))
        for i, (view, _) in enumerate(views):
            if view is SIDE:  # a bench is flat: what happens along z is seen where heights are stretched
                tall = max(float((high - low)[i, 1]) / per_inch, 1e-6)
                stretch[i, 1] = float(np.clip(round(_SIDE / tall), 1, _MOST_STRETCH))
        # Margins: names stand beside the outermost elements, and the scale bar below all of them.
        margin = per_inch * np.array([0.6, 0.32]) / stretch
        low, high = low - margin, high + margin
        low[0, 1] -= 0.25 * per_inch
        low[:, 0], high[:, 0] = low[:, 0].min(), high[:, 0].max()
        size = (high - low) * stretch / per_inch
        legend = key(handles, PAGE_WIDTH - 0.3, most=3)
        _, _, head = heading_lines(title, more, PAGE_WIDTH)
        head += 0.2 if len(views) > 1 else 0.05
        total = head + float(size[:, 1].sum()) + _GAP * len(views) + legend.height
        self.figure = Figure(figsize=(PAGE_WIDTH, total))
        self.sheets = []
        top = total - head
        for (view, shown), a, b, (w, h), k in zip(views, low, high, size, stretch, strict=True):
            left = (PAGE_WIDTH + _LEFT - _RIGHT - w) / 2
            axes = self.figure.add_axes((left / PAGE_WIDTH, (top - h) / total, w / PAGE_WIDTH, h / total))
            axes.set(xlim=(a[0], b[0]), ylim=(a[1], b[1]))
            axes.set_xlabel(f"{view.labels[0]} (mm)", labelpad=1)
            axes.set_ylabel(f"{view.labels[1]} (mm)", labelpad=1)
            axes.tick_params(labelsize=SMALL)
            if len(views) > 1:
                stretched = f", {view.labels[1]} stretched × {k[1]:g}, motions along it as well" if k[1] > 1 else ""
                axes.set_title(f"{shown.title} {view.title}".lstrip() + stretched, fontsize=9, pad=3)
            self.sheets.append(_Sheet(axes, view, shown, per_inch / 72, k))
            top -= h + _GAP
        heading(self.figure, title, more=more)
        legend.draw(self.figure, 0.15, 0.08)


def _colour(owner: int) -> str:
    return SHARED if owner < 0 else _OWN[owner % len(_OWN)]


def _line_style(beam: Beam, owner: int) -> dict[str, Any]:
    """Reference beams are wide, light and in dashes, so that they show below a measurement beam on the same line.

    Every interferometer has dashes of its own, and so have the beams that several share: told apart in grey as well.
    """
    colour = _colour(owner)
    if beam == "ref":
        dashes = _REFERENCE[owner % len(_REFERENCE)] if owner >= 0 else (0, (5.2, 1.3))
        return {"edgecolor": tint(colour, 0.4), "linewidth": 3.0, "linestyle": dashes, "capstyle": "butt"}
    dashes = _MEASUREMENT[owner % len(_MEASUREMENT)] if owner >= 0 else "-"
    return {"edgecolor": colour, "linewidth": 1.3 if owner >= 0 else 0.9, "linestyle": dashes, "capstyle": "butt"}


def _beam_handles(layout: OpticalLayout, bench: TracedBench) -> list[Artist]:
    names = [(i, f" to {', '.join(group)}") for i, group in enumerate(interferometers(layout))]
    names += [(-1, ", shared")] if any((s.interferometer < 0).any() for s in beam_segments(layout, bench)) else []
    handles: list[Artist] = []
    for owner, name in names:
        for beam, word in _BEAMS:
            look = _line_style(beam, owner)
            handle = Line2D([], [], color=look["edgecolor"], linewidth=look["linewidth"], linestyle=look["linestyle"])
            handle.set(label=word + name, dash_capstyle="butt")
            handles.append(handle)
    return handles


def _kind_handles(layout: OpticalLayout) -> list[Artist]:
    found: dict[str, Patch] = {}
    for kind, (fill, edge, name) in KINDS.items():
        if any(e.kind == kind for e in layout.elements):
            found.setdefault(name, Patch(facecolor=fill, edgecolor=edge, linewidth=0.8, label=name))
    if any(e.aperture_m is None and e.kind != "test_mass" for e in layout.elements):
        found["assumed"] = Patch(facecolor="none", edgecolor=INK, linestyle=":", label="dotted: size not given")
    return list(found.values())


def _draw_beams(sheet: _Sheet, layout: OpticalLayout, bench: TracedBench) -> None:
    for part in beam_segments(layout, bench, sheet.shown.paths)[::-1]:  # reference beams lie below
        for owner in sorted(set(part.interferometer.tolist())):
            flat = sheet.view.flat(part.points[part.interferometer == owner])
            look = _line_style(part.beam, owner)
            zorder = 2.0 if part.beam == "ref" else 2.2
            sheet.axes.add_artist(
                PathPatch(_path(flat), fill=False, zorder=zorder, label=f"{part.beam} {owner}", **look)
            )
            heads = _arrow_heads(sheet.drawn(flat), sheet.per_pt, 0.38 if part.beam == "ref" else 0.6)
            path = _path([sheet.data(head) for head in heads], closed=True)
            sheet.axes.add_artist(PathPatch(path, facecolor=_colour(owner), edgecolor="none", zorder=2.4))


def _path(pieces: Sequence[FloatArray] | FloatArray, *, closed: bool = False) -> Path:
    """Open or closed pieces as one path: one element of the file in place of many."""
    codes = [code for piece in pieces for code in (Path.MOVETO, *[Path.LINETO] * (len(piece) - 1 + closed))]
    corners = [p for piece in pieces for p in (*piece, *([piece[0]] if closed else ()))]
    return Path(np.array(corners).reshape(-1, 2), codes)


def _arrow_heads(flat: FloatArray, per_pt: float, place: float) -> list[FloatArray]:
    """Triangles [3, 2] that point along those segments that have room for them."""
    heads = []
    for start, end in flat:
        length = float(np.linalg.norm(end - start))
        if length > 26.0 * per_pt:
            way = (end - start) / length
            across = np.array([-way[1], way[0]])
            tip = start + place * (end - start)
            heads.append(np.array([tip, *(tip - 7.0 * per_pt * way + s * 2.7 * per_pt * across for s in (1, -1))]))
    return heads


def _draw_bodies(sheet: _Sheet, layout: OpticalLayout, bench: TracedBench, through: bool) -> list[FloatArray]:
    """Outlines of the elements shown, drawn; `through`: beams are seen through them where one stands before another."""
    shapes = []
    for i in sheet.shown.elements:
        element = layout.elements[i]
        shape = outline(sheet.view.flat(body(layout, i, bench.poses)))
        fill, edge, _ = KINDS[element.kind]
        assumed = element.aperture_m is None and element.kind != "test_mass"
        glass = element.kind in ("window", "beamsplitter")  # beams are seen inside
        if through:
            fill = (*to_rgb(fill), 0.35 if sheet.view is not SIDE or element.kind in _ENDS else 0.08)
        sheet.axes.add_artist(
            Polygon(shape, closed=True, facecolor=fill, edgecolor=edge, linewidth=0.8, label=element.name,
                    linestyle=":" if assumed else "-", zorder=1.8 if glass or through else 2.6)
        )  # fmt: skip
        shapes.append(shape)
    return shapes


def _draw_ghost(sheet: _Sheet, layout: OpticalLayout, bench: TracedBench) -> None:
    parts = beam_segments(layout, bench, sheet.shown.paths)
    beams = np.concatenate([sheet.view.flat(part.points) for part in parts])
    shapes = [outline(sheet.view.flat(body(layout, i, bench.poses))) for i in sheet.shown.elements]
    look: dict[str, Any] = {"fill": False, "edgecolor": GHOST, "linewidth": 0.8}
    sheet.axes.add_artist(PathPatch(_path(beams), zorder=1.2, label="before: beams", **look))
    sheet.axes.add_artist(PathPatch(_path(shapes, closed=True), zorder=1.3, label="before: bodies", **look))


def _draw_arrows(sheet: _Sheet, before: TracedBench, after: TracedBench) -> None:
    start, end = (sheet.view.flat(bench.poses.ref[list(sheet.shown.elements)]) for bench in (before, after))
    moved = np.any(start != end, axis=1)
    if moved.any():
        sheet.axes.quiver(*start[moved].T, *(end - start)[moved].T, angles="xy", scale_units="xy", scale=1.0,
                          units="inches", width=0.018, color=INK, zorder=3.0, headwidth=4.5, headlength=5.5,
                          headaxislength=5.0, minlength=0.5)  # fmt: skip


def _draw_names(
    sheet: _Sheet, layout: OpticalLayout, shapes: Sequence[FloatArray], benches: Sequence[TracedBench]
) -> None:  # fmt: skip
    """Names of the elements; from the side only of those at the ends of beams, since a bench is seen edge-on there."""
    axes, view, per_pt = sheet.axes, sheet.view, sheet.per_pt
    elements = [layout.elements[i] for i in sheet.shown.elements]
    chosen = [i for i, e in enumerate(elements) if view is not SIDE or e.kind in _ENDS]
    # Those that no other can stand in for choose first: photodiodes, then the small, then the large.
    chosen.sort(key=lambda i: (elements[i].kind != "photodiode", float(np.ptp(shapes[i], axis=0).sum())))
    drawn = [sheet.drawn(shape) for shape in shapes]
    parts = [part for bench in benches for part in beam_segments(layout, bench, sheet.shown.paths)]
    lines = sheet.drawn(np.concatenate([view.flat(part.points) for part in parts]))
    corners = sheet.drawn(np.array([axes.get_xlim(), axes.get_ylim()]).T)
    room = corners[0] + 2 * per_pt, corners[1] - 2 * per_pt
    names = [elements[i].name for i in chosen]
    places = place_labels(names, [drawn[i] for i in chosen], drawn, lines, SMALL, per_pt, room)
    for i, name, place in zip(chosen, names, places, strict=True):
        if place.far:
            low_edge, high_edge = drawn[i].min(axis=0), drawn[i].max(axis=0)
            near = np.clip(place.centre, low_edge, high_edge)
            edge = place.centre + np.clip(near - place.centre, -place.half, place.half)
            axes.plot(*sheet.data(np.stack([edge, near])).T, color=INK, linewidth=0.5, zorder=3.5)
        x, y = sheet.data(place.centre)
        axes.text(x, y, name, fontsize=SMALL, ha="center", va="center_baseline", zorder=4.0)


def _scale_bar(sheet: _Sheet, factor: float | None = None) -> None:
    """A length in the lower right corner, and what motion is drawn as long as it."""
    axes, per_pt = sheet.axes, sheet.per_pt
    wide = 110 * per_pt  # at most
    decade = 10.0 ** math.floor(math.log10(wide))
    length = max(m * decade for m in (1, 2, 5) if m * decade <= wide)
    right, low = axes.get_xlim()[1] - 8 * per_pt, axes.get_ylim()[0] + 7 * per_pt
    ends = [right - length, right]
    axes.plot(ends, [low, low], color=INK, linewidth=2.2, solid_capstyle="butt", zorder=4.0, label="scale")
    text = length_text(length * 1e-3)
    if factor is not None:
        text = f"bench {text}, motion {length_text(length * 1e-3 / factor)}"
    axes.text(right, low + 3.5 * per_pt, text, fontsize=SMALL, ha="right", va="bottom", zorder=4.0)
