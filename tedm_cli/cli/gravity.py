"""Commands on self-gravity. Stages are imported inside, so that --help is quick."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

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


@app.command("build-sensitivity")
def build_sensitivity(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Self-gravity field, stiffness and [S_SG].

    On each test mass: acceleration at rest, judged by what model.toml limits ([[requirement_at_rest]]), four stiffness
    matrices, and the sensitivity to each thermal area. Compensation masses that are tied to grids move with these.
    """
    from tedm_cli.cli.printing.gravity import sensitivity_lines
    from tedm_cli.progress import progress
    from tedm_cli.stages.gravity.sensitivity import build_sensitivity as stage

    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        done = stage(project, output, step)
    say(quiet, *sensitivity_lines(done))


@app.command("audit-mesh")
def audit_mesh(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Write every element to this CSV file.")] = None,
    figure: Annotated[
        Path | None, typer.Option("--figure", help="Draw every element's size against its gap (SVG).")
    ] = None,
    top: Annotated[int, typer.Option("--top", min=0, help="How many elements to name.")] = 10,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Error that each element leaves.

    The error every element leaves in the self-gravity and its sensitivities, lumped and by quadrature, against 1 % of
    what is allowed at rest. Sensitivities follow the element's own motion once build-distortion has run.
    """
    from tedm_cli.cli.printing.gravity import audit_lines
    from tedm_cli.progress import progress
    from tedm_cli.stages.gravity.audit import audit as stage

    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        done = stage(project, output, figure, step)
    if as_json:
        print(json.dumps(done.as_dict(top), indent=1))
    else:
        say(quiet, *audit_lines(done, top))


@app.command("self-gravity")
def self_gravity(
    points: Annotated[Path, typer.Option("--points", help="CSV with the header x_m,y_m,z_m,mass_kg (basic frame).")],
    config: Config = DEFAULT_CONFIG,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Write a .json or .csv file.")] = None,
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
    if as_json:
        print(json.dumps(point_dict(done), indent=1))
    else:
        say(quiet, *point_field_lines(done))


@app.command()
def accuracy(
    figure: Annotated[str, typer.Argument(help="Study by its published figure: 6.4, 7.2, 7.3, 7.8, 7.9 or 8.1.")],
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Folder of the data and the figure.")] = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Numerical error of a method, against the exact kernel.

    7.2 and 7.8: published quadratures over the test mass. 7.3 and 7.9: size of elements. 8.1: linearisation.
    6.4: mesh of the compensation masses. Writes data (CSV) and the figure (SVG).
    """
    from tedm_cli.cli.printing.gravity import accuracy_lines
    from tedm_cli.stages.gravity.accuracy import accuracy as stage

    say(quiet, *accuracy_lines(stage(open_project(config, build_dir, verbose), figure, output)))
