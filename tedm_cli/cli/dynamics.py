"""Commands on the drag-free dynamics. Stages are imported inside, so that --help is quick."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tedm_cli.cli import completion
from tedm_cli.cli.app import answer, app, begin, open_project
from tedm_cli.cli.headings import examples
from tedm_cli.cli.options import (
    DEFAULT_BUILD,
    DEFAULT_CONFIG,
    AnyCases,
    BuildDir,
    Config,
    FailOnViolation,
    Json,
    Output,
    Quiet,
    Verbose,
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
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Equations of motion and control of the satellite.

    The drag-free loop: spacecraft and both test masses with the stiffness of every source, the controller, poles and
    margins.
    """
    from tedm_cli.cli.printing.dynamics import dynamics_dict, dynamics_lines
    from tedm_cli.stages.dynamics.build import build_dynamics as stage

    done = stage(open_project(config, build_dir, verbose), output)
    answer(as_json, quiet, lambda: dynamics_lines(done), lambda: dynamics_dict(done))


@app.command(
    epilog=examples(
        "tedm simulate 3",
        "tedm simulate all --time",
        "tedm simulate --series cooldown",
        "tedm simulate --release TM1_x=1e-6",
    )
)
def simulate(
    case: AnyCases = None,
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    problem: Annotated[
        Path | None,
        typer.Option("--problem", metavar="FILE", help="A self-contained problem in JSON instead of a project."),
    ] = None,
    series: Annotated[
        list[str] | None,
        typer.Option(
            "--series",
            metavar="SERIES",
            autocompletion=completion.series,
            help="A time series of the cases file in place of cases, or `all`; may be repeated.",
        ),
    ] = None,
    release: Annotated[
        list[str] | None,
        typer.Option(
            "--release",
            metavar="OFFSETS",
            help="Let coordinates go in place of cases: TM1_x=1e-6,SC_phi=1e-7 (m, rad); may be repeated.",
        ),
    ] = None,
    in_time: Annotated[
        bool, typer.Option("--time", help="Realise the noise in time as well, and compare with the exact spectra.")
    ] = False,
    figure_6_2: Annotated[
        bool,
        typer.Option(
            "--figure-6.2",
            help="No loop: the noise of imposed positions through stiffness, beside Montemurro 2004, figure 6.2.",
        ),
    ] = False,
    fail_on_violation: FailOnViolation = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Noise of the closed loop, its budget and verdicts.

    The temperatures of a case act through gravity, stiffness and read-out at once, beside all other noise sources, on
    every output of the closed loop; the differential acceleration and what else is required are judged.

    In place of cases, one of four: --series, measured or computed temperatures act alone, in time; --release, nothing
    acts, and the loop finds back from where it is let go; --figure-6.2, imposed positions without a loop; --problem, a
    problem in a file of its own, whose answer is printed.
    """
    from tedm_cli.errors import PhysicsError, UsageError

    of_cases = {"--time": in_time, "--fail-on-violation": fail_on_violation}
    if figure_6_2:
        _refuse_with("--figure-6.2 imposes the positions, with no loop and no temperatures,", case,
                     {"--problem": problem is not None, "--series": bool(series), "--release": bool(release),
                      **of_cases})  # fmt: skip
        _figure_6_2(config, build_dir, output, as_json, quiet, verbose)
        return
    if problem is not None:
        from tedm_cli.cli.printing.as_json import json_text
        from tedm_cli.stages.dynamics.problem import solve_problem

        others = {"--output": output is not None, "--series": bool(series), "--release": bool(release), **of_cases}
        _refuse_with("--problem prints its results alone", case, others)
        begin(verbose)
        print(json_text(solve_problem(problem)))
        return
    if release:
        others = {"--series": bool(series), **of_cases}
        _refuse_with("--release runs in place of cases", case, others)
        _release(open_project(config, build_dir, verbose), release, output, as_json, quiet)
        return
    if series:
        _refuse_with("--series runs in place of cases", case, {"--time": in_time})
        _simulate_series(open_project(config, build_dir, verbose), series, output, fail_on_violation, as_json, quiet)
        return
    from tedm_cli.cli.printing.dynamics import simulation_dict, simulation_lines, summary_lines
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

    def lines() -> Iterator[str]:
        for path, r in done:
            yield from simulation_lines(path, r)
        yield from summary_lines([r for _, r in done])

    answer(as_json, quiet, lines, lambda: [simulation_dict(path, r) for path, r in done])
    failed = [r.case.id for _, r in done if not all(j.verdict.passed for j in r.judged)]
    if fail_on_violation and failed:
        raise PhysicsError(f"requirements are violated in case {', '.join(failed)}")


def _refuse_with(option: str, case: list[str] | None, others: dict[str, bool]) -> None:
    """Refuse cases and other options beside one that has no use for them."""
    from tedm_cli.errors import UsageError

    given = [*(["case"] if case else []), *(name for name, is_given in others.items() if is_given)]
    if given:
        raise UsageError(f"{option} and takes no {given[0]}")


def _figure_6_2(config: Path, build_dir: Path, output: Path | None, as_json: bool, quiet: bool, verbose: int) -> None:
    from tedm_cli.cli.printing.imposed import imposed_dict, imposed_lines
    from tedm_cli.stages.dynamics.imposed import imposed_motion

    path, found = imposed_motion(open_project(config, build_dir, verbose), output)
    answer(as_json, quiet, lambda: imposed_lines(path, found), lambda: imposed_dict(path, found))


def _release(project: Project, texts: list[str], output: Path | None, as_json: bool, quiet: bool) -> None:
    """simulate --release."""
    from tedm_cli.cli.printing.dynamics import release_dict, release_lines
    from tedm_cli.progress import progress
    from tedm_cli.stages.dynamics.release import offsets
    from tedm_cli.stages.dynamics.release import release as stage

    with progress(quiet) as step:
        done = stage(project, offsets(texts), output, step)
    answer(as_json, quiet, lambda: release_lines(done), lambda: release_dict(done))


def _simulate_series(
    project: Project, wanted: list[str], output: Path | None, fail_on_violation: bool, as_json: bool, quiet: bool
) -> None:
    """simulate --series."""
    from tedm_cli.cli.printing.dynamics import simulated_series_dict, simulated_series_lines
    from tedm_cli.cli.series import run_named_series
    from tedm_cli.stages.dynamics.series import simulate_series

    def violated(r: SimulatedSeries) -> str:
        return r.total.name if fail_on_violation and not all(v.worst.passed for v in r.total.verdicts) else ""

    run_named_series(
        project,
        wanted,
        output,
        run=simulate_series,
        lines=simulated_series_lines,
        as_dict=simulated_series_dict,
        as_json=as_json,
        violated=violated,
        quiet=quiet,
    )
