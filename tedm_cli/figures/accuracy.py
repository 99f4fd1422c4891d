"""Figures of the accuracy studies: isolines of an error, and the convergence of a mesh."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Text stays text and names of elements do not change: the same data give the same bytes.
_SVG: Any = {"svg.fonttype": "none", "svg.hashsalt": "tedm", "font.size": 9.0}


@dataclass(frozen=True, kw_only=True)
class Isolines:
    """Errors in percent over a plane, [panel][y, x]; `guideline` is a slope y/x to draw, `edge` an x to mark."""

    title: str
    x_label: str
    y_label: str
    x: Array
    y: Array
    panels: dict[str, Array]
    guideline: float | None = None
    edge: float | None = None


@dataclass(frozen=True, kw_only=True)
class Convergence:
    """A value and its error in percent against the number of nodes."""

    title: str
    value_label: str
    nodes: Array
    value: Array
    exact: float
    error_percent: Array


def draw(data: Isolines | Convergence) -> bytes:
    """The figure as SVG."""
    with rc_context(_SVG):
        figure = _isolines(data) if isinstance(data, Isolines) else _convergence(data)
        stream = io.BytesIO()
        figure.savefig(stream, format="svg", metadata={"Date": None})
    return stream.getvalue()


def _isolines(data: Isolines) -> Figure:
    count = len(data.panels)
    figure = Figure(figsize=(1.2 + 4.3 * count, 4.0), layout="constrained")
    for axes, (name, error) in zip(figure.subplots(1, count, squeeze=False)[0], data.panels.items(), strict=True):
        # a positive floor for the logarithm: errors below it are rounding
        shown = np.maximum(error, 1e-14)
        lines = axes.contour(data.x, data.y, shown, levels=_levels(shown), colors="#1f4e79", linewidths=0.9)
        axes.clabel(lines, fmt=FuncFormatter(lambda v, _: f"{v:.0e} %" if v < 1e-3 else f"{v:g} %"), fontsize=7)
        if data.guideline is not None:
            axes.plot(
                data.x, data.guideline * data.x, color="#b03a2e", linewidth=1.8, label=f"y = {data.guideline:g} x"
            )
            axes.legend(loc="upper left")
        if data.edge is not None:
            axes.axvline(data.edge, color="#555555", linewidth=1.8)
            axes.annotate("face", (data.edge, data.y[-1]), xytext=(3, -10), textcoords="offset points")
        axes.set(xlabel=data.x_label, ylabel=data.y_label, title=name, ylim=(data.y[0], data.y[-1]))
        axes.set_xlim(min(data.x[0], data.edge or data.x[0]), data.x[-1])
    figure.suptitle(data.title)
    return figure


def _levels(error: Array) -> list[float]:
    """1, 2 and 5 of every decade where there are few of them, else powers of ten."""
    low, high = float(np.nanmin(error)), float(np.nanmax(error))
    subs = (1.0, 2.0, 5.0) if high < 1e4 * low else (1.0,)
    return [float(v) for v in LogLocator(subs=subs, numticks=100).tick_values(low, high) if low <= v <= high] or [high]


def _convergence(data: Convergence) -> Figure:
    figure = Figure(figsize=(9.0, 4.0), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot(data.nodes, data.value, ".-", color="#1f4e79", label="nodal masses")
    left.axhline(data.exact, color="#b03a2e", linewidth=1.0, label="graded quadrature")
    left.legend()
    left.set(xlabel="number of nodes", ylabel=data.value_label, xscale="log")
    right.plot(data.nodes, data.error_percent, ".-", color="#1f4e79")
    right.set(xlabel="number of nodes", ylabel="error [%]", xscale="log", yscale="log")
    right.grid(True, which="both", linewidth=0.3)
    figure.suptitle(data.title)
    return figure
