"""Where a read-out comes from, as bars: areas, and under the worst area the elements and their degrees of freedom."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, MaxNLocator

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.figures.style import BLUE, COLOURS, VERMILION, grid, inches, style
from tedm_cli.results.wording import number_text

_MOST, _VISIBLE = 8, 2e-3  # bars besides that of all others, and the least of the longest that is worth one
_ROW, _HEAD, _BETWEEN, _FOOT = 0.185, 0.34, 0.46, 0.85
_MOTIONS = ("ux", "uy", "uz", "rx", "ry", "rz")
_COLOURS = (COLOURS[0], COLOURS[4], COLOURS[2], COLOURS[1], COLOURS[5], COLOURS[3])
_HATCHES = ("", "", "", "////", "////", "////")  # rotations
_OTHERS = "#9A9A9A"


@dataclass(frozen=True, eq=False)
class ReadOutShares:
    """One read-out in `unit` per kelvin: by area [k], and by element and motion [n, 6] under the area `worst`."""

    read_out: str
    unit: str
    by_area: FloatArray
    worst: int
    by_element: FloatArray


def shares_figure(shares: Sequence[ReadOutShares], areas: Sequence[str], elements: Sequence[str], title: str) -> Figure:
    """A row for each read-out: the areas with the largest read-out, and what makes it under the first of them."""
    with style():
        most = min(_MOST + 1, max(len(areas), len(elements)))
        panel = _ROW * most
        height = 0.36 + len(shares) * (_HEAD + panel + _BETWEEN) - _BETWEEN + _FOOT
        room = [0.25 + 0.072 * max(len("all 99 others"), *(len(n) for n in names)) for names in (areas, elements)]
        width = sum(room) + 3.1 + 4.4 + 0.35
        figure = Figure(figsize=(width, height))
        panels = figure.subplots(len(shares), 2, squeeze=False, width_ratios=[3.1, 4.4])
        inches(figure, left=room[0], right=0.2, top=0.36 + _HEAD, bottom=_FOOT,
               wspace=(room[1] + 0.1) / ((width - 0.2 - room[0] - room[1] - 0.1) / 2))  # fmt: skip
        figure.subplots_adjust(hspace=(_HEAD + _BETWEEN) / panel)
        for (left, right), share in zip(panels, shares, strict=True):
            _area_bars(left, share, areas, most)
            _element_bars(right, share, elements, areas, most)
        figure.text(0.012, 1 - 0.1 / height, title, fontsize=11.5, fontweight="bold", va="top")
        handles: list[Patch | Line2D] = [
            Patch(
                facecolor=c, hatch=h, edgecolor="white", linewidth=0.0, label=f"{m} ({'m' if m[0] == 'u' else 'rad'})"
            )
            for m, c, h in zip(_MOTIONS, _COLOURS, _HATCHES, strict=True)
        ]
        handles.append(
            Line2D([], [], linestyle="none", marker="D", markersize=5, color="black", label="sum of the element")
        )
        figure.legend(
            handles=handles, loc="lower right", ncols=7, columnspacing=1.2, handlelength=1.6, borderaxespad=0.2
        )
        return figure


def ranked(size: FloatArray) -> tuple[IntArray, IntArray]:
    """Places of the largest values that can be seen beside the first, largest first, and of all others."""
    part = np.round(size / (size.max() or 1.0), 9)  # equals up to rounding keep their order
    order = np.argsort(-part, kind="stable")
    most = max(1, min(_MOST, int((part > _VISIBLE).sum())))
    return order[:most], order[most:]


def _area_bars(axes: Axes, share: ReadOutShares, names: Sequence[str], bars: int) -> None:
    top, others = ranked(np.abs(share.by_area))
    value = share.by_area[top]
    drawn = axes.barh(range(len(top)), value, color=[BLUE if v >= 0 else VERMILION for v in value], edgecolor="black",
                     linewidth=0.5, height=0.72)  # fmt: skip
    for bar, v in zip(drawn, value, strict=True):
        bar.set_hatch("" if v >= 0 else "////")
    labels = [names[i] for i in top]
    if others.size:
        # Areas are loaded one at a time: what the others amount to is their root sum of squares.
        axes.barh([len(top)], [np.linalg.norm(share.by_area[others])], color=_OTHERS, height=0.72)
        labels.append(f"{others.size} others, rss")
    _finish(axes, labels, f"{share.read_out} by area", share.unit + "/K", bars)


def _element_bars(
    axes: Axes, share: ReadOutShares, names: Sequence[str], areas: Sequence[str], bars: int
) -> None:  # fmt: skip
    # By the largest of all sums over motions of one sign: an element whose motions cancel matters as well.
    size = np.maximum(np.clip(share.by_element, 0, None).sum(axis=1), -np.clip(share.by_element, None, 0).sum(axis=1))
    top, others = ranked(size)
    for row, element in enumerate(top):
        ends = {1: 0.0, -1: 0.0}
        for motion, v in enumerate(share.by_element[element]):
            sign = 1 if v > 0 else -1
            if v != 0.0:
                axes.barh([row], [v], left=[ends[sign]], color=_COLOURS[motion], hatch=_HATCHES[motion],
                          edgecolor="white", linewidth=0.0, height=0.72)  # fmt: skip
            ends[sign] += v
        axes.plot([share.by_element[element].sum()], [row], marker="D", markersize=3.6, color="black", zorder=4)
    labels = [names[i] for i in top]
    if others.size:
        axes.barh([len(top)], [share.by_element[others].sum()], color=_OTHERS, height=0.72)
        labels.append(f"{others.size} others, sum")
    total = number_text(float(share.by_element.sum()))
    _finish(axes, labels, f"{share.read_out} under {areas[share.worst]} by element: {total} {share.unit}/K in all",
            share.unit + "/K", bars)  # fmt: skip


def _finish(axes: Axes, labels: Sequence[str], title: str, unit: str, bars: int) -> None:
    axes.set_yticks(range(len(labels)), labels, fontsize=8)
    axes.set_ylim(max(len(labels), bars) - 0.4, -0.6)
    axes.axvline(0.0, color="black", linewidth=0.8)
    axes.use_sticky_edges = False
    axes.margins(x=0.05)
    axes.autoscale_view(scaley=False)
    axes.xaxis.set_major_locator(MaxNLocator(5))
    axes.xaxis.set_major_formatter(
        FuncFormatter(lambda v, _: f"{v:,.6g}".replace(",", "\N{NO-BREAK SPACE}").replace("-", "−"))
    )
    axes.tick_params(axis="x", labelsize=8)
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel(f"({unit})", fontsize=8.5, labelpad=1)
    axes.set_title(title, fontsize=9.5, pad=4)
    grid(axes)
