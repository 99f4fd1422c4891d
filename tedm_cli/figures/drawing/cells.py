"""Cells of heat maps as vector graphics, and their colour scales: no picture that a viewer could smear."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, LinearSegmentedColormap, LogNorm, SymLogNorm, to_hex
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from tedm_cli.arrays import AnyArray, BoolArray, FloatArray
from tedm_cli.figures.drawing.fit import text_width
from tedm_cli.figures.drawing.style import BLUE, SMALL, VERMILION, power_of_ten

#: Negative blue, positive vermilion, zero white; darker ends widen the range that can be told apart.
SIGNED = LinearSegmentedColormap.from_list(
    "signed", ["#00304D", BLUE, "#A6D1EA", "#FFFFFF", "#F6C39B", VERMILION, "#5C2800"], 255
)
SIGNED_DECADES = 3  # of each sign in colour; below it fades linearly to white
_MOST_DECADES = 5.0  # of sizes
_NOTHING = 1e-4  # of the largest: what lies below has a sign that does not matter
_STEPS = 96  # of a colour scale
_BAR = 0.13  # inches
_EDGE = 0.4  # points between cells
_WHITE = "#ffffff"
Place = tuple[float, float, float]  # left, bottom and width, inches


@dataclass(frozen=True, eq=False)
class Colours:
    """A colour for every value from `low` to `high`."""

    norm: LogNorm | SymLogNorm
    table: Colormap
    low: float
    high: float

    def hex(self, value: FloatArray) -> AnyArray:
        """Colours of values [...] as `#rrggbb`; white where there is no value (NaN)."""
        rgb = np.asarray(self.table(np.asarray(self.norm(np.nan_to_num(value, nan=self.low))))).reshape(-1, 4)
        shade = np.array([to_hex(c) for c in rgb], dtype="U7").reshape(np.shape(value))
        shade[np.isnan(value)] = _WHITE
        return shade

    def place(self, value: float) -> float:
        """Where a value lies on the scale, 0 to 1."""
        return float(np.asarray(self.norm(np.array([value])))[0])

    def steps(self, number: int) -> AnyArray:
        """Colours at so many places of the scale."""
        middle = (np.arange(number) + 0.5) / number
        return np.array([to_hex(c) for c in np.asarray(self.table(middle))], dtype="U7")


def signed_colours(value: FloatArray) -> Colours:
    """Symmetric colours: three decades of each sign below the largest entry, linear below."""
    largest = float(np.abs(value).max()) or 1.0
    norm = SymLogNorm(largest * 10.0**-SIGNED_DECADES, linscale=0.5, vmin=-largest, vmax=largest, base=10)
    return Colours(norm, SIGNED, -largest, largest)


def size_colours(size: FloatArray) -> Colours:
    """Colours of sizes: at most five decades below the largest."""
    high = float(size.max()) if size.max() > 0 else 1.0
    positive = size[size > 0]
    low = max(float(positive.min()), high * 10**-_MOST_DECADES) if positive.size else high / 10
    low = min(low, high / 10)
    return Colours(LogNorm(low, high, clip=True), colormaps["cividis"], low, high)


def draw_cells(axes: Axes, value: FloatArray, colours: Colours, *, minus: bool = False) -> None:
    """Cells of `value` [rows, columns], the first row on top; cell (i, j) spans j to j + 1 and i to i + 1.

    All cells of a colour are one path; white ones and those of no value (NaN) need none. `minus`: negative cells bear
    a bar, so that signs can be told without colour.
    """
    rows, columns = value.shape
    axes.set(xlim=(0, columns), ylim=(rows, 0))
    shade = colours.hex(value)
    for colour in np.unique(shade):
        if colour != _WHITE:
            axes.add_artist(PathPatch(_boxes(shade == colour), facecolor=colour, edgecolor="white", linewidth=_EDGE))
    if minus:
        light = np.array([is_light(c) for c in shade.reshape(-1)]).reshape(value.shape)
        for bright, ink in ((True, "black"), (False, "white")):
            chosen = (value < -_NOTHING * colours.high) & (light == bright)
            if chosen.any():
                axes.add_artist(PathPatch(_bars(chosen), fill=False, edgecolor=ink, linewidth=0.8))


def is_light(colour: str) -> bool:
    """Whether black is read on a colour better than white."""
    r, g, b = (int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5))
    return 0.2126 * r + 0.7152 * g + 0.0722 * b >= 0.45


def _boxes(chosen: BoolArray) -> Path:
    row, column = np.nonzero(chosen)
    corners = np.stack(
        [np.stack([column + x, row + y], axis=1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1), (0, 0))], 1
    )
    codes = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY] * len(row)
    return Path(corners.reshape(-1, 2).astype(np.float64), codes)


def _bars(chosen: BoolArray) -> Path:
    row, column = np.nonzero(chosen)
    ends = np.stack([np.stack([column + x, row + 0.5], axis=1) for x in (0.25, 0.75)], axis=1)
    return Path(ends.reshape(-1, 2), [Path.MOVETO, Path.LINETO] * len(row))


def size_bar(figure: Figure, colours: Colours, place: Place, label: str, least: float) -> None:
    """The scale of `size_colours`; `least` is the smallest size that is shown by it."""
    first, last = math.ceil(math.log10(colours.low) - 1e-9), math.floor(math.log10(colours.high) + 1e-9)
    axes = _bar(figure, colours, place, label, [10.0**e for e in _ends_first(last, first)])
    if least < colours.low:  # the darkest colour stands for all that is less
        axes.plot([0.0], [0.5], transform=axes.transAxes, marker="<", color="black", markersize=4.5, clip_on=False)


def signed_bar(figure: Figure, colours: Colours, place: Place, label: str) -> None:
    """The scale of `signed_colours`, its ticks above it."""
    top = math.floor(math.log10(colours.high) + 1e-9)
    tens = [10.0**e for e in _ends_first(top, top - SIGNED_DECADES + 1)]
    _bar(figure, colours, place, label, [0.0, *(sign * ten for ten in tens for sign in (-1, 1))])


def _ends_first(top: int, bottom: int) -> list[int]:
    """Exponents in the order in which they are worth a tick."""
    return list(dict.fromkeys([top, bottom, *range(top, bottom, -1)])) if top > bottom else [top]


def signed_power(value: float) -> str:
    """Tick label of a decade of either sign."""
    return "0" if value == 0.0 else power_of_ten(value) if value > 0.0 else f"−{power_of_ten(-value)}"


def _bar(figure: Figure, colours: Colours, place: Place, label: str, ticks: Sequence[float]) -> Axes:
    """Steps of colour, with those of the ticks that there is room for, the first of them first."""
    width, height = (float(v) for v in figure.get_size_inches())
    left, bottom, wide = place
    axes = figure.add_axes((left / width, bottom / height, wide / width, _BAR / height))
    for step, colour in enumerate(colours.steps(_STEPS)):
        # a hair wider than its step: no background between neighbours
        wider = 1.5 if step < _STEPS - 1 else 1.0
        x = np.array([step, step, step + wider, step + wider]) / _STEPS
        axes.fill(x, [0.0, 1.0, 1.0, 0.0], facecolor=colour, linewidth=0)
    shown: list[tuple[float, str, float]] = []
    for tick in ticks:
        words = signed_power(tick)
        at, half = colours.place(tick), text_width(words, SMALL) / 2
        if all(abs(at - other) * wide > half + reach + 0.05 for other, _, reach in shown):
            shown.append((at, words, half))
    axes.set(xlim=(0, 1), ylim=(0, 1), yticks=[])
    axes.set_xticks([at for at, _, _ in shown], [words for _, words, _ in shown], fontsize=SMALL)
    axes.xaxis.set_ticks_position("top")
    axes.xaxis.set_label_position("top")
    axes.tick_params(pad=1, length=2.5)
    axes.set_xlabel(label, fontsize=9)
    return axes
