"""One look for all figures, and SVG files whose bytes depend on nothing but the figure."""

from __future__ import annotations

import io
import math
import warnings
from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from tedm_cli import __version__
from tedm_cli.figures.drawing import minor_ticks
from tedm_cli.figures.drawing.fit import line_count, wrapped
from tedm_cli.results.wording import SUPERSCRIPT

# Okabe and Ito (2008) without yellow, which vanishes as a line on white; neighbours differ in grey.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
BLUE, VERMILION = COLOURS[:2]
# In units of the width of the line. All are unlike in the length of a dash or in what stands between dashes, and a
# sample of `KEY` shows about two periods of each.
DASHES: tuple[Any, ...] = (
    "-",
    (0, (5, 2)),
    (0, (1.2, 1.4)),
    (0, (5, 1.5, 1.2, 1.5)),
    (0, (9, 2.5)),
    (0, (5, 1.4, 1.2, 1.4, 1.2, 1.4)),
    (0, (2.6, 3.2)),
)
# For curves that may coincide: wide and light below narrow and dark, so that each shows through the next.
STACK: tuple[tuple[str, float, Any], ...] = (
    ("#56B4E9", 4.4, "-"),
    ("#E69F00", 3.0, DASHES[1]),
    ("#0072B2", 1.9, DASHES[2]),
    ("#D55E00", 1.2, DASHES[3]),
    ("#000000", 1.1, DASHES[4]),
    ("#CC79A7", 3.4, DASHES[6]),
    ("#009E73", 2.2, DASHES[5]),
    ("#7A5C3E", 0.9, "-"),
)
_MARKERS = ("", "s", "^", "D")
BAND, BAND_GREY = "#EDEDED", "#808080"
BAND_EDGE: dict[str, Any] = {"linewidth": 0.9, "linestyle": (0, (1, 2))}
WIDTH = 7.0  # inches: a figure this wide stands on A4 in its own size
SMALL, TITLE = 8.8, 10.5  # points: no type is smaller, for the size on the page (see `spec`)
LINE = 0.147  # inches from one line of SMALL type to the next
KEY = 4.6  # length of a line in a key, in sizes of its type: long enough for two periods of any dashes
ENVELOPE: dict[str, Any] = {"facecolor": (*to_rgb(BLUE), 0.18), "edgecolor": BLUE, "linewidth": 0.5}  # of bounds
FLIGHT = "#8C6BB1"  # what was measured in flight

_RC: dict[str, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],  # ships with matplotlib: the same layout on every machine
    "font.size": 9.5,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "axes.labelsize": 9.5,
    "axes.linewidth": 0.8,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "legend.fontsize": SMALL,
    "legend.handlelength": KEY,
    "legend.frameon": False,
    "lines.solid_capstyle": "round",
    "text.parse_math": False,  # names and titles come from the user's files
    "svg.fonttype": "none",  # text stays text: searchable, and a third of the size
    "svg.hashsalt": "tedm",
    "pdf.fonttype": 42,  # TrueType: journals refuse type 3
}


