"""Figure of how thermal areas tell a temperature field, over its correlation length."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter

from tedm_cli.arrays import FloatArray
from tedm_cli.figures.drawing.style import grid, series_look, style


def field_ratio_figure(length_mm: FloatArray, ratio: Mapping[str, FloatArray], title: str) -> Figure:
    """Ratio of root mean squares, by the areas over the field's, against the correlation length; 1 is a line.

    Parameters
    ----------
    length_mm : [L]. ratio : by output, [L].
    """
    with style():
        figure = Figure(figsize=(7.6, 4.2), layout="constrained")
        axes = figure.subplots()
        for place, (label, values) in enumerate(ratio.items()):
            axes.plot(length_mm, values, **{**series_look(place), "markevery": 1, "marker": "o"}, label=label)
        axes.axhline(1.0, color="0.4", linewidth=0.8, linestyle=":")
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(FixedLocator(length_mm.tolist()))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.set_ylim(0.0, 1.1 * max(1.0, *(float(v.max()) for v in ratio.values())))
        axes.set_xlabel("correlation length of the field (mm)")
        axes.set_ylabel("rms by the areas over that of the field (1)")
        axes.legend(loc="best")
        grid(axes)
        figure.suptitle(title, x=0.01, ha="left", fontweight="bold", fontsize=10)
        return figure
