"""view, the series: measured or simulated temperatures of the configuration, thinned so that they can be played."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.project import Project
from tedm_cli.config.series import SeriesTable
from tedm_cli.files.build_folder import require_input
from tedm_cli.files.provenance import input_files
from tedm_cli.noise.series import Trend
from tedm_cli.results.build_folder import Results
from tedm_cli.results.outputs import ModelOutputs
from tedm_cli.results.thermal.nodes import node_outputs
from tedm_cli.results.wording import count
from tedm_cli.stages.reporting.view_nodes import ShownNodes
from tedm_cli.stages.temperature_series import SeriesColumns, open_series, removed_words, series_files
from tedm_cli.view.payload import Film

MOST_SAMPLES = 400


def series_films(
    project: Project, results: Results, of_model: ModelOutputs, nodes: ShownNodes | None
) -> list[tuple[str, Film]]:
    """Every series that has been run, by name; of thermal nodes where the page has these.

    Raises
    ------
    InputError : a table is not the one that the series was run on; what `node_outputs` refuses.
    """
    films = []
    for table in results.config.series:
        if table.name not in results.series or (table.of == "nodes" and nodes is None):
            continue
        for used in input_files(series_files(project, table)):
            require_input(results.series[table.name], used)
        columns = SeriesColumns(of_model.areas)
        if table.of == "nodes":
            found = node_outputs(project, of_model, f"series {table.name}")
            columns = SeriesColumns(found.outputs.areas, found.network)
        films.append((table.name, _film(project, table, columns, nodes)))
    return films


def _film(project: Project, table: SeriesTable, columns: SeriesColumns, nodes: ShownNodes | None) -> Film:
    with open_series(project, table, columns, f"{project.cases}: series {table.name}") as (wide, read):
        time: list[FloatArray] = []
        kept: list[FloatArray] = []
        number: list[FloatArray] = []
        trend, every, start = Trend(len(wide.columns)), 1, read.start
        for block in wide.blocks():
            if start is None:
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
    values = read.parts @ by_column.T
    if nodes is not None:
        values = nodes.columns(values) if table.of == "nodes" else nodes.padded(values)
    taken = "every sample" if every == 1 else f"every {every}th sample"
    shown = count(len(places), "sample")
    words = f"{Path(table.file).name}, {taken} ({shown} of {trend.count:,}), {removed_words(table, read.unit)}"
    return Film.of(np.concatenate(time), values, words)


def _thinned(parts: list[FloatArray], number: list[FloatArray], every: int) -> list[FloatArray]:
    """Those rows whose numbers are multiples of `every`."""
    return [p[n % every == 0] for p, n in zip(parts, number, strict=True)]