def series_look(i: int, colours: Sequence[str] = COLOURS) -> dict[str, Any]:
    """Colour, dashes and, once these begin again, marks of series number `i`: told apart in grey as well."""
    return {
        "color": colours[i % len(colours)],
        "linestyle": DASHES[i % len(DASHES)],
        "marker": _MARKERS[i // len(DASHES) % len(_MARKERS)],
        "markersize": 4.5,
        "markevery": 0.12,
    }


def style() -> Any:
    """Context in which figures are made and saved."""
    settings: dict[Any, Any] = {**mpl.rcParamsDefault, **_RC, "backend": "agg"}  # whatever the user's matplotlibrc says
    return mpl.rc_context(settings)


def svg(figure: Figure, title: str, sources: Sequence[str]) -> bytes:
    """The figure as SVG. `sources` says what it was drawn from, and can be read back with `sources_of`."""
    return _saved(figure, "svg", {"Date": None, **_metadata("Creator", title, sources)})


def png(figure: Figure, title: str, sources: Sequence[str]) -> bytes:
    """The figure as PNG in its own resolution, with the same metadata."""
    return _saved(figure, "png", _metadata("Software", title, sources))


def pdf(figure: Figure, title: str, sources: Sequence[str]) -> bytes:
    """The figure as PDF with its fonts embedded as TrueType; `sources` are its keywords."""
    metadata = _metadata("Creator", title, sources)
    metadata["Keywords"] = metadata.pop("Source")
    return _saved(figure, "pdf", {"CreationDate": None, **metadata})


def _metadata(maker: str, title: str, sources: Sequence[str]) -> dict[str, str]:
    return {"Title": title, maker: f"tedm {__version__}, matplotlib {mpl.__version__}", "Source": "; ".join(sources)}


def _saved(figure: Figure, form: str, metadata: dict[str, Any]) -> bytes:
    stream = io.BytesIO()
    with style(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing")  # text of an SVG is drawn by whoever shows it
        figure.savefig(stream, format=form, metadata=metadata)
    return stream.getvalue()


def power_of_ten(value: float, _position: int | None = None) -> str:
    """Tick label of a decade, without mathematical type."""
    if value <= 0:
        return ""
    exponent = round(math.log10(value))
    return "1" if exponent == 0 else "10" + str(exponent).translate(SUPERSCRIPT)


def heading_lines(text: str, more: str, width: float = WIDTH) -> tuple[str, str, float]:
    """A heading in bold and what is said below it, broken into lines, and the inches that they take."""
    first = wrapped(text, (width - 0.2) / 1.16, TITLE)  # bold type is wider than what is measured
    then = "\n".join(wrapped(line, width - 0.2, SMALL) for line in more.split("\n"))
    return first, then, 0.1 + 0.175 * line_count(first) + (0.04 + LINE * line_count(then) if then else 0.0)


def heading(figure: Figure, text: str, *, more: str = "") -> None:
    """A title in the upper left corner, and `more` in small type below it; `heading_lines` says what they take."""
    width, height = (float(v) for v in figure.get_size_inches())
    first, then, _ = heading_lines(text, more, width)
    figure.text(0.08 / width, 1 - 0.08 / height, first, fontsize=TITLE, va="top", fontweight="bold")
    down = 0.12 + 0.175 * line_count(first)
    figure.text(0.08 / width, 1 - down / height, then, fontsize=SMALL, va="top")


def ratio_axis(axis: Any, low: float, high: float) -> None:
    """Logarithmic ticks for ratios: decades, and 2 and 5 as well where there are few of them."""
    few = high / low < 20
    axis.set_major_locator(LogLocator(base=10, subs=(1.0, 2.0, 5.0) if few else (1.0,), numticks=9))
    axis.set_major_formatter(FuncFormatter((lambda v, _: f"{v:g}") if few else power_of_ten))
    axis.set_minor_formatter(NullFormatter())


def log_axis(axis: Any, *, decades: float, label: str) -> None:
    """Decades labelled, minor ticks where there is room for them."""
    axis.set_major_locator(LogLocator(base=10, numticks=9))
    axis.set_major_formatter(FuncFormatter(power_of_ten))
    axis.set_minor_locator(LogLocator(base=10, subs=range(2, 10), numticks=99 if decades <= 4 else 2))
    axis.set_minor_formatter(NullFormatter())
    axis.set_label_text(label)


def frequency_axis(axes: Axes, low_hz: float, high_hz: float) -> None:
    """Logarithmic frequencies in mHz; the data are in mHz too."""
    axes.set_xscale("log")
    axes.set_xlim(low_hz * 1e3, high_hz * 1e3)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("frequency (mHz)")


def grid(axes: Axes) -> None:
    """Grid lines of major and minor ticks; the scales and their ticks are set by now."""
    minor_ticks.at_once(axes)
    axes.grid(True, which="major", color="#CFCFCF", linewidth=0.6)
    axes.grid(True, which="minor", color="#EBEBEB", linewidth=0.4)


def inches(figure: Figure, *, left: float, right: float, top: float, bottom: float, wspace: float = 0.2) -> None:
    """Margins in inches, so that labels keep their room whatever the size of the figure."""
    width, height = figure.get_size_inches()
    figure.subplots_adjust(
        left=left / width, right=1 - right / width, top=1 - top / height, bottom=bottom / height, wspace=wspace
    )
