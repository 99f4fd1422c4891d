"""Commands on temperature noise and its verdicts. Stages are imported inside, so that --help is quick."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import typer

from tedm_cli.cli.app import answer, app, open_project
from tedm_cli.cli.headings import examples
from tedm_cli.cli.options import (
    DEFAULT_BUILD,
    DEFAULT_CONFIG,
    DEFAULT_TOP,
    BuildDir,
    Cases,
    CompareMesh,
    Config,
    FailOnViolation,
    Json,
    Output,
    Quiet,
    Series,
    Top,
    Verbose,
    rows,
)

if TYPE_CHECKING:
    from tedm_cli.stages.noise.case import CaseDone
    from tedm_cli.stages.series_result import SeriesResult


@app.command(
    "run-case",
    epilog=examples("tedm run-case 3", "tedm run-case all --fail-on-violation", "tedm run-case 3 -v --top 5"),
)
def run_case(
    case: Cases,
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    fail_on_violation: FailOnViolation = False,
    compare_mesh: CompareMesh = None,
    top: Top = DEFAULT_TOP,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Noise spectra and verdicts of cases.

    Propagates the temperature noise of correlation cases to all outputs, exactly, and judges the requirements. With -v
    also contributors, what would bring each verdict down, and how it depends on filter, correlation and safety factor.
    Where the configuration has uncertainties, each verdict comes with a probability.
    All cases are held against the model first: what does not fit is told at once, and keeps no other from being run.
    """
    from tedm_cli.cli.printing.case import case_dict, case_lines
    from tedm_cli.cli.printing.contributors import comparison_lines, contributor_lines, more_dict, sensitivity_table
    from tedm_cli.cli.printing.series import realisation_line
    from tedm_cli.cli.printing.uncertainty import uncertainty_lines
    from tedm_cli.cli.streams import refusal_lines
    from tedm_cli.cli.streams import tell as tell_lines
    from tedm_cli.config.cases import select_cases
    from tedm_cli.config.uncertainty import MeshDeviation
    from tedm_cli.errors import PhysicsError, TedmError, UsageError
    from tedm_cli.progress import progress
    from tedm_cli.results.cases.uncertainty import as_dict
    from tedm_cli.stages.noise.case import run_cases

    project = open_project(config, build_dir, verbose)
    compare = None if compare_mesh is None else MeshDeviation(other=str(compare_mesh))
    ids = select_cases(project.cases, case)
    if output is not None and len(ids) != 1:
        raise UsageError(f"--output names one file, but {len(ids)} cases are run")
    done: list[CaseDone] = []
    told: list[TedmError] = []
    refused: TedmError | None = None

    def tell(error: TedmError) -> None:
        tell_lines(refusal_lines(error))
        told.append(error)

    try:
        with progress(quiet) as step:
            run_cases(project, ids, output, step, done.append, tell, compare)
    except TedmError as error:
        if not done:
            raise
        refused = error

    def lines() -> Iterator[str]:
        for one in done:
            yield from case_lines(one.path, one.result)
            if one.realised is not None:
                yield realisation_line(one.realised)
            if one.uncertainty is not None:
                yield from uncertainty_lines(one.uncertainty, bool(verbose))
            if verbose:
                yield from contributor_lines(one.result, rows(top))
                yield from comparison_lines(one.result, one.comparison)
        if verbose:
            yield from sensitivity_table([one.result for one in done])

    def dicts() -> list[dict[str, Any]]:
        return [
            case_dict(one.path, one.result)
            | more_dict(one.result)
            | {"uncertainty": as_dict(one.uncertainty)}
            | ({} if one.comparison is None else {"deviation_from_case": one.comparison.by_case})
            for one in done
        ]

    answer(as_json, quiet, lines, dicts)
    if refused is not None and refused in told:
        raise typer.Exit(refused.exit_code)
    if refused is not None:
        raise refused
    failed = [one.result.case.id for one in done if not all(v.passed for v in one.result.verdicts)]
    if fail_on_violation and failed:
        raise PhysicsError(f"requirements are violated in case {', '.join(failed)}")


@app.command("run-series", epilog=examples("tedm run-series all"))
def run_series(
    series: Series,
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    fail_on_violation: FailOnViolation = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Outputs and verdicts of temperature time series.

    Propagates measured or simulated temperatures (CSV or HDF5) to time series and spectra of all outputs, and judges
    the requirements where their bands and the spectra overlap. A series that is refused does not keep the others from
    being run.
    """
    from tedm_cli.cli.printing.series import series_dict, series_lines
    from tedm_cli.cli.series import run_named_series
    from tedm_cli.stages.noise.series import run_series as run

    def violated(r: SeriesResult) -> str:
        return r.name if fail_on_violation and not all(v.worst.passed for v in r.verdicts) else ""

    run_named_series(
        open_project(config, build_dir, verbose),
        series,
        output,
        run=run,
        lines=series_lines,
        as_dict=series_dict,
        as_json=as_json,
        violated=violated,
        quiet=quiet,
    )
