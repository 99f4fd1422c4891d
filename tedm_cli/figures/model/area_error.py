"""Figure of how far areas of one temperature are from a temperature field, by their count and correlation length."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.figures.drawing.style import grid, series_look, style

_TICKS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0)


def area_error_figure(
    count: IntArray, error: FloatArray, now: int, error_now: FloatArray, length_mm: Sequence[float], title: str
) -> Figure:
    """Error against count: the largest of all correlation lengths, the shortest and the longest.

    Areas as they are now are dots.

    Parameters
    ----------
    count : [c]. error : [c, L], |ratio - 1| of the worst output. now : count of the present areas. error_now : [L].
    length_mm : [L], correlation lengths.
    """
    largest = ("largest of all lengths", error.max(axis=1), float(error_now.max()))
    lines = (
        [largest]
        if len(length_mm) == 1
        else [
            largest,
            *((f"ℓ = {length_mm[i]:g} mm", error[:, i], float(error_now[i])) for i in (0, len(length_mm) - 1)),
        ]
    )
    with style():
        figure = Figure(figsize=(7.6, 4.4), layout="constrained")
        axes = figure.subplots()
        for place, (label, values, value) in enumerate(lines):
            look = series_look(place)
            look.pop("markevery")
            width = 2.2 if place == 0 else 1.2
            axes.plot(count, 100 * values, **{**look, "marker": ""}, linewidth=width, label=label, zorder=3 - place)
            axes.plot(now, 100 * value, "o", color=look["color"], markersize=5 + 2 * (place == 0), zorder=4 - place)
        axes.plot([], [], "o", color="0.4", markersize=5, label=f"the {now} areas there are")
        axes.axhline(5.0, color="0.4", linewidth=0.8, linestyle=":")
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_ylim(bottom=0.1, top=max(100.0, 110 * float(error.max()), 110 * float(error_now.max())))
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(FixedLocator(_TICKS))
            axis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
            axis.set_minor_formatter(NullFormatter())
        axes.set_xlabel("thermal areas")
        axes.set_ylabel("error of a standard deviation, worst output (%)")
        axes.legend(loc="upper right")
        grid(axes)
        figure.suptitle(title, x=0.01, ha="left", fontweight="bold", fontsize=10)
        return figure
