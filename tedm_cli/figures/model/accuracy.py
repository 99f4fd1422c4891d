"""Figures of the accuracy studies: isolines of an error, and the convergence of a mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from tedm_cli.arrays import FloatArray
from tedm_cli.figures.drawing.style import BLUE, VERMILION, grid, style, svg


@dataclass(frozen=True, kw_only=True)
class Isolines:
    """Errors in percent over a plane, [panel][y, x]; `guideline` is a slope y/x to draw, `edge` an x to mark."""

    title: str
    x_label: str
    y_label: str
    x: FloatArray
    y: FloatArray
    panels: dict[str, FloatArray]
    guideline: float | None = None
    edge: float | None = None


@dataclass(frozen=True, kw_only=True)
class Convergence:
    """A value and its error in percent against the number of nodes."""

    title: str
    value_label: str
    nodes: FloatArray
    value: FloatArray
    exact: float
    error_percent: FloatArray


def draw(data: Isolines | Convergence) -> bytes:
    """The figure as SVG."""
    with style():
        figure = _isolines(data) if isinstance(data, Isolines) else _convergence(data)
        figure.suptitle(data.title, x=0.01, ha="left", fontweight="bold")
        return svg(figure, data.title, [])


def _isolines(data: Isolines) -> Figure:
    count = len(data.panels)
    figure = Figure(figsize=(1.2 + 4.3 * count, 4.0), layout="constrained")
    for axes, (name, error) in zip(figure.subplots(1, count, squeeze=False)[0], data.panels.items(), strict=True):
        # a positive floor for the logarithm: errors below it are rounding
        shown = np.maximum(error, 1e-14)
        lines = axes.contour(data.x, data.y, shown, levels=_levels(shown), colors=BLUE, linewidths=0.9)
        axes.clabel(lines, fmt=FuncFormatter(lambda v, _: f"{v:.0e} %" if v < 1e-3 else f"{v:g} %"), fontsize=7)
        if data.guideline is not None:
            axes.plot(
                data.x, data.guideline * data.x, color=VERMILION, linewidth=1.8, label=f"y = {data.guideline:g} x"
            )
            axes.legend(loc="upper left")
        if data.edge is not None:
            axes.axvline(data.edge, color="#555555", linewidth=1.8)
            axes.annotate(
                "face of the test mass",
                (data.edge, data.y[-1]),
                xytext=(4, -4),
                textcoords="offset points",
                rotation=90,
                va="top",
                fontsize=8,
                color="#555555",
            )
        axes.set(xlabel=data.x_label, ylabel=data.y_label, title=name, ylim=(data.y[0], data.y[-1]))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
        axes.set_xlim(min(data.x[0], data.edge or data.x[0]), data.x[-1])
    return figure


def _levels(error: FloatArray) -> list[float]:
    """1, 2 and 5 of every decade where there are few of them, else powers of ten."""
    low, high = float(np.nanmin(error)), float(np.nanmax(error))
    subs = (1.0, 2.0, 5.0) if high < 1e4 * low else (1.0,)
    return [float(v) for v in LogLocator(subs=subs, numticks=100).tick_values(low, high) if low <= v <= high] or [high]


def _convergence(data: Convergence) -> Figure:
    figure = Figure(figsize=(9.0, 4.0), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot(data.nodes, data.value, ".-", color=BLUE, label="nodal masses")
    left.axhline(data.exact, color=VERMILION, linewidth=1.0, label="graded quadrature")
    left.legend()
    left.set(xlabel="number of nodes", ylabel=data.value_label, xscale="log")
    right.plot(data.nodes, data.error_percent, ".-", color=BLUE)
    right.set(xlabel="number of nodes", ylabel="error [%]", xscale="log", yscale="log")
    for axis in (left.xaxis, right.xaxis, right.yaxis):
        axis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
        axis.set_minor_formatter(NullFormatter())
    grid(right)
    return figure
