"""The command on thermal areas. Stages are imported inside, so that --help is quick."""

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
    Quiet,
    Verbose,
    app,
    open_project,
    say,
)


@app.command()
def areas(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Write node_id,area to this CSV file.")] = None,
    figure: Annotated[
        Path | None,
        typer.Option("--figure", help="Draw the model coloured by area, gradients as arrows (.svg or .png)."),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Thermal areas of the model.

    Grids, mass, centroid, mean step of the own elements and attributes of each area, from the definitions on the model
    to be solved, or else from the temperatures of the unit-load deck. Needs no results. Grids in no area are an error,
    told after the table.
    """
    from tedm_cli.cli.printing.areas import area_lines
    from tedm_cli.stages.model.areas import areas as stage

    done = stage(open_project(config, build_dir, verbose), output, figure)
    if as_json:
        print(json.dumps(done.as_dict(), indent=1))
    else:
        say(quiet, *area_lines(done))
    done.require_partition()


@app.command("suggest-areas")
def suggest_areas(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    count: Annotated[int | None, typer.Option("--count", min=1, help="How many areas of mean temperatures.")] = None,
    error: Annotated[
        float | None,
        typer.Option("--error", help="Or as few as keep every judged ratio within this relative error, such as 0.05."),
    ] = None,
    length_mm: Annotated[
        list[float] | None,
        typer.Option("--length-mm", help="Correlation length of the field; may be repeated. Else six, 20 to 1000 mm."),
    ] = None,
    even: Annotated[
        bool, typer.Option("--even", help="The same temperature noise everywhere, instead of that of the cases file.")
    ] = False,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Write node_id,area to this CSV file.")] = None,
    figure: Annotated[
        Path | None, typer.Option("--figure", help="Draw the model coloured by suggested area (.svg or .png).")
    ] = None,
    curve: Annotated[
        Path | None, typer.Option("--curve", help="Draw the error against the number of areas (.svg or .png).")
    ] = None,
    top: Annotated[int, typer.Option("--top", min=0, help="How many of the coarsest present areas to name.")] = 5,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Thermal areas that fit the outputs.

    Connected grids on which the judged outputs act alike, inside what the correlation cases tell apart; and how far
    areas of every count, and the present ones, are from a temperature field that decorrelates with distance. From
    adjoint.h5: nothing is solved.
    """
    from tedm_cli.cli.printing.suggest import suggestion_lines
    from tedm_cli.progress import progress
    from tedm_cli.stages.adjoint.suggest import suggest_areas as stage

    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        done = stage(project, count, error, length_mm or (), output, figure, curve, step, even=even)
    if as_json:
        print(json.dumps(done.as_dict(top), indent=1))
    else:
        say(quiet, *suggestion_lines(done, top))
