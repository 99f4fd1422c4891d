"""Minor ticks of logarithmic axes, drawn at once: matplotlib makes each of them of seven artists."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.markers import TICKDOWN, TICKLEFT
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.ticker import Locator, NullFormatter, NullLocator

from tedm_cli.arrays import FloatArray

_RC: Any = mpl.rcParams


def at_once(axes: Axes) -> None:
    """From now on the minor ticks of logarithmic axes, where they have no labels, are drawn so."""
    axis: Any
    for axis in (axes.xaxis, axes.yaxis):
        locator, bare = axis.get_minor_locator(), isinstance(axis.get_minor_formatter(), NullFormatter)
        if axis.get_scale() == "log" and bare and not isinstance(locator, NullLocator):
            axis.set_minor_locator(NullLocator())
            locator.set_axis(axis)
            axes.add_artist(_MinorTicks(axes, axis, locator))


class _MinorTicks(Artist):
    """Ticks and grid lines of one axis, in the look of its parameters of minor ticks when it is drawn."""

    def __init__(self, axes: Axes, axis: Any, locator: Locator) -> None:
        super().__init__()
        self._of, self._axis, self._locator = axes, axis, locator
        self._along_x = axis is axes.xaxis
        self.set_zorder(axis.get_zorder() + 0.01)  # right above the major ones
        self.set_in_layout(False)

    def draw(self, renderer: Any) -> None:
        """Draw the grid lines, then the ticks."""
        places, look = self._places(), self._axis.get_tick_params(which="minor")
        if not places.size:
            return
        for part in (*self._lines(places, look), *self._marks(places, look)):
            part.set_figure(self.figure)
            part.draw(renderer)

    def _places(self) -> FloatArray:
        """Where the ticks are: in view, and not where a major one is."""
        low, high = sorted(self._axis.get_view_interval())
        places = np.asarray(self._locator.tick_values(low, high), dtype=float)
        places = places[(places >= low) & (places <= high)]
        major = np.asarray(self._axis.get_majorticklocs(), dtype=float)
        taken = np.isclose(places[:, None], major, rtol=1e-5, atol=0.0).any(axis=1)
        return np.asarray(places[~taken])

    def _lines(self, places: FloatArray, look: dict[str, Any]) -> Iterator[Artist]:
        if not look.get("gridOn"):
            return
        along = 0 if self._along_x else 1
        ends = np.zeros((len(places), 2, 2))
        ends[..., along], ends[:, 1, 1 - along] = places[:, None], 1.0
        lines = PathPatch(
            Path(ends.reshape(-1, 2), [Path.MOVETO, Path.LINETO] * len(places)),
            fill=False,
            edgecolor=look.get("grid_color", _RC["grid.color"]),
            linewidth=look.get("grid_linewidth", _RC["grid.linewidth"]),
            transform=self._across("grid"),
        )
        lines.set_clip_path(self._of.patch)
        yield lines

    def _marks(self, places: FloatArray, look: dict[str, Any]) -> Iterator[Artist]:
        mark: Any
        name, side, mark = ("xtick", "bottom", TICKDOWN) if self._along_x else ("ytick", "left", TICKLEFT)
        size = look.get("length", _RC[f"{name}.minor.size"])
        if not look.get(side, True) or not size:
            return
        edge = np.zeros(len(places))
        yield Line2D(
            *((places, edge) if self._along_x else (edge, places)),
            linestyle="none",
            marker=mark,
            markersize=size,
            markeredgewidth=look.get("width", _RC[f"{name}.minor.width"]),
            color=look.get("color", _RC[f"{name}.color"]),
            transform=self._across("tick1"),
        )

    def _across(self, which: Literal["grid", "tick1"]) -> Any:
        """The transform along the axis in its data, across it in fractions of the axes."""
        return (self._of.get_xaxis_transform if self._along_x else self._of.get_yaxis_transform)(which)
