"""Matrices of the optics as signed heat maps: S_BW without units, and N by thermal area."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, SymLogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from tedm_cli.arrays import FloatArray
from tedm_cli.figures.areas import group_edges, group_names
from tedm_cli.figures.style import BLUE, VERMILION, power_of_ten, style
from tedm_cli.noise.areas import AreaTable
from tedm_cli.optics.invariances import scaled_matrix
from tedm_cli.optics.layout import N_MOTIONS, N_OUTPUTS, OpticalLayout
from tedm_cli.results.areas import AreaMap, by_group
from tedm_cli.results.wording import number_text

#: Negative blue, positive vermilion, zero white; darker ends widen the range that can be told apart.
SIGNED = LinearSegmentedColormap.from_list(
    "signed", ["#00304D", BLUE, "#A6D1EA", "#FFFFFF", "#F6C39B", VERMILION, "#5C2800"]
)
_OUTPUTS, _MOTIONS = ("x", "y", "opl", "z1", "z2"), ("ux", "uy", "uz", "rx", "ry", "rz")
_PANEL = 12  # elements beside each other
_CELL = 0.14  # inches
_DECADES = 3  # of each sign in colour; below it fades linearly to white


def sensitivity_map(layout: OpticalLayout, S_BW: FloatArray) -> Figure:
    """S_BW with lengths in units of the bench size: outputs by path, motions by element, 12 elements in a panel."""
    with style():
        value = scaled_matrix(layout, S_BW)
        rows, n = len(value), len(layout.elements)
        panels = -(-n // _PANEL)
        across = min(n, -(-n // panels))
        left = 0.65 + 0.07 * max(len(p.label) for p in layout.paths)
        head, gap, foot = 1.3, 0.78, 0.4
        width = left + across * N_MOTIONS * _CELL + 0.2
        height = head + panels * rows * _CELL + (panels - 1) * gap + foot
        figure = Figure(figsize=(width, height))
        norm = signed_norm(value)
        for panel in range(panels):
            shown = layout.elements[panel * across : (panel + 1) * across]
            columns = slice(panel * across * N_MOTIONS, (panel * across + len(shown)) * N_MOTIONS)
            top = height - head - panel * (rows * _CELL + gap)
            axes = figure.add_axes((left / width, (top - rows * _CELL) / height,
                                    len(shown) * N_MOTIONS * _CELL / width, rows * _CELL / height))  # fmt: skip
            image = _image(axes, value[:, columns], norm)
            axes.set_xticks(range(len(shown) * N_MOTIONS), _MOTIONS * len(shown), rotation=90, fontsize=6.5)
            axes.set_yticks(range(rows), _OUTPUTS * len(layout.paths), fontsize=7)
            axes.tick_params(length=0, pad=1.5)
            for i, element in enumerate(shown):
                axes.text((i + 0.5) * N_MOTIONS - 0.5, -1.0, element.name, fontsize=8.5, ha="center", va="bottom")
            for edge in range(N_MOTIONS, len(shown) * N_MOTIONS, N_MOTIONS):
                axes.axvline(edge - 0.5, color="black", linewidth=0.8)
            for i, path in enumerate(layout.paths):
                x = -0.32 / (len(shown) * N_MOTIONS * _CELL)
                axes.text(x, (i + 0.5) * N_OUTPUTS - 0.5, path.label, transform=axes.get_yaxis_transform(),
                          fontsize=8.5, ha="right", va="center")  # fmt: skip
                if i:
                    axes.axhline(i * N_OUTPUTS - 0.5, color="black", linewidth=0.8)
        size = 1e3 * layout.size_m
        title = f"S_BW, lengths in units of the bench size L = {size:.4g} mm"
        figure.text(0.012, 1 - 0.1 / height, title, fontsize=11.5, fontweight="bold", va="top")
        _colour_bar(
            figure, image, (left, height - 0.86, min(4.5, width - left - 0.2)), "change of output per motion (1)"
        )
        return figure


def noise_map(maps: Sequence[AreaMap], areas: AreaTable, title: str) -> Figure:
    """N with signs and numbers: read-outs (columns) by areas (rows, group by group); a panel for each unit.

    Every map is [rows, k] of its read-outs and areas in the unit it names.
    """
    with style():
        k = len(areas)
        foot = 0.3 + 0.062 * max(len(label) for m in maps for label in m.labels)
        left = 0.6 + 0.071 * max(len(n) for n in areas.name)
        cell, row, head = 0.56, 0.158, 1.05
        columns = sum(len(m.labels) for m in maps)
        gap = 0.3
        width, height = left + cell * columns + gap * (len(maps) - 1) + 0.2, row * k + head + foot
        figure = Figure(figsize=(width, height))
        order = by_group(areas)
        groups = [areas.group[i] for i in order]
        x = left
        for number, panel in enumerate(maps):
            wide = cell * len(panel.labels)
            axes = figure.add_axes((x / width, foot / height, wide / width, row * k / height))
            value = panel.value[:, order].T
            norm = signed_norm(value)
            image = _image(axes, value, norm)
            _write_values(axes, value, norm)
            axes.set_xticks(
                range(len(panel.labels)), panel.labels, rotation=60, ha="right", rotation_mode="anchor", fontsize=8
            )
            axes.set_yticks(range(k) if number == 0 else [], [areas.name[i] for i in order] if number == 0 else [],
                            fontsize=7.5)  # fmt: skip
            axes.tick_params(length=0)
            for edge in group_edges(groups)[1:-1]:
                axes.axhline(edge - 0.5, color="black", linewidth=1.1)
            _colour_bar(figure, image, (x, height - head + 0.13, wide), f"{panel.title} ({panel.unit})")
            if number == 0:
                axes.set_ylim(k - 0.5, -0.5)
                group_names(figure, axes, groups, left, shift=-0.5)
            x += wide + gap
        figure.text(0.012, 1 - 0.12 / height, title, fontsize=11.5, fontweight="bold", va="top")
        return figure


def signed_norm(value: FloatArray) -> SymLogNorm:
    """Symmetric colour scale: three decades of each sign below the largest entry, linear below."""
    largest = float(np.abs(value).max()) or 1.0
    return SymLogNorm(largest * 10.0**-_DECADES, linscale=0.5, vmin=-largest, vmax=largest, base=10)


def _image(axes: Axes, value: FloatArray, norm: SymLogNorm) -> Any:
    return axes.imshow(value, norm=norm, cmap=SIGNED, aspect="auto", interpolation="none")


def _write_values(axes: Axes, value: FloatArray, norm: SymLogNorm) -> None:
    for (row, column), v in np.ndenumerate(value):
        r, g, b, _ = SIGNED(float(np.asarray(norm(v))))
        dark = 0.2126 * r + 0.7152 * g + 0.0722 * b < 0.45
        axes.text(column, row, number_text(float(v)), fontsize=6.5, ha="center", va="center_baseline",
                  color="white" if dark else "black")  # fmt: skip


def _colour_bar(figure: Figure, image: Any, place: tuple[float, float, float], label: str) -> None:
    """A colour bar at (left, bottom, width) inches, its ticks above it."""
    width, height = figure.get_size_inches()
    left, bottom, wide = place
    axes = figure.add_axes((left / width, bottom / height, wide / width, 0.13 / height))
    bar = figure.colorbar(image, cax=axes, orientation="horizontal")
    top = math.floor(math.log10(image.norm.vmax) + 1e-9)
    step = 2 if wide < 2.5 else 1
    tens = [10.0**e for e in range(top, top - _DECADES, -step)]
    axes.xaxis.set_major_locator(FixedLocator([-t for t in tens] + [0.0] + tens[::-1]))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(_signed_power))
    axes.tick_params(labelsize=7.5 if wide > 2.5 else 6.5, pad=1)
    axes.xaxis.set_ticks_position("top")
    axes.xaxis.set_label_position("top")
    bar.set_label(label, fontsize=9)


def _signed_power(value: float, _position: int | None = None) -> str:
    return "0" if value == 0.0 else power_of_ten(value) if value > 0.0 else f"−{power_of_ten(-value)}"
