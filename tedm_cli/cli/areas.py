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
    BuildDir,
    Config,
    Json,
    Quiet,
    Verbose,
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
