"""The optical sensitivity matrix as a heat map with signs."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tedm_cli.arrays import FloatArray
from tedm_cli.figures.drawing.cells import Colours, draw_cells, signed_bar, signed_colours
from tedm_cli.figures.drawing.fit import text_width
from tedm_cli.figures.drawing.spec import PAGE_HEIGHT, PAGE_WIDTH
from tedm_cli.figures.drawing.style import SMALL, TITLE, style
from tedm_cli.optics.invariances import scaled_matrix
from tedm_cli.optics.layout import N_MOTIONS, N_OUTPUTS, OpticalLayout

OUTPUTS, MOTIONS = ("x", "y", "opl", "z1", "z2"), ("ux", "uy", "uz", "rx", "ry", "rz")
_PANEL = 12  # elements beside each other, where the page holds them
_CELL, _LEAST = 0.1, 0.04  # inches of a cell, and of the height of one where a page would be too small
_MARKED = 0.17  # inches of a cell of the block that tells what rows and columns are
_HEAD, _FOOT = 1.55, 0.15


def sensitivity_map(layout: OpticalLayout, S_BW: FloatArray) -> Figure:
    """S_BW with lengths in units of the bench size: outputs by path, motions by element, 12 elements in a panel.

    Rows and columns are the same in all blocks, and are told by one that is drawn larger.
    """
    with style():
        value = scaled_matrix(layout, S_BW)
        rows, n = len(value), len(layout.elements)
        left = 0.2 + max(text_width(p.label, SMALL) for p in layout.paths)
        most = max(1, min(_PANEL, int((PAGE_WIDTH - left - 0.15) / (N_MOTIONS * _CELL))))
        panels = -(-n // most)
        across = -(-n // panels)
        names = max(text_width(e.name, SMALL) for e in layout.elements)
        upright = names > N_MOTIONS * _CELL - 0.05  # names of elements that are wider than their blocks
        gap = 0.2 + (names if upright else 0.14)
        room = PAGE_HEIGHT - _HEAD - _FOOT - panels * gap
        cell = max(_LEAST, min(_CELL, room / (panels * rows)))
        width = max(left + across * N_MOTIONS * _CELL + 0.15, 7.0)
        height = _HEAD + panels * (rows * cell + gap) + _FOOT
        figure = Figure(figsize=(width, height))
        colours = signed_colours(value)
        for panel in range(panels):
            shown = layout.elements[panel * across : (panel + 1) * across]
            columns = slice(panel * across * N_MOTIONS, (panel * across + len(shown)) * N_MOTIONS)
            top = height - _HEAD - gap - panel * (rows * cell + gap)
            wide, tall = len(shown) * N_MOTIONS * _CELL, rows * cell
            axes = figure.add_axes((left / width, (top - tall) / height, wide / width, tall / height))
            _panel(axes, value[:, columns], colours, [e.name for e in shown], [p.label for p in layout.paths], upright)
        size = 1e3 * layout.size_m
        title = f"S_BW, lengths in units of the bench size L = {size:.4g} mm"
        figure.text(0.08 / width, 1 - 0.1 / height, title, fontsize=TITLE, fontweight="bold", va="top")
        bar = (left, height - 0.95, min(4.2, width - left - 3.0))
        signed_bar(figure, colours, bar, "change of output per motion (1)")
        figure.text(
            left / width, (height - 1.1) / height, "a bar in a cell: negative; white: zero", fontsize=SMALL, va="top"
        )
        _block(figure, width - 0.3 - N_MOTIONS * _MARKED, height - 0.62)
        return figure


def _panel(
    axes: Axes, value: FloatArray, colours: Colours, elements: list[str], paths: list[str], upright: bool
) -> None:  # fmt: skip
    draw_cells(axes, value, colours, minus=True)
    axes.set_xticks((np.arange(len(elements)) + 0.5) * N_MOTIONS, elements, rotation=90 if upright else 0)
    axes.xaxis.set_ticks_position("top")
    axes.set_yticks((np.arange(len(paths)) + 0.5) * N_OUTPUTS, paths)
    axes.tick_params(length=0, pad=3, labelsize=SMALL)
    for edge in range(N_MOTIONS, len(elements) * N_MOTIONS, N_MOTIONS):
        axes.axvline(edge, color="black", linewidth=0.8)
        axes.axvline(edge - 3, color="#B0B0B0", linewidth=0.5)
    axes.axvline(len(elements) * N_MOTIONS - 3, color="#B0B0B0", linewidth=0.5)
    for edge in range(N_OUTPUTS, len(paths) * N_OUTPUTS, N_OUTPUTS):
        axes.axhline(edge, color="black", linewidth=0.8)


def _block(figure: Figure, left: float, top: float) -> None:
    """An empty block, larger, with the names of its rows and columns."""
    width, height = (float(v) for v in figure.get_size_inches())
    wide, tall = N_MOTIONS * _MARKED, N_OUTPUTS * _MARKED
    axes = figure.add_axes((left / width, (top - tall) / height, wide / width, tall / height))
    axes.set(xlim=(0, N_MOTIONS), ylim=(N_OUTPUTS, 0))
    axes.set_xticks(np.arange(N_MOTIONS) + 0.5, MOTIONS, rotation=90, fontsize=SMALL)
    axes.xaxis.set_ticks_position("top")
    axes.set_yticks(np.arange(N_OUTPUTS) + 0.5, OUTPUTS, fontsize=SMALL)
    axes.tick_params(length=0, pad=2)
    for edge in range(1, N_MOTIONS):
        axes.axvline(edge, color="#606060" if edge == 3 else "#D0D0D0", linewidth=0.7)
    for edge in range(1, N_OUTPUTS):
        axes.axhline(edge, color="#D0D0D0", linewidth=0.7)
    axes.set_ylabel("every block:", fontsize=SMALL, rotation=0, ha="right", va="center", labelpad=6)
