"""Figures over thermal areas: sensitivities as maps, contributions as bars."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from tedm_cli.arrays import IntArray
from tedm_cli.figures.fit import fitted, wrapped
from tedm_cli.figures.style import BLUE, VERMILION, WIDTH, grid, inches, power_of_ten, ratio_axis, style
from tedm_cli.noise.areas import AreaTable
from tedm_cli.results.areas import AreaMap, by_group
from tedm_cli.results.noise import CaseNoise, JudgedOutput
from tedm_cli.results.wording import unit_text

_ROW = 0.158  # inches of one area
_MOST_DECADES = 5.0


def map_figure(maps: Sequence[AreaMap], areas: AreaTable, title: str) -> Figure:
    """|sensitivity| of outputs (columns) to areas (rows, group by group); one panel and colour scale for each unit."""
    with style():
        k = len(areas)
        columns = sum(len(m.labels) for m in maps)
        foot = 0.3 + 0.062 * max(len(label) for m in maps for label in m.labels)  # the labels stand at 60 degrees
        left = 0.6 + 0.071 * max(len(n) for n in areas.name)
        figure = Figure(figsize=(left + 0.55 * columns + 0.35 * len(maps), _ROW * k + 1.05 + foot))

        ratios = [len(m.labels) for m in maps]
        panels = figure.subplots(1, len(maps), squeeze=False, width_ratios=ratios)[0]
        inches(figure, left=left, right=0.2, top=1.05, bottom=foot, wspace=0.12)
        order = by_group(areas)
        for axes, panel in zip(panels, maps, strict=True):
            _map_panel(figure, axes, panel, areas, order)
        panels[0].set_yticks(np.arange(k) + 0.5, [areas.name[i] for i in order], fontsize=7.5)
        group_names(figure, panels[0], [areas.group[i] for i in order], left)
        for axes in panels[1:]:
            axes.set_yticks([])
        height = figure.get_size_inches()[1]
        figure.text(0.012, 1 - 0.12 / height, title, fontsize=11.5, fontweight="bold", va="top")
        return figure


def _map_panel(figure: Figure, axes: Axes, panel: AreaMap, areas: AreaTable, order: IntArray) -> None:
    size = np.abs(panel.value[:, order]).T
    high = float(size.max()) if size.max() > 0 else 1.0
    positive = size[size > 0]
    low = max(float(positive.min()), high * 10**-_MOST_DECADES) if positive.size else high / 10
    low = min(low, high / 10)
    clipped = bool((size < low).any())
    mesh = axes.pcolormesh(
        np.maximum(size, low), norm=LogNorm(low, high), cmap="cividis", edgecolors="white", linewidth=0.3
    )
    axes.invert_yaxis()
    axes.set_xticks(np.arange(len(panel.labels)) + 0.5, panel.labels, rotation=60, ha="right", rotation_mode="anchor")
    axes.tick_params(length=0)
    axes.tick_params(axis="x", labelsize=8)
    for edge in group_edges([areas.group[i] for i in order])[1:-1]:
        axes.axhline(edge, color="black", linewidth=1.1)
    box = axes.get_position()
    height = figure.get_size_inches()[1]
    bar_axes = figure.add_axes((box.x0, box.y1 + 0.13 / height, box.width, 0.13 / height))
    bar = figure.colorbar(mesh, cax=bar_axes, orientation="horizontal", extend="min" if clipped else "neither")
    bar.ax.xaxis.set_ticks_position("top")
    bar.ax.xaxis.set_label_position("top")
    bar.ax.xaxis.set_major_locator(LogLocator(numticks=max(2, len(panel.labels))))
    bar.ax.xaxis.set_minor_locator(NullLocator())
    bar.ax.xaxis.set_major_formatter(FuncFormatter(power_of_ten))
    bar.set_label(f"{panel.title} ({unit_text(panel.unit)})", fontsize=9)


def group_edges(groups: Sequence[str]) -> list[int]:
    """First row of every group, and the end."""
    return [i for i in range(len(groups)) if i == 0 or groups[i] != groups[i - 1]] + [len(groups)]


def group_names(figure: Figure, axes: Axes, groups: Sequence[str], left: float, shift: float = 0.0) -> None:
    """Names of groups of rows with brackets, `left` inches from the panel; row i spans i to i + 1, plus `shift`."""
    edges = group_edges(groups)
    width = axes.get_position().width * figure.get_size_inches()[0]
    x = -(left - 0.38) / width
    for start, end in itertools.pairwise(edges):
        low, high = start + shift, end + shift
        axes.plot([x, x], [low + 0.2, high - 0.2], transform=axes.get_yaxis_transform(), clip_on=False, color="black",
                  linewidth=1.2)  # fmt: skip
        axes.text(x - 0.04 / width, (low + high) / 2, groups[start], transform=axes.get_yaxis_transform(), rotation=90,
                  ha="right", va="center", fontsize=9)  # fmt: skip


def ratios_figure(cases: Sequence[CaseNoise], kinds: Sequence[str]) -> Figure:
    """Ratio to the requirement of every case's worst output, with its range over other temperature filters."""
    with style():
        figure = Figure(figsize=(WIDTH, 1.65 + 0.25 * len(cases)))
        panels = figure.subplots(1, len(kinds), squeeze=False, sharey=True)[0]
        for axes, kind in zip(panels, kinds, strict=True):
            for row, case in enumerate(cases):
                if case.of_kind(kind):
                    _ratio_row(axes, row, case.worst(kind))
            room = (WIDTH - 1.2) / len(kinds) - 0.15
            axes.axvline(1.0, color="black", linewidth=1.6)
            axes.set_xscale("log")
            ratio_axis(axes.xaxis, *axes.get_xlim())
            axes.set_xlabel(wrapped("safety factor × noise / requirement (1)", room, 9, 3), fontsize=9)
            names = dict.fromkeys(j.requirement for c in cases for j in c.of_kind(kind))
            axes.set_title(wrapped(f"worst output against {', '.join(names)}", room, 9, 2), fontsize=9)
            axes.tick_params(labelsize=8.5)
            grid(axes)
        panels[0].set_yticks(range(len(cases)), [fitted(f"case {c.id}", 0.7, 8.5) for c in cases])
        panels[0].set_ylim(len(cases) - 0.4, -0.6)
        inches(figure, left=0.8, right=0.25, top=0.5, bottom=1.0, wspace=0.08)
        handles = [axes.get_legend_handles_labels() for axes in panels]
        unique = {label: h for hs, labels in handles for h, label in zip(hs, labels, strict=True)}
        figure.legend(unique.values(), unique.keys(), loc="lower left", ncols=3)
        return figure


def _ratio_row(axes: Axes, row: int, j: JudgedOutput) -> None:
    if j.filter_ratio is not None:
        axes.plot(
            [j.filter_ratio.min(), j.filter_ratio.max()],
            [row, row],
            color="#9A9A9A",
            linewidth=4,
            solid_capstyle="butt",
            label="range over filter orders and corners",
        )
    axes.plot(
        [j.ratio],
        [row],
        linestyle="none",
        marker="o" if j.passed else "X",
        markersize=8,
        color=BLUE if j.passed else VERMILION,
        label="met (at most 1)" if j.passed else "violated (above 1)",
    )
