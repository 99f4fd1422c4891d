"""What can be read in a drawn figure: texts with their boxes, entries of keys, and cells of maps."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex, to_rgba
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from tedm_cli.figures.drawing.spec import PAGE_HEIGHT, PAGE_WIDTH
from tedm_cli.figures.drawing.style import SMALL, style


def drawn(figure: Figure) -> Figure:
    """The figure, with its texts in their places."""
    with style():
        FigureCanvasAgg(figure).draw()
    return figure


def shown_texts(figure: Figure) -> list[Text]:
    """Texts of a drawn figure that are seen: also those of ticks inside the axes, of legends, titles and labels."""
    hidden: set[int] = set()
    for axes in figure.axes:
        whole = not axes.get_visible()
        for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
            ends = sorted((low, high))
            for tick in [*axis.get_major_ticks(), *axis.get_minor_ticks()]:
                outside = not ends[0] <= tick.get_loc() <= ends[1]
                for label in (tick.label1, tick.label2):
                    if outside or not label.get_visible():
                        hidden.add(id(label))
        if whole:
            hidden |= {id(t) for t in axes.findobj(Text)}
    found = [t for t in figure.findobj(Text) if t.get_visible() and t.get_text().strip() and id(t) not in hidden]
    return list({id(t): t for t in found}.values())


def texts(figure: Figure) -> list[tuple[str, Bbox]]:
    """Texts of a drawn figure with their boxes in pixels."""
    return [(t.get_text(), t.get_window_extent()) for t in shown_texts(figure)]


def overlaps(figure: Figure) -> list[tuple[str, str]]:
    """Pairs of texts of a drawn figure whose boxes share more than a hair."""
    boxes = texts(figure)
    hair_x, hair_y = figure.dpi / 72, 2.0 * figure.dpi / 72  # points; lines of type leave more room than that above
    low, high = (np.array([[getattr(b, f"{c}{end}") for c in "xy"] for _, b in boxes]) for end in "01")
    order = np.argsort(low[:, 1])
    bad = []
    for place, i in enumerate(order):
        for j in order[place + 1 :]:
            if low[j, 1] > high[i, 1]:
                break
            wide, tall = np.minimum(high[i], high[j]) - np.maximum(low[i], low[j])
            if wide > hair_x and tall > hair_y:
                bad.append((boxes[i][0], boxes[j][0]))
    return bad


def faults(figure: Figure) -> list[str]:
    """What is wrong with a drawn figure, in words."""
    wide, tall = figure.get_size_inches()
    found = [f"{a!r} over {b!r}" for a, b in overlaps(figure)]
    for text in shown_texts(figure):
        box = text.get_window_extent()
        words = text.get_text()
        if "…" in words:
            found.append(f"{words!r} is elided")
        if text.get_fontsize() < SMALL:
            found.append(f"{words!r} is small")
        if not (box.x0 >= 0 and box.y0 >= 0 and box.x1 <= wide * figure.dpi and box.y1 <= tall * figure.dpi):
            found.append(f"{words!r} is cut")
    if wide > PAGE_WIDTH + 1e-9 or tall > PAGE_HEIGHT + 1e-9:
        found.append(f"{wide:.2f} by {tall:.2f} inches are more than a page")
    for legend in figure.legends:
        looks = key_looks(legend)
        labels = [t.get_text() for t in legend.get_texts()]
        alike = [label for look, label in zip(looks, labels, strict=True) if looks.count(look) > 1]
        if alike:
            found.append(f"alike in the key: {alike}")
    return found


def key_looks(legend: Legend) -> list[tuple[Any, ...]]:
    """What tells the entries of a key apart in grey: kind, dashes, mark, width, hatch, and lightness in steps."""
    return [_look(handle) for handle in legend.legend_handles if handle is not None]


def _look(handle: Artist) -> tuple[Any, ...]:
    if isinstance(handle, Line2D):
        _, dashes = handle._unscaled_dash_pattern
        marked = handle.get_marker() not in ("", "None", None)
        fill = _grey(handle.get_markerfacecolor()) if marked else None
        line = handle.get_linestyle() != "None"
        ink = (dashes and tuple(dashes), handle.get_linewidth(), _grey(handle.get_color())) if line else None
        return ("line", ink, handle.get_marker() if marked else None, fill)
    assert isinstance(handle, Patch)
    edge = (_grey(handle.get_edgecolor()), str(handle.get_linestyle())) if handle.get_linewidth() > 0 else None
    return ("patch", handle.get_hatch(), _grey(handle.get_facecolor()), edge)


def _grey(colour: Any) -> int:
    """Lightness on white in steps of a twelfth: what is in one step is hardly told apart."""
    r, g, b, alpha = to_rgba(colour)
    return round(12 * (alpha * (0.2126 * r + 0.7152 * g + 0.0722 * b) + 1.0 - alpha))


def cells(axes: Axes) -> dict[tuple[int, int], str]:
    """Colours of the cells of a map, by row and column."""
    found: dict[tuple[int, int], str] = {}
    for patch in axes.get_children():
        if isinstance(patch, PathPatch) and patch.get_fill():
            for box in np.asarray(patch.get_path().vertices).reshape(-1, 5, 2):
                column, row = box.min(axis=0)
                assert box.max(axis=0).tolist() == [column + 1, row + 1]
                assert found.setdefault((int(row), int(column)), to_hex(patch.get_facecolor())) is not None
    return found
