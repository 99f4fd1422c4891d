"""Minor ticks drawn at once are the ticks that matplotlib draws one by one."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from tedm_cli.figures.drawing import minor_ticks
from tedm_cli.figures.drawing.style import style

# Grid lines of the two axes cross in another order: the greys of _look, one over the other.
CROSSING = 30


def _look(axes: Axes, span: tuple[float, float], scales: str) -> None:
    axes.set_xlim(*span)
    axes.set_ylim(1.0, 2e3)
    for name, axis in (("x", axes.xaxis), ("y", axes.yaxis)):
        if name in scales:
            getattr(axes, f"set_{name}scale")("log")
            axis.set_minor_locator(LogLocator(subs=range(2, 10), numticks=99))
            axis.set_minor_formatter(NullFormatter())
    axes.grid(True, which="major", color="#CFCFCF", linewidth=0.6)
    axes.grid(True, which="minor", color="#EBEBEB", linewidth=0.4)


def _pixels(
    span: tuple[float, float], scales: str, length: float | None, at_once: bool
) -> tuple[np.ndarray, list[int]]:
    with style():
        figure = Figure(figsize=(4, 3))
        axes = figure.add_axes((0.2, 0.2, 0.7, 0.7))
        _look(axes, span, scales)
        if at_once:
            minor_ticks.at_once(axes)
        if length is not None:
            axes.tick_params(which="minor", length=length)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        made = [len(axis.get_minorticklocs()) for axis in (axes.xaxis, axes.yaxis)]
        return np.asarray(canvas.buffer_rgba())[..., :3].astype(int), made


@pytest.mark.parametrize(("scales", "length"), [("xy", None), ("xy", 0.0), ("x", 6.0), ("y", 6.0)])
@pytest.mark.parametrize("span", [(0.3, 4e2), (4e2, 0.3), (2.1, 2.9)], ids=["decades", "inverted", "without a decade"])
def test_the_picture_is_the_same(span: tuple[float, float], scales: str, length: float | None) -> None:
    one_by_one, many = _pixels(span, scales, length, at_once=False)
    at_once, none = _pixels(span, scales, length, at_once=True)
    assert none == [0, 0]
    assert sum(many) > 3 or scales == "x"
    off = np.abs(at_once - one_by_one)
    assert off.max() <= CROSSING
    assert (off > 0).any(axis=-1).mean() < 0.01


def test_without_them_it_is_another() -> None:
    """The comparison sees a tick: of other lengths the pictures differ by more than crossings do."""
    short, _ = _pixels((0.3, 4e2), "xy", 2.0, at_once=True)
    long, _ = _pixels((0.3, 4e2), "xy", 6.0, at_once=True)
    assert np.abs(short - long).max() > 5 * CROSSING
