"""Figure of a mesh audit: each element's size against its gap, coloured by the error it leaves."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter

from tedm_cli.arrays import FloatArray
from tedm_cli.figures.drawing.style import grid, power_of_ten, style, svg

_LOW, _HIGH = 1e-6, 1e2  # of the allowance: below, an element does not matter; above, more colour says no more


def audit_figure(
    size_m: FloatArray, gap_m: FloatArray, score: dict[str, FloatArray], title: str, sources: list[str]
) -> bytes:
    """One panel per mass model, as SVG.

    Parameters
    ----------
    size_m, gap_m : [E], longest extent, and gap to the nearest test mass, m.
    score : by mass model, [E], largest error of the element in any quantity over what the whole sum is allowed.
    sources : what the figure was drawn from.
    """
    with style():
        figure = Figure(figsize=(10.5, 4.4), layout="constrained")
        norm = LogNorm(_LOW, _HIGH)
        panels = figure.subplots(1, len(score), sharex=True, sharey=True, squeeze=False)[0]
        for axes, (name, value) in zip(panels, score.items(), strict=True):
            order = np.argsort(value, kind="stable")  # the worst on top
            dots = axes.scatter(
                1e3 * gap_m[order],
                1e3 * size_m[order],
                c=np.clip(value[order], _LOW, _HIGH),
                norm=norm,
                cmap="cividis",
                s=14,
                linewidths=0,
                rasterized=True,  # a large model would make a large file
            )
            ends = np.clip([10e3 * size_m.min(), 1e3 * gap_m.max()], 1e3 * gap_m.min(), None)
            axes.plot(ends, 0.1 * ends, color="black", linewidth=1.0, linestyle="--", label="size = 0.1 gap")
            axes.set_xscale("log")
            axes.set_yscale("log")
            for axis in (axes.xaxis, axes.yaxis):
                axis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
                axis.set_minor_formatter(NullFormatter())
            axes.set_xlabel("gap to the nearest test mass (mm)")
            above = int((value > 1.0).sum())
            axes.set_title(f"{name}\n{above:,} of {len(value):,} elements exceed the allowance alone")
            axes.legend(loc="upper left")
            grid(axes)
        bar = figure.colorbar(dots, ax=list(panels), extend="both", format=FuncFormatter(power_of_ten))
        panels[0].set_ylabel("size of the element (mm)")
        bar.set_label("error over 1 % of the requirement (1)")
        figure.suptitle(title, x=0.01, ha="left", fontweight="bold")
        return svg(figure, title, sources)
