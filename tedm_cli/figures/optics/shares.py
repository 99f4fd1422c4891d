"""Where a read-out comes from, as bars: areas, and under the worst area the elements and their degrees of freedom."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, MaxNLocator

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.figures.drawing.fit import line_count, widest, wrapped
from tedm_cli.figures.drawing.key import key
from tedm_cli.figures.drawing.spec import PAGE_WIDTH
from tedm_cli.figures.drawing.style import BLUE, COLOURS, LINE, SMALL, VERMILION, grid, heading, heading_lines, style
from tedm_cli.results.wording import number_text

_MOST, _VISIBLE = 8, 2e-3  # bars besides that of all others, and the least of the longest that is worth one
_ROW, _TITLE, _BETWEEN, _FOOT = 0.17, 0.16, 0.46, 0.46  # inches
_NAMES = 2.5  # inches of names at most
_CAUSES = ("ux (m)", "uy (m)", "uz (m)", "rx (rad)", "ry (rad)", "rz (rad)", "index", "thickness")
_COLOURS = (COLOURS[0], COLOURS[4], COLOURS[2], COLOURS[1], COLOURS[5], COLOURS[3], COLOURS[6], "#8C6D31")
_HATCHES = ("", "...", "\\\\\\\\", "////", "xxxx", "----", "ooo", "++++")  # each its own, so that colour is not needed
_OTHERS = "#9A9A9A"


@dataclass(frozen=True, eq=False)
class ReadOutShares:
    """One read-out in `unit` per kelvin: by area [k], and by element and cause under the area `worst`.

    The causes are the six motions [n, 6], and where plates change, their index and thickness as well [n, 8].
    """

    read_out: str
    unit: str
    by_area: FloatArray
    worst: int
    by_element: FloatArray


def shares_figure(shares: Sequence[ReadOutShares], areas: Sequence[str], elements: Sequence[str], title: str) -> Figure:
    """A row for each read-out: the areas with the largest read-out, and what makes it under the first of them."""
    with style():
        lefts = [_area_rows(share, areas) for share in shares]
        rights = [_element_rows(share, elements) for share in shares]
        names = [[wrapped(name, _NAMES, SMALL) for table in tables for name in table] for tables in (lefts, rights)]
        room = [0.12 + widest(column, SMALL) for column in names]
        row = max(_ROW, 0.025 + LINE * max(line_count(name) for column in names for name in column))
        bars = max(map(len, (*lefts, *rights)))
        wide = (PAGE_WIDTH - sum(room) - 0.35) / 2
        titles = [
            [
                wrapped(text, wide + beside - 0.2, SMALL)
                for text, beside in zip(_titles(share, areas), room, strict=True)
            ]
            for share in shares
        ]
        above = 0.06 + _TITLE * max(line_count(text) for pair in titles for text in pair)
        legend = key(_samples(shares[0].by_element.shape[1]), PAGE_WIDTH - 0.3, sample=2.2, most=9)
        top = heading_lines(title, "", PAGE_WIDTH)[2]
        panel = row * bars
        each = above + panel + _BETWEEN
        height = top + len(shares) * each + _FOOT - _BETWEEN + legend.height + 0.25
        figure = Figure(figsize=(PAGE_WIDTH, height))
        for number, (share, texts) in enumerate(zip(shares, titles, strict=True)):
            bottom = height - top - number * each - above - panel
            boxes = [(x / PAGE_WIDTH, bottom / height, wide / PAGE_WIDTH, panel / height)
                     for x in (room[0] + 0.05, PAGE_WIDTH - 0.2 - wide)]  # fmt: skip
            left, right = (figure.add_axes(box) for box in boxes)
            _area_bars(left, share, lefts[number], bars)
            _element_bars(right, share, rights[number], bars)
            for axes, text, beside in zip((left, right), texts, room, strict=True):
                axes.set_title(text, fontsize=SMALL, pad=3, x=-(beside - 0.12) / wide)
        heading(figure, title)
        legend.draw(figure, 0.15, 0.08)
        return figure


def _titles(share: ReadOutShares, areas: Sequence[str]) -> tuple[str, str]:
    total = number_text(float(share.by_element.sum()))
    by_element = f"{share.read_out} under {areas[share.worst]} by element: {total} {share.unit}/K in all"
    return f"{share.read_out} by area", by_element


def _samples(causes: int) -> list[Artist]:
    samples: list[Artist] = [
        Patch(facecolor=c, hatch=h, edgecolor="white", linewidth=0.0, label=cause)
        for cause, c, h in zip(_CAUSES[:causes], _COLOURS, _HATCHES, strict=False)
    ]
    samples.append(
        Line2D([], [], linestyle="none", marker="D", markersize=5, color="black", label="sum of the element")
    )
    return samples


def ranked(size: FloatArray) -> tuple[IntArray, IntArray]:
    """Places of the largest values that can be seen beside the first, largest first, and of all others."""
    part = np.round(size / (size.max() or 1.0), 9)  # equals up to rounding keep their order
    order = np.argsort(-part, kind="stable")
    most = max(1, min(_MOST, int((part > _VISIBLE).sum())))
    return order[:most], order[most:]


def _area_rows(share: ReadOutShares, names: Sequence[str]) -> list[str]:
    """Names of the bars of the areas, the others last."""
    top, others = ranked(np.abs(share.by_area))
    # Areas are loaded one at a time: what the others amount to is their root sum of squares.
    return [*(names[i] for i in top), *([f"{others.size} others, rss"] if others.size else [])]


def _element_rows(share: ReadOutShares, names: Sequence[str]) -> list[str]:
    """Names of the bars of the elements, the others last."""
    top, others = ranked(_felt(share))
    return [*(names[i] for i in top), *([f"{others.size} others, sum"] if others.size else [])]


def _felt(share: ReadOutShares) -> FloatArray:
    """The larger sum over causes of one sign of every element [n]: one whose motions cancel matters as well."""
    value = share.by_element
    return np.asarray(np.maximum(np.clip(value, 0, None).sum(axis=1), -np.clip(value, None, 0).sum(axis=1)))


def _area_bars(axes: Axes, share: ReadOutShares, names: Sequence[str], bars: int) -> None:
    top, others = ranked(np.abs(share.by_area))
    value = share.by_area[top]
    drawn = axes.barh(range(len(top)), value, color=[BLUE if v >= 0 else VERMILION for v in value], edgecolor="black",
                     linewidth=0.5, height=0.72)  # fmt: skip
    for bar, v in zip(drawn, value, strict=True):
        bar.set_hatch("" if v >= 0 else "////")
    if others.size:
        axes.barh([len(top)], [np.linalg.norm(share.by_area[others])], color=_OTHERS, height=0.72)
    _finish(axes, names, share.unit + "/K", bars)


def _element_bars(axes: Axes, share: ReadOutShares, names: Sequence[str], bars: int) -> None:
    top, others = ranked(_felt(share))
    for row, element in enumerate(top):
        ends = {1: 0.0, -1: 0.0}
        for cause, v in enumerate(share.by_element[element]):
            sign = 1 if v > 0 else -1
            if v != 0.0:
                axes.barh([row], [v], left=[ends[sign]], color=_COLOURS[cause], hatch=_HATCHES[cause],
                          edgecolor="white", linewidth=0.0, height=0.72)  # fmt: skip
            ends[sign] += v
        axes.plot([share.by_element[element].sum()], [row], marker="D", markersize=3.6, color="black", zorder=4)
    if others.size:
        axes.barh([len(top)], [share.by_element[others].sum()], color=_OTHERS, height=0.72)
    _finish(axes, names, share.unit + "/K", bars)


def _finish(axes: Axes, names: Sequence[str], unit: str, bars: int) -> None:
    axes.set_yticks(range(len(names)), [wrapped(name, _NAMES, SMALL) for name in names], fontsize=SMALL)
    axes.set_ylim(max(len(names), bars) - 0.4, -0.6)
    axes.axvline(0.0, color="black", linewidth=0.8)
    axes.use_sticky_edges = False
    axes.margins(x=0.05)
    axes.autoscale_view(scaley=False)
    axes.xaxis.set_major_locator(MaxNLocator(5))
    axes.xaxis.set_major_formatter(
        FuncFormatter(lambda v, _: f"{v:,.6g}".replace(",", "\N{NO-BREAK SPACE}").replace("-", "−"))
    )
    axes.tick_params(axis="x", labelsize=SMALL)
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel(f"({unit})", fontsize=SMALL, labelpad=1)
    grid(axes)
