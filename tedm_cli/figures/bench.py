"""The optical bench to scale: beams, elements and their names; and the same under a load, motions exaggerated."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch, Polygon
from matplotlib.path import Path

from tedm_cli.arrays import FloatArray
from tedm_cli.figures.bench_shapes import (
    ABOVE,
    SIDE,
    View,
    beam_segments,
    interferometers,
    out_of_plane,
    outline,
)
from tedm_cli.figures.labels import place_labels
from tedm_cli.figures.style import COLOURS, style
from tedm_cli.optics.bodies import body
from tedm_cli.optics.exaggerated import ExaggeratedBench, TracedBench
from tedm_cli.optics.layout import Kind, OpticalLayout
from tedm_cli.results.wording import SUPERSCRIPT

SHARED, GHOST, INK = "#4D4D4D", "#B4B4B4", "#000000"
_OWN = (COLOURS[0], COLOURS[1], COLOURS[2], COLOURS[3], COLOURS[5], COLOURS[4])
_DASH = (0, (2.6, 1.3))
_NAME_PT = 7.5
_WIDE, _HIGH = 9.5, 7.5  # inches that the views may take
_LEFT, _RIGHT, _GAP, _TOP = 0.62, 0.15, 0.62, 0.5
_LEGEND_ROW, _LEGEND_COLUMNS = 0.185, 3


def tint(colour: str, white: float) -> tuple[float, float, float]:
    """A colour mixed with so much white."""
    r, g, b = (v + white * (1.0 - v) for v in to_rgb(colour))
    return r, g, b


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
        views = [ABOVE, SIDE] if solid else [ABOVE]
        handles = _beam_handles(layout) + _kind_handles(layout)
        figure, panels, per_pt = _canvas(layout, [bench], views, handles)
        for axes, view in zip(panels, views, strict=True):
            _draw_beams(axes, layout, bench, view, per_pt)
            shapes = _draw_bodies(axes, layout, bench, view, solid)
            _draw_names(axes, layout, shapes, [bench], view, per_pt)
        _scale_bar(panels[0], per_pt)
        _title(figure, layout.title)
        return figure


def exaggerated_figure(layout: OpticalLayout, benches: ExaggeratedBench, load: str, read_outs: Sequence[str]) -> Figure:
    """The bench before (grey) and after a load whose motions are exaggerated; arrows show how elements move.

    `load` names the load in the title, `read_outs` says what is read, in words.
    """
    with style():
        before, after = benches.before, benches.after
        solid = out_of_plane(layout, before)
        views = [ABOVE, SIDE] if out_of_plane(layout, after) else [ABOVE]
        handles = [
            *_beam_handles(layout),
            *_kind_handles(layout),
            Line2D([], [], color=GHOST, linewidth=1.2, label="before"),
            Line2D([], [], color=INK, linewidth=1.4, marker=">", markersize=5, label="motion of an element"),
        ]
        figure, panels, per_pt = _canvas(layout, [before, after], views, handles, head=0.2 * (1 + len(read_outs)))
        for axes, view in zip(panels, views, strict=True):
            _draw_ghost(axes, layout, before, view)
            _draw_beams(axes, layout, after, view, per_pt)
            shapes = _draw_bodies(axes, layout, after, view, solid or view is SIDE)
            _draw_arrows(axes, before, after, view)
            _draw_names(axes, layout, shapes, [before, after], view, per_pt)
        _scale_bar(panels[0], per_pt, benches.factor)
        _title(figure, f"{load}: motions × {factor_text(benches.factor)}", *read_outs)
        return figure


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


def _canvas(
    layout: OpticalLayout, benches: Sequence[TracedBench], views: Sequence[View], handles: Sequence[Any],
    head: float = 0.0,
) -> tuple[Figure, list[Axes], float]:  # fmt: skip
    """Empty panels of one scale with a legend below them; also millimetres in one point."""
    boxes = []
    for view in views:
        points = [view.flat(body(layout, i, b.poses)) for b in benches for i in range(len(layout.elements))]
        points += [view.flat(b.beam(i)) for b in benches for i in range(len(layout.paths))]
        every = np.concatenate(points)
        boxes.append((every.min(axis=0), every.max(axis=0)))
    # Margins: names stand beside the outermost elements, and the scale bar below all of them.
    low, high = (np.array([b[i] for b in boxes]) for i in (0, 1))
    width = float((high - low)[:, 0].max())
    per_inch = max(width / (_WIDE - 1.0), float((high - low)[:, 1].sum()) / (_HIGH - 0.9 * len(views)))
    low -= per_inch * np.array([0.5, 0.3])
    high += per_inch * np.array([0.5, 0.3])
    low[0, 1] -= 0.25 * per_inch
    low[:, 0], high[:, 0] = low[:, 0].min(), high[:, 0].max()
    size = (high - low) / per_inch
    rows = -(-len(handles) // _LEGEND_COLUMNS)
    foot = 0.55 + rows * _LEGEND_ROW + 0.12
    total = _TOP + head + float(size[:, 1].sum()) + _GAP * (len(views) - 1) + foot
    wide = max(_LEFT + float(size[0, 0]) + _RIGHT, 8.6)
    figure = Figure(figsize=(wide, total))
    panels = []
    top = total - _TOP - head
    for view, a, b, (w, h) in zip(views, low, high, size, strict=True):
        axes = figure.add_axes((_LEFT / wide, (top - h) / total, w / wide, h / total))
        axes.set(xlim=(a[0], b[0]), ylim=(a[1], b[1]))
        axes.set_aspect("equal", adjustable="box")
        axes.set_xlabel(f"{view.labels[0]} (mm)", labelpad=1)
        axes.set_ylabel(f"{view.labels[1]} (mm)", labelpad=1)
        axes.tick_params(labelsize=8)
        if len(views) > 1:
            axes.set_title(view.title, fontsize=9, pad=3)
        panels.append(axes)
        top -= h + _GAP
    figure.legend(handles=handles, loc="lower left", ncols=_LEGEND_COLUMNS, bbox_to_anchor=(0.04, 0.0),
                  handlelength=2.6, columnspacing=1.6, labelspacing=0.35)  # fmt: skip
    return figure, panels, per_inch / 72


def _colour(owner: int) -> str:
    return SHARED if owner < 0 else _OWN[owner % len(_OWN)]


def _line_style(beam: str, colour: str) -> dict[str, Any]:
    """Reference beams are wide, light and dashed, so that they show below a measurement beam on the same line."""
    if beam == "ref":
        return {"edgecolor": tint(colour, 0.4), "linewidth": 3.0, "linestyle": _DASH, "capstyle": "butt"}
    return {"edgecolor": colour, "linewidth": 1.3, "linestyle": "-", "capstyle": "round"}


def _beam_handles(layout: OpticalLayout) -> list[Line2D]:
    groups = interferometers(layout)
    names = [(i, f" to {', '.join(group)}") for i, group in enumerate(groups)]
    names += [(-1, ", shared")] if len(groups) > 1 else []
    handles = []
    for owner, name in names:
        for beam, word in (("meas", "measurement beam"), ("ref", "reference beam")):
            look = _line_style(beam, _colour(owner))
            handle = Line2D([], [], color=look["edgecolor"], linewidth=look["linewidth"], linestyle=look["linestyle"])
            handle.set(label=word + name, dash_capstyle="butt")
            handles.append(handle)
    return handles


def _kind_handles(layout: OpticalLayout) -> list[Patch]:
    found: dict[str, Patch] = {}
    for kind, (fill, edge, name) in KINDS.items():
        if any(e.kind == kind for e in layout.elements):
            found.setdefault(name, Patch(facecolor=fill, edgecolor=edge, linewidth=0.8, label=name))
    if any(e.aperture_m is None and e.kind != "test_mass" for e in layout.elements):
        found["assumed"] = Patch(facecolor="none", edgecolor=INK, linestyle=":", label="dotted: size not given")
    return list(found.values())


def _draw_beams(axes: Axes, layout: OpticalLayout, bench: TracedBench, view: View, per_pt: float) -> None:
    for part in beam_segments(layout, bench)[::-1]:  # reference beams lie below
        for owner in sorted(set(part.interferometer.tolist())):
            flat = view.flat(part.points[part.interferometer == owner])
            look = _line_style(part.beam, _colour(owner))
            zorder = 2.0 if part.beam == "ref" else 2.2
            axes.add_artist(PathPatch(_path(flat), fill=False, zorder=zorder, label=f"{part.beam} {owner}", **look))
            heads = _path(_arrow_heads(flat, per_pt, 0.38 if part.beam == "ref" else 0.6), closed=True)
            axes.add_artist(PathPatch(heads, facecolor=_colour(owner), edgecolor="none", zorder=2.4))


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


def _draw_bodies(axes: Axes, layout: OpticalLayout, bench: TracedBench, view: View, through: bool) -> list[FloatArray]:
    """Outlines of all elements, drawn; `through`: beams are seen through them, where one stands before the other."""
    shapes = []
    for i, element in enumerate(layout.elements):
        shape = outline(view.flat(body(layout, i, bench.poses)))
        fill, edge, _ = KINDS[element.kind]
        assumed = element.aperture_m is None and element.kind != "test_mass"
        glass = element.kind in ("window", "beamsplitter")  # beams are seen inside
        if through:
            fill = (*to_rgb(fill), 0.35)
        axes.add_artist(Polygon(shape, closed=True, facecolor=fill, edgecolor=edge, linewidth=0.8, label=element.name,
                               linestyle=":" if assumed else "-", zorder=1.8 if glass else 2.6))  # fmt: skip
        shapes.append(shape)
    return shapes


def _draw_ghost(axes: Axes, layout: OpticalLayout, bench: TracedBench, view: View) -> None:
    beams = np.concatenate([view.flat(part.points) for part in beam_segments(layout, bench)])
    shapes = [outline(view.flat(body(layout, i, bench.poses))) for i in range(len(layout.elements))]
    look: dict[str, Any] = {"fill": False, "edgecolor": GHOST, "linewidth": 0.8}
    axes.add_artist(PathPatch(_path(beams), zorder=1.2, label="before: beams", **look))
    axes.add_artist(PathPatch(_path(shapes, closed=True), zorder=1.3, label="before: bodies", **look))


def _draw_arrows(axes: Axes, before: TracedBench, after: TracedBench, view: View) -> None:
    start, end = view.flat(before.poses.ref), view.flat(after.poses.ref)
    moved = np.any(start != end, axis=1)
    if moved.any():
        axes.quiver(*start[moved].T, *(end - start)[moved].T, angles="xy", scale_units="xy", scale=1.0, units="inches",
                    width=0.018, color=INK, zorder=3.0, headwidth=4.5, headlength=5.5, headaxislength=5.0,
                    minlength=0.5)  # fmt: skip


def _draw_names(
    axes: Axes, layout: OpticalLayout, shapes: Sequence[FloatArray], benches: Sequence[TracedBench], view: View,
    per_pt: float,
) -> None:  # fmt: skip
    """Names of all elements; from the side only of those at the ends of beams, since a bench is seen edge-on there."""
    chosen = [i for i, e in enumerate(layout.elements)
              if view is not SIDE or e.kind in ("test_mass", "photodiode", "injector")]  # fmt: skip
    # Those that no other can stand in for choose first: photodiodes, then the small, then the large.
    chosen.sort(key=lambda i: (layout.elements[i].kind != "photodiode", float(np.ptp(shapes[i], axis=0).sum())))
    lines = np.concatenate([view.flat(s.points) for bench in benches for s in beam_segments(layout, bench)])
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    room = np.array([left, low]) + 2 * per_pt, np.array([right, high]) - 2 * per_pt
    names = [layout.elements[i].name for i in chosen]
    places = place_labels(names, [shapes[i] for i in chosen], shapes, lines, _NAME_PT, per_pt, room)
    for i, name, place in zip(chosen, names, places, strict=True):
        if place.far:
            low_edge, high_edge = shapes[i].min(axis=0), shapes[i].max(axis=0)
            near = np.clip(place.centre, low_edge, high_edge)
            edge = place.centre + np.clip(near - place.centre, -place.half, place.half)
            axes.plot(*np.stack([edge, near]).T, color=INK, linewidth=0.5, zorder=3.5)
        x, y = place.centre
        axes.text(x, y, name, fontsize=_NAME_PT, ha="center", va="center_baseline", zorder=4.0)


def _scale_bar(axes: Axes, per_pt: float, factor: float | None = None) -> None:
    """A length in the lower right corner, and what motion is drawn as long as it."""
    wide = 110 * per_pt  # at most
    decade = 10.0 ** math.floor(math.log10(wide))
    length = max(m * decade for m in (1, 2, 5) if m * decade <= wide)
    right, low = axes.get_xlim()[1] - 8 * per_pt, axes.get_ylim()[0] + 7 * per_pt
    ends = [right - length, right]
    axes.plot(ends, [low, low], color=INK, linewidth=2.2, solid_capstyle="butt", zorder=4.0, label="scale")
    text = length_text(length * 1e-3)
    if factor is not None:
        text = f"bench {text}, motion {length_text(length * 1e-3 / factor)}"
    axes.text(right, low + 3.5 * per_pt, text, fontsize=8, ha="right", va="bottom", zorder=4.0)


def _title(figure: Figure, first: str, *others: str) -> None:
    height = figure.get_size_inches()[1]
    figure.text(0.012, 1 - 0.1 / height, first, fontsize=11.5, fontweight="bold", va="top")
    for row, text in enumerate(others):
        figure.text(0.012, 1 - (0.36 + 0.2 * row) / height, text, fontsize=9, va="top")
