"""Figures of growth in grids and in areas, with the exponents through three sizes."""

from __future__ import annotations

from collections.abc import Callable

from matplotlib.figure import Figure

from benchmarks.growth import column, exponent, tasks_of
from benchmarks.record import Record
from tedm_cli.figures.style import grid, series_look, style, svg


def _growth(record: Record, size: str, held: int, of: str) -> bytes:
    """Seconds of processor and anonymous memory of every stage against a size."""
    tasks = tasks_of(record.rows)
    with style():
        figure = Figure(figsize=(7.6, 5.4), layout="constrained")
        panels = zip(
            figure.subplots(1, 2),
            (("processor_s", "seconds of processor"), ("anonymous_mb", "anonymous memory (MB)")),
            strict=True,
        )
        for axes, (key, label) in panels:
            for place, task in enumerate(tasks):
                sizes, values = column(record.rows, task, key, size)
                look = {**series_look(place), "marker": "o", "markersize": 4}
                look.pop("markevery", None)
                axes.plot(sizes, values, **look, label=f"{task}: {exponent(sizes, values):.2f}")
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.set_xticks(sizes, [f"{n:,.0f}" for n in sizes])
            axes.minorticks_off()
            axes.set_xlabel(size)
            axes.set_ylabel(label)
            axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), fontsize=8, title="fitted exponent")
            grid(axes)
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
