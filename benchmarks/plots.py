"""Figures of growth in grids and in areas, with the exponents through three sizes."""

from __future__ import annotations

from collections.abc import Callable

from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter

from benchmarks.growth import column, exponent, tasks_of
from benchmarks.record import Record
from tedm_cli.figures.drawing.style import grid, series_look, style, svg

_PANELS = (
    ("processor_s", "seconds of processor"),
    ("anonymous_mb", "anonymous memory (MB)"),
    ("resident_mb", "resident memory (MB)"),
)
_TICKS = tuple(m * 10.0**n for n in range(-3, 6) for m in (1, 2, 5))


def exponents(record: Record, task: str, size: str) -> str:
    """Of time, anonymous and resident memory, as the key says them."""
    found = (exponent(*column(record.rows, task, key, size)) for key, _ in _PANELS)
    return ", ".join(f"{round(value, 2) + 0.0:.2f}" for value in found)  # + 0.0: no -0.00


def _growth(record: Record, size: str, held: int, of: str) -> bytes:
    """Seconds of processor, anonymous and resident memory of every stage against a size."""
    tasks = tasks_of(record.rows)
    with style():
        figure = Figure(figsize=(7.6, 5.0), layout="constrained")
        for axes, (key, label) in zip(figure.subplots(1, len(_PANELS)), _PANELS, strict=True):
            for place, task in enumerate(tasks):
                sizes, values = column(record.rows, task, key, size)
                look = {**series_look(place), "marker": "o", "markersize": 4}
                look.pop("markevery", None)
                told = f"{task}: {exponents(record, task, size)}"
                axes.plot(sizes, values, **look, label=told if key == _PANELS[0][0] else None)
            axes.set_xscale("log")
            axes.set_yscale("log")
            for axis, places in ((axes.xaxis, sizes), (axes.yaxis, _TICKS)):
                axis.set_major_locator(FixedLocator(places))
                axis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:,.0f}" if v >= 1 else f"{v:g}"))
                axis.set_minor_formatter(NullFormatter())
            axes.tick_params(axis="x", labelsize=8)
            axes.minorticks_off()
            axes.set_xlabel(size)
            axes.set_ylabel(label)
            grid(axes)
        title = "exponents of time, anonymous and resident memory"
        figure.legend(loc="outside lower center", ncols=2, fontsize=8.8, title=title)
        figure.suptitle(f"Growth in {size} at {held:,} {of}", x=0.01, ha="left", fontweight="bold", fontsize=10)
        return svg(figure, f"Growth in {size}", [f"benchmarks/results/{record.name}.json"])


def _grids(record: Record) -> bytes:
    return _growth(record, "grids", record.rows[0]["areas"], "areas")


def _areas(record: Record) -> bytes:
    return _growth(record, "areas", record.rows[0]["grids"], "grids")


#: File name: the set of results that it shows, and how.
FIGURES: dict[str, tuple[str, Callable[[Record], bytes]]] = {
    "growth_grids.svg": ("grids", _grids),
    "growth_areas.svg": ("areas", _areas),
}
