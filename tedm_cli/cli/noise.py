"""Commands on temperature noise and its verdicts. Stages are imported inside, so that --help is quick."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tedm_cli.cli.app import (
    DEFAULT_BUILD,
    DEFAULT_CONFIG,
    BuildDir,
    Config,
    Json,
    Output,
    Quiet,
    Verbose,
    app,
    open_project,
    say,
)

if TYPE_CHECKING:
    from tedm_cli.noise.case_run import CaseResult
    from tedm_cli.stages.noise.realisation import Realised
    from tedm_cli.stages.series_result import SeriesResult


@app.command("run-case")
def run_case(
    case: Annotated[list[str], typer.Argument(help="Case ids of the configuration (3, 4b), or `all`.")],
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    fail_on_violation: Annotated[
        bool,
        typer.Option(
            "--fail-on-violation", help="Exit with 5 when a requirement is violated; with 0 where nothing is judged."
        ),
    ] = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Noise spectra and verdicts of cases.

    Propagates the temperature noise of correlation cases to all outputs, exactly, and judges the requirements. With -v
    also contributors, what would bring each verdict down, and how it hangs on filter, correlation and safety factor.
    All cases are held against the model first: what does not fit is told at once, and keeps no other from being run.
    """
    from tedm_cli.cli.printing.case import case_dict, case_lines
    from tedm_cli.cli.printing.contributors import contributor_lines, more_dict, sensitivity_table
    from tedm_cli.cli.printing.series import realisation_line
    from tedm_cli.cli.streams import refusal_lines
    from tedm_cli.cli.streams import tell as tell_lines
    from tedm_cli.config.cases import select_cases
    from tedm_cli.errors import PhysicsError, TedmError, UsageError
    from tedm_cli.progress import progress
    from tedm_cli.stages.noise.case import run_cases

    project = open_project(config, build_dir, verbose)
    ids = select_cases(project.cases, case)
    if output is not None and len(ids) != 1:
        raise UsageError(f"--output names one file, but {len(ids)} cases are run")
    done: list[tuple[Path, CaseResult, Realised | None]] = []
    told: list[TedmError] = []
    refused: TedmError | None = None

    def tell(error: TedmError) -> None:
        tell_lines(refusal_lines(error))
        told.append(error)

    try:
        with progress(quiet) as step:
            run_cases(project, ids, output, step, lambda *of_case: done.append(of_case), tell)
    except TedmError as error:
        if not done:
            raise
        refused = error
    if as_json:
        print(json.dumps([case_dict(path, result) | more_dict(result) for path, result, _ in done], indent=1))
    else:
        for path, result, realised in done:
            say(quiet, *case_lines(path, result), *([realisation_line(realised)] if realised is not None else []))
            if verbose:
                say(quiet, *contributor_lines(result))
        if verbose:
            say(quiet, *sensitivity_table([result for _, result, _ in done]))
    if refused is not None and refused in told:
        raise typer.Exit(refused.exit_code)
    if refused is not None:
        raise refused
    failed = [r.case.id for _, r, _ in done if not all(v.passed for v in r.verdicts)]
    if fail_on_violation and failed:
        raise PhysicsError(f"requirements are violated in case {', '.join(failed)}")


@app.command("run-series")
def run_series(
    series: Annotated[list[str], typer.Argument(help="Names of time series in the cases file, or `all`.")],
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    fail_on_violation: Annotated[
        bool,
        typer.Option(
            "--fail-on-violation", help="Exit with 5 when a requirement is violated; with 0 where nothing is judged."
        ),
    ] = False,
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
        as_dict=series_dict if as_json else None,
        violated=violated,
        quiet=quiet,
    )
