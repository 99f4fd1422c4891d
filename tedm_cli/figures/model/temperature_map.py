"""A figure of a model coloured by a field of temperatures: from outside, and cut open."""

from __future__ import annotations

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import ListedColormap, to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from tedm_cli.arrays import FloatArray
from tedm_cli.figures.drawing.spec import PAGE_WIDTH
from tedm_cli.figures.drawing.style import SMALL, heading, heading_lines, style
from tedm_cli.figures.model.adjoint_map import LEFT, SCALE_ROOM, MapViews
from tedm_cli.figures.model.views import Mesh, show

_NO_TEMPERATURE = "#B8B8B8"
_STEPS, _BAR, _WIDE = 96, 0.13, 4.6  # steps of colour; inches
# As light in grey as in colour, read as warm and cold; the darkest colours would hide the shading.
_TABLE = ListedColormap(colormaps["plasma"](np.linspace(0.15, 0.97, 256)))


def temperature_figure(views: MapViews, temperature: FloatArray, title: str, above: str, unit: str = "K") -> Figure:
    """The model coloured by the means over its elements of temperatures of grids [N], in `unit`.

    NaN where there is none. above : what the temperatures are above, or that they are absolute.
    """
    with style():
        more = f"means over elements, {above}; dashed: test masses"
        temperature = _of_elements(views.mesh, temperature)
        if np.isnan(temperature).any():
            more += "; grey: not mapped"
        _, _, head = heading_lines(title, more, PAGE_WIDTH)
        height = head + SCALE_ROOM + views.height
        figure = Figure(figsize=(PAGE_WIDTH, height), dpi=150)
        heading(figure, title, more=more)
        low, high = float(np.nanmin(temperature)), float(np.nanmax(temperature))
        if not high > low:  # an even field
            low, high = low - 0.5, high + 0.5
        _scale(figure, low, high, (LEFT + 0.3, height - head - 0.55), unit)
        rgb = np.asarray(_TABLE((np.nan_to_num(temperature, nan=low) - low) / (high - low)))[:, :3]
        table = np.concatenate([rgb, [to_rgb(_NO_TEMPERATURE)]])
        table[:-1][np.isnan(temperature)] = to_rgb(_NO_TEMPERATURE)
        for seen, (left, bottom, wide, tall) in views.panels:
            axes = figure.add_axes((left / PAGE_WIDTH, bottom / height, wide / PAGE_WIDTH, tall / height))
            show(axes, views.mesh, seen, table, borders=False, sizes=(SMALL, SMALL))
        return figure


def _of_elements(mesh: Mesh, temperature: FloatArray) -> FloatArray:
    """Means over the elements [E]; NaN of one without grids, or with a grid that has no temperature."""
    counts = np.diff(mesh.node_offset)
    element = np.repeat(np.arange(len(counts)), counts)
    sums = np.bincount(element, temperature[mesh.node_index], len(counts))
    return np.asarray(np.where(counts > 0, sums / np.maximum(counts, 1), np.nan))


def _scale(figure: Figure, low: float, high: float, place: tuple[float, float], unit: str) -> None:
    """Steps of colour, with even ticks above them."""
    width, height = (float(v) for v in figure.get_size_inches())
    axes = figure.add_axes((place[0] / width, place[1] / height, _WIDE / width, _BAR / height))
    for step in range(_STEPS):
        wider = 1.5 if step < _STEPS - 1 else 1.0  # a hair wider than its step: no background between neighbours
        x = low + (high - low) * np.array([step, step, step + wider, step + wider]) / _STEPS
        axes.fill(x, [0.0, 1.0, 1.0, 0.0], facecolor=to_hex(_TABLE((step + 0.5) / _STEPS)), linewidth=0)
    axes.set(xlim=(low, high), ylim=(0, 1), yticks=[])
    axes.xaxis.set_major_locator(MaxNLocator(6))
    axes.ticklabel_format(axis="x", useOffset=False)
    axes.xaxis.set_ticks_position("top")
    axes.xaxis.set_label_position("top")
    axes.tick_params(pad=1, length=2.5, labelsize=SMALL)
    axes.set_xlabel(f"temperature ({unit})", fontsize=9)
