"""view, the series: measured or simulated temperatures of the configuration, thinned so that they can be played."""

from __future__ import annotations

from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.project import Project
from tedm_cli.config.series import SeriesTable
from tedm_cli.files.build_folder import require_input
from tedm_cli.files.provenance import input_files
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.columns import columns_of_areas
from tedm_cli.noise.series import Trend
from tedm_cli.quantities import TEMPERATURE, TIME_STAMP
from tedm_cli.results.build_folder import Results
from tedm_cli.results.wording import count
from tedm_cli.tables.wide_table import open_wide
from tedm_cli.view.payload import Film

MOST_SAMPLES = 400
_REMOVED = {"nothing": "nothing removed", "mean": "mean removed", "linear": "mean and linear trend removed"}


def series_films(project: Project, results: Results, areas: AreaTable) -> list[tuple[str, Film]]:
    """Every series that has been run, by name.

    Raises
    ------
    InputError : a table is not the one that the series was run on.
    """
    films = []
    for table in results.config.series:
        if table.name in results.series:
            source = project.cases.parent / table.file
            require_input(results.series[table.name], input_files([source])[0])
            films.append((table.name, _film(source, table, areas)))
    return films


def _film(source: Path, table: SeriesTable, areas: AreaTable) -> Film:
    patterns = table.constant or []
    moving = np.array([not any(fnmatchcase(name, p) for p in patterns) for name in areas.name.tolist()])
    with open_wide(source, "time_s", TIME_STAMP, TEMPERATURE) as wide:
        index = columns_of_areas(wide.columns, areas, moving, where=str(source))
        time: list[FloatArray] = []
        kept: list[FloatArray] = []
        number: list[FloatArray] = []
        trend, every, start = Trend(len(wide.columns)), 1, np.zeros(len(wide.columns))
        for block in wide.blocks():
            if trend.count == 0 and table.remove != "nothing":
                start = block.values[0]  # absolute temperatures would cost digits
            values = block.values - start
            place = np.arange(trend.count, trend.count + len(values))
            chosen = place % every == 0
            time.append(block.key[chosen])
            kept.append(values[chosen])
            number.append(place[chosen].astype(np.float64))
            trend.add(values)
            while sum(map(len, time)) > 2 * MOST_SAMPLES:
                every *= 2
                time, kept, number = (_thinned(parts, number, every) for parts in (time, kept, number))
    every *= max(1, -(-trend.count // (every * MOST_SAMPLES)))
    time, kept, number = (_thinned(parts, number, every) for parts in (time, kept, number))
    base, slope = trend.line(table.remove)
    places = np.concatenate(number)
    by_column = np.concatenate(kept) - base - slope * places[:, None]
    values = np.where(index[:, None] >= 0, by_column[:, index].T, 0.0)
    taken = "every sample" if every == 1 else f"every {every}th sample"
    words = f"{source.name}, {taken} ({count(len(places), 'sample')} of {trend.count:,}), {_REMOVED[table.remove]}"
    return Film.of(np.concatenate(time), values, words)


def _thinned(parts: list[FloatArray], number: list[FloatArray], every: int) -> list[FloatArray]:
    """Those rows whose numbers are multiples of `every`."""
    return [p[n % every == 0] for p, n in zip(parts, number, strict=True)]
