"""Areas under a temperature gradient, drawn over the model as arrows to the warm side of their elements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import AbstractPathEffect, withStroke

from tedm_cli.arrays import FloatArray

_MOST = 6  # arrows of one area in one view
_LENGTH = 0.07  # of the largest extent of the model
_SHORT = 0.3  # of an arrow's length: what is seen shorter points at the viewer, or away
_WHITE: list[AbstractPathEffect] = [withStroke(linewidth=2.6, foreground="white")]


@dataclass(frozen=True, eq=False)
class GradientArrows:
    """Elements of an area under a gradient: their centres [m, 3] (m), and unit vectors [m, 3] to their warm sides."""

    name: str
    centre: FloatArray
    direction: FloatArray


def draw_arrows(axes: Axes, areas: Sequence[GradientArrows], frame: FloatArray, extent: float) -> None:
    """Some arrows of every area, with its number in the key (`arrow_names`).

    Parameters
    ----------
    frame : [3, 3], rows to the right, upwards and to the viewer. extent : of the model, m.
    """
    size = _LENGTH * extent
    for area, short in zip(areas, arrow_names(areas), strict=True):
        rows = np.unique(np.linspace(0, len(area.centre) - 1, _MOST).round().astype(np.int64))
        for start, way in zip(area.centre[rows] @ frame.T, size * area.direction[rows] @ frame.T, strict=True):
            if np.hypot(*way[:2]) < _SHORT * size:
                inside = "." if way[2] > 0.0 else "x"
                axes.plot(*start[:2], "o", ms=6, mfc="white", mec="black", mew=0.9, zorder=5)
                axes.plot(*start[:2], inside, ms=3, color="black", mew=0.9, zorder=6)
            else:
                arrow = axes.annotate(
                    "", start[:2] + way[:2], start[:2], arrowprops={"arrowstyle": "-|>", "color": "black", "lw": 0.9}
                )
                if arrow.arrow_patch is not None:
                    arrow.arrow_patch.set_path_effects(_WHITE)
        tail = area.centre[rows[0]] @ frame.T
        text = axes.annotate(short, tail[:2], (-3, -3), textcoords="offset points", ha="right", va="top")
        text.set(fontsize=6.4, fontweight="bold", path_effects=_WHITE)


def arrow_names(areas: Sequence[GradientArrows]) -> list[str]:
    """What stands for each area at its arrows."""
    return [f"G{number}" for number in range(1, len(areas) + 1)]
