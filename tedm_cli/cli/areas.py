"""The command on thermal areas. Stages are imported inside, so that --help is quick."""

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
    Json,
    Quiet,
    Top,
    Verbose,
    at_least,
    rows,
)


@app.command(epilog=examples("tedm areas", "tedm areas --figure areas.svg"))
def areas(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="Write node_id,area to this CSV file.")
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option(
            "--figure", metavar="FILE", help="Draw the model coloured by area, gradients as arrows (.svg or .png)."
        ),
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
    answer(as_json, quiet, lambda: area_lines(done), done.as_dict)
    done.require_partition()


@app.command("suggest-areas")
def suggest_areas(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    count: Annotated[
        int | None,
        typer.Option("--count", metavar="N", callback=at_least(1), help="How many areas of mean temperatures."),
    ] = None,
    error: Annotated[
        float | None,
        typer.Option(
            "--error",
            metavar="RATIO",
            help="Or as few as keep every judged ratio within this relative error, such as 0.05.",
        ),
    ] = None,
    length_mm: Annotated[
        list[float] | None,
        typer.Option(
            "--length-mm",
            metavar="MM",
            help="Correlation length of the temperatures; may be repeated. Default: six, from 20 to 1000 mm.",
        ),
    ] = None,
    even: Annotated[
        bool, typer.Option("--even", help="The same temperature noise everywhere, instead of that of the cases file.")
    ] = False,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="Write node_id,area to this CSV file.")
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option("--figure", metavar="FILE", help="Draw the model coloured by suggested area (.svg or .png)."),
    ] = None,
    curve: Annotated[
        Path | None,
        typer.Option("--curve", metavar="FILE", help="Draw the error against the number of areas (.svg or .png)."),
    ] = None,
    top: Top = DEFAULT_TOP,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Thermal areas that fit the outputs.

    Each suggested area joins connected grids on which the judged outputs depend alike, and does not cross what the
    correlation cases tell apart. The table compares areas of every count, and the present ones, with a temperature
    field whose correlation decays with distance. It uses adjoint.h5; nothing is solved.
    """
    from tedm_cli.cli.printing.suggest import suggestion_lines
    from tedm_cli.progress import progress
    from tedm_cli.stages.adjoint.suggest import suggest_areas as stage

    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        done = stage(project, count, error, length_mm or (), output, figure, curve, step, even=even)
    answer(as_json, quiet, lambda: suggestion_lines(done, rows(top)), lambda: done.as_dict(rows(top)))
