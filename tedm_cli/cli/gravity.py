"""Commands on self-gravity. Stages are imported inside, so that --help is quick."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tedm_cli.cli import completion
from tedm_cli.cli.app import answer, app, open_project
from tedm_cli.cli.merge import in_parts
from tedm_cli.cli.options import (
    DEFAULT_BUILD,
    DEFAULT_CONFIG,
    DEFAULT_TOP,
    BuildDir,
    Config,
    Json,
    Output,
    Quiet,
    Top,
    Verbose,
    rows,
)
from tedm_cli.errors import UsageError


@app.command("build-sensitivity")
def build_sensitivity(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    no_store: Annotated[
        bool,
        typer.Option(
            "--no-store",
            help="Read the displacements of each result file of model.op2 once, and keep none of grids: in place of"
            " `tedm ingest` and `tedm build-distortion`.",
        ),
    ] = False,
    partial: Annotated[
        Path | None,
        typer.Option(
            "--partial",
            metavar="FILE",
            help="Reduce this result file of model.op2 alone, to a part that `tedm merge` puts together with others.",
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            "--scheduler",
            metavar="ADDRESS",
            help="Reduce all result files of model.op2 by the workers of this dask scheduler (tcp://HOST:8786), and put"
            " the parts together.",
        ),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Self-gravity field, stiffness and [S_SG].

    On each test mass: acceleration at rest, judged by what model.toml limits ([[requirement_at_rest]]), four stiffness
    matrices, and the sensitivity to each thermal area. Compensation masses that are tied to grids move with these.

    With --no-store the displacements of each result file are read once, and those of grids are not kept. Results in
    several files can be reduced by several machines: each file by --partial on a machine that sees it, and then `tedm
    merge`; or all by --scheduler. None of these needs `tedm ingest`, and `tedm run` goes on from what they leave.
    """
    from tedm_cli.cli.printing.gravity import sensitivity_dict, sensitivity_lines
    from tedm_cli.progress import progress
    from tedm_cli.stages.gravity.sensitivity import build_sensitivity as stage

    project = open_project(config, build_dir, verbose)
    if no_store or partial is not None or scheduler is not None:
        if sum((no_store, *(given is not None for given in (partial, scheduler, output)))) > 1:
            raise UsageError("--no-store, --partial, --scheduler and --output exclude each other")
        in_parts(project, partial, scheduler, as_json=as_json, quiet=quiet)
        return
    with progress(quiet) as step:
        done = stage(project, output, step)
    answer(as_json, quiet, lambda: sensitivity_lines(done), lambda: sensitivity_dict(done))


@app.command("audit-mesh")
def audit_mesh(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="Write every element to this CSV file.")
    ] = None,
    figure: Annotated[
        Path | None, typer.Option("--figure", metavar="FILE", help="Draw every element's size against its gap (SVG).")
    ] = None,
    top: Top = DEFAULT_TOP,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Error that each element leaves.

    The error every element leaves in the self-gravity and its sensitivities, lumped and by quadrature, against 1 % of
    what is allowed at rest. Sensitivities follow the element's own motion once build-distortion has run.
    """
    from tedm_cli.cli.printing.audit import audit_lines
    from tedm_cli.progress import progress
    from tedm_cli.stages.gravity.audit import audit as stage

    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        done = stage(project, output, figure, step)
    answer(as_json, quiet, lambda: audit_lines(done, rows(top)), lambda: done.as_dict(rows(top)))


@app.command("self-gravity")
def self_gravity(
    points: Annotated[
        Path, typer.Option("--points", metavar="FILE", help="CSV with the header x_m,y_m,z_m,mass_kg (basic frame).")
    ],
    config: Config = DEFAULT_CONFIG,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="Write a .json or .csv file.")
    ] = None,
    per_source: Annotated[bool, typer.Option("--per-source", help="Also what each source contributes.")] = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Field of point sources on the test masses.

    Force, torque, accelerations and four stiffness matrices of a list of masses, with the exact kernel of a cuboid.
    """
    from tedm_cli.cli.printing.gravity import point_field_lines
    from tedm_cli.stages.gravity.self_gravity import point_dict, point_self_gravity

    project = open_project(config, DEFAULT_BUILD, verbose)
    done = point_self_gravity(project, points, per_source=per_source, output=output)
    answer(as_json, quiet, lambda: point_field_lines(done), lambda: point_dict(done))


@app.command()
def accuracy(
    figure: Annotated[
        str,
        typer.Argument(
            metavar="FIGURE",
            autocompletion=completion.figures,
            help="Study by its published figure (Montemurro 2004): 6.4, 7.2, 7.3, 7.8, 7.9 or 8.1.",
        ),
    ],
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", metavar="FOLDER", help="Folder of data and figure. Default: in the build folder."
        ),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Numerical error of a method, against the exact kernel.

    7.2 and 7.8: published quadratures over the test mass. 7.3 and 7.9: size of elements. 8.1: linearisation.
    6.4: mesh of the compensation masses. Writes data (CSV) and the figure (SVG).
    """
    from tedm_cli.cli.printing.gravity import accuracy_dict, accuracy_lines
    from tedm_cli.stages.gravity.accuracy import accuracy as stage

    done = stage(open_project(config, build_dir, verbose), figure, output)
    answer(as_json, quiet, lambda: accuracy_lines(done), lambda: accuracy_dict(done))
