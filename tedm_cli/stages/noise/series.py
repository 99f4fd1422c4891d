"""run-series: a temperature time series to the time series and spectra of all outputs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from tedm_cli.config.cases import load_cases
from tedm_cli.config.differences import require_parallel
from tedm_cli.config.halves import halves_of
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.config.series import SeriesTable
from tedm_cli.contracts import SERIES
from tedm_cli.errors import ConfigError
from tedm_cli.files.build_folder import provenance, series_file_name
from tedm_cli.files.scratch import scratch_file
from tedm_cli.files.store import create
from tedm_cli.noise.case_run import judged_outputs
from tedm_cli.noise.log_spectrum import require_speckit
from tedm_cli.progress import Step
from tedm_cli.results.areas import write_areas
from tedm_cli.results.outputs import read_outputs
from tedm_cli.results.thermal.nodes import node_outputs
from tedm_cli.stages.series_result import Regular, SeriesResult, judge_all, store, welch_segment, write_result
from tedm_cli.stages.temperature_series import SeriesColumns, run_each, sample_series, series_files, treatment_words


def run_series(
    project: Project,
    names: Sequence[str],
    output: Path | None,
    step: Step,
    done: Callable[[SeriesResult], None] = lambda result: None,
) -> None:
    """Propagate the series of these names and write one file each; `done` is told of each.

    A series that is refused does not keep the others from being run: the first refusal is raised at the end.
    """
    file, config = load_cases(project.cases)
    requirements = config.applied_requirements()
    model = load_model(project.model)[1]
    halves_of(project, model).require_judgeable(requirements, where=project.cases)
    require_parallel(project, requirements, model)
    of_model = read_outputs(project)
    outputs = of_model.with_differences(requirements)
    labels, units, kinds = list(outputs.labels), list(outputs.units), list(outputs.kinds)
    try:
        judged_outputs(config.criteria(), outputs, config.frequency_hz())
    except ConfigError as error:
        raise ConfigError(error.problems, where=str(project.cases)) from None

    def run(table: SeriesTable) -> None:
        path = output if output is not None else project.build_dir / series_file_name(table.name)
        source, *weights = series_files(project, table)
        if table.spectrum == "log":
            require_speckit()
        by, sources, columns = outputs, [*outputs.sources, source, *weights], SeriesColumns(outputs.areas)
        if table.of == "nodes":
            found = node_outputs(project, of_model, f"series {table.name}")
            by = found.outputs.with_differences(requirements)
            sources, columns = [*sources, found.source], SeriesColumns(by.areas, found.network)
        trace = provenance([file], sources)
        path.parent.mkdir(parents=True, exist_ok=True)
        where = f"{project.cases}: series {table.name}"
        with scratch_file(path) as scratch:
            sampled = sample_series(project, table, columns, by.rows, where, scratch)
            n, step_s = sampled.samples, sampled.step_s
            segment = welch_segment(n, step_s, sampled.highest_hz, table, config.lowest_band_hz(), source)
            with create(path, SERIES, trace) as writer:
                series = Regular(
                    lambda: sampled.blocks(table.remove), len(labels), n, sampled.first_s, step_s, sampled.highest_hz
                )
                targets = [(SERIES.SERIES.of(label), unit) for label, unit in zip(labels, units, strict=True)]
                rms, peak, estimate = store(writer, series, targets, table.spectrum, segment)
                verdicts, unjudged = judge_all(estimate, labels, kinds, requirements, config.safety_factor)
                result = SeriesResult(
                    path, table.name, source, labels, units, kinds, rms, peak, sampled.first_s, step_s, n, estimate,
                    verdicts, unjudged, config.safety_factor, table.confidence,
                    treatment_words(table, columns, sampled),
                )  # fmt: skip
                write_areas(writer, by.areas, by.area_id)
                write_result(writer, result, sampled.column)
        done(result)

    run_each(config, names, run, step, "running series")
