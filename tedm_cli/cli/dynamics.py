"""Commands on the drag-free dynamics. Stages are imported inside, so that --help is quick."""

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
    from tedm_cli.config.project import Project
    from tedm_cli.stages.dynamics.series import SimulatedSeries
    from tedm_cli.stages.dynamics.simulate import Simulation


@app.command("build-dynamics")
def build_dynamics(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Equations of motion and control of the drag-free satellite.

    Spacecraft and both test masses with the stiffness of every source, the controller, poles and margins of the loops.
    """
    from tedm_cli.cli.printing.dynamics import dynamics_lines
    from tedm_cli.stages.dynamics.build import build_dynamics as stage

    say(quiet, *dynamics_lines(stage(open_project(config, build_dir, verbose), output)))


@app.command()
def simulate(
    case: Annotated[list[str] | None, typer.Argument(help="Case ids of the configuration (3, 4b), or `all`.")] = None,
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    problem: Annotated[
        Path | None, typer.Option("--problem", help="A self-contained problem in JSON instead of a project.")
    ] = None,
    series: Annotated[
        list[str] | None,
        typer.Option("--series", help="A temperature series of the cases file in place of cases, or `all`."),
    ] = None,
    release: Annotated[
        list[str] | None,
        typer.Option("--release", help="Let coordinates go in place of cases: TM1_x=1e-6,SC_phi=1e-7 (m, rad)."),
    ] = None,
    in_time: Annotated[
        bool, typer.Option("--time", help="Realise the noise in time as well, and compare with the exact spectra.")
    ] = False,
    fail_on_violation: Annotated[
        bool, typer.Option("--fail-on-violation", help="Exit with 5 when a requirement is violated.")
    ] = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Noise of the closed loop, with its budget and verdicts.

    The temperatures of a case act through gravity, stiffness and read-out at once, beside all other noise sources, on
    every output of the closed loop; the differential acceleration and what else is required are judged. With --series
    measured or computed temperatures act alone, in time; with --release nothing acts, and the loop finds back.
    """
    from tedm_cli.errors import PhysicsError, UsageError

    if problem is not None:
        from tedm_cli.stages.dynamics.problem import solve_problem

        if case:
            raise UsageError("--problem takes no case")
        unused = {
            "--output": output is not None,
            "--time": in_time,
            "--series": bool(series),
            "--release": bool(release),
            "--fail-on-violation": fail_on_violation,
        }
        given = [option for option, is_given in unused.items() if is_given]
        if given:
            raise UsageError(f"--problem prints its results alone and takes no {given[0]}")
        print(json.dumps(solve_problem(problem)))
        return
    if series or release:
        own = "--series" if series else "--release"
        unused = {
            "case": bool(case),
            "--time": in_time,
            "--release": bool(series and release),
            "--fail-on-violation": bool(release) and fail_on_violation,
        }
        given = [option for option, is_given in unused.items() if is_given]
        if given:
            raise UsageError(f"{own} runs in place of cases and takes no {given[0]}")
    if release:
        _release(open_project(config, build_dir, verbose), release, output, as_json, quiet)
        return
    if series:
        _simulate_series(open_project(config, build_dir, verbose), series, output, fail_on_violation, as_json, quiet)
        return
    from tedm_cli.cli.printing.dynamics import simulation_dict, simulation_lines
    from tedm_cli.config.cases import select_cases
    from tedm_cli.progress import progress
    from tedm_cli.stages.dynamics.simulate import simulate as stage

    if not case:
        hint = "tedm simulate 3, tedm simulate all, tedm simulate --series cooldown"
        raise UsageError("name a case, or all, or a --series", hint=hint)
    project = open_project(config, build_dir, verbose)
    ids = select_cases(project.cases, case)
    if output is not None and len(ids) != 1:
        raise UsageError(f"--output names one file, but {len(ids)} cases are run")
    done: list[tuple[Path, Simulation]] = []
    with progress(quiet) as step:
        stage(project, ids, output, step, in_time, lambda path, result: done.append((path, result)))
    if as_json:
        print(json.dumps([simulation_dict(path, r) for path, r in done], indent=1))
    else:
        for path, r in done:
            say(quiet, *simulation_lines(path, r))
    failed = [r.case.id for _, r in done if not all(j.verdict.passed for j in r.judged)]
    if fail_on_violation and failed:
        raise PhysicsError(f"requirements are violated in case {', '.join(failed)}")


def _release(project: Project, texts: list[str], output: Path | None, as_json: bool, quiet: bool) -> None:
    """simulate --release."""
    from tedm_cli.cli.printing.dynamics import release_dict, release_lines
    from tedm_cli.progress import progress
    from tedm_cli.stages.dynamics.release import offsets
    from tedm_cli.stages.dynamics.release import release as stage

    with progress(quiet) as step:
        done = stage(project, offsets(texts), output, step)
    if as_json:
        print(json.dumps(release_dict(done), indent=1))
    else:
        say(quiet, *release_lines(done))


def _simulate_series(
    project: Project, wanted: list[str], output: Path | None, fail_on_violation: bool, as_json: bool, quiet: bool
) -> None:
    """simulate --series: all that are named, then the first refusal of them."""
    from tedm_cli.cli.printing.dynamics import simulated_series_dict, simulated_series_lines
    from tedm_cli.errors import PhysicsError, TedmError, UsageError
    from tedm_cli.progress import progress
    from tedm_cli.stages.dynamics.series import simulate_series
    from tedm_cli.stages.temperature_series import select_series

    names = select_series(project, wanted)
    if output is not None and len(names) > 1:
        raise UsageError(f"--output names one file, but {len(names)} series are run")
    done: list[SimulatedSeries] = []
    refused: TedmError | None = None
    try:
        with progress(quiet) as step:
            simulate_series(project, names, output, step, done.append)
    except TedmError as error:
        if not done:
            raise
        refused = error
    if as_json:
        print(json.dumps([simulated_series_dict(r) for r in done], indent=1))
    else:
        for r in done:
            say(quiet, *simulated_series_lines(r))
    if refused is not None:
        raise refused
    failed = [r.total.name for r in done if not all(v.worst.passed for v in r.total.verdicts)]
    if fail_on_violation and failed:
        raise PhysicsError(f"requirements are violated in series {', '.join(failed)}")
