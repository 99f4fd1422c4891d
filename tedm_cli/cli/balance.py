"""The command on the balance of the field at rest. The stage is imported inside, so that --help is quick."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tedm_cli.cli.app import answer, app, open_project
from tedm_cli.cli.headings import examples
from tedm_cli.cli.options import (
    DEFAULT_BUILD,
    DEFAULT_CONFIG,
    DEFAULT_TOP,
    BuildDir,
    Config,
    FailOnViolation,
    Json,
    Output,
    Quiet,
    Top,
    Verbose,
    rows,
)


@app.command(
    epilog=examples(
        "tedm balance", "tedm balance --csv masses.csv --figure balance.svg", "tedm balance --retrim measured.csv"
    )
)
def balance(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    csv: Annotated[
        Path | None,
        typer.Option(
            "--csv",
            metavar="FILE",
            help="Write the blocks here, for compensation_masses in the model's file. Default: balance_masses.csv,"
            " in the build folder.",
        ),
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option(
            "--figure",
            metavar="FILE",
            help="Draw the blocks in sections of the model, and the limits before and after (.svg or .png).",
        ),
    ] = None,
    retrim: Annotated[
        Path | None,
        typer.Option(
            "--retrim",
            metavar="FILE",
            help="CSV part,mass_kg,dx_m,dy_m,dz_m of parts and blocks as they were measured: how the shims of the last"
            " balance change.",
        ),
    ] = None,
    fail_on_violation: FailOnViolation = False,
    top: Top = DEFAULT_TOP,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Compensation masses that meet the limits at rest.

    Of all masses in the boxes of balance.toml those that bring the field at rest within its limits, with least total
    mass; whole shims where boxes have these. Where not all can be met, the least worst ratios, with what blocks them.
    Also what each limit costs, and the yield of builds drawn from tolerances. The blocks are written as a CSV that the
    model's file takes. After parts were measured, --retrim finds the least change of the shims.
    """
    from tedm_cli.cli.printing.balance import balance_dict, balance_lines, retrim_dict, retrim_lines
    from tedm_cli.errors import PhysicsError, UsageError
    from tedm_cli.progress import progress

    if retrim is not None and figure is not None:
        raise UsageError("--figure is of a balance, and --retrim draws none")
    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        if retrim is not None:
            from tedm_cli.stages.balance.retrim import retrim as trim_again

            trimmed = trim_again(project, retrim, output, csv, step)
            results = trimmed.results
        else:
            from tedm_cli.stages.balance.balance import balance as stage

            done = stage(project, output, csv, step, figure)
            results = done.results
    if retrim is not None:
        answer(as_json, quiet, lambda: retrim_lines(trimmed, rows(top)), lambda: retrim_dict(trimmed))
    else:
        answer(as_json, quiet, lambda: balance_lines(done, rows(top)), lambda: balance_dict(done))
    failed = [v for v in results.after if not v.passed]
    if fail_on_violation and failed:
        raise PhysicsError(f"{len(failed)} of {len(results.after)} limits at rest are violated")
