"""Loads other than temperature. Stages are imported inside, so that --help is quick."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tedm_cli.cli.app import answer, app, open_project
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


@app.command("build-loads")
def build_loads(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    op2: Annotated[
        list[Path] | None,
        typer.Option(
            "--op2",
            metavar="FILE",
            help="Results of the deck of write-deck --loads, an OP2 or MSC Nastran's HDF5; may be repeated. Default:"
            " the embedded solver solves.",
        ),
    ] = None,
    top: Top = DEFAULT_TOP,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Other loads than temperature, and natural frequencies.

    The loads of loads.toml, solved on the unit-load deck by one factorisation: motions of the feet that hold the
    structure, gravity and moisture that are gone in flight. Of each: what it does to the accelerations of the test
    masses, to the read-outs and to the beams, and how much of that is distortion; after a release, what margins the
    layout has left. Read-outs are among the outputs where optics.h5 is. Frequencies are those of the embedded solver's
    elements in any case.
    """
    from tedm_cli.cli.printing.loads import loads_dict, loads_lines
    from tedm_cli.progress import progress
    from tedm_cli.stages.loads.build import build_loads as stage

    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        done = stage(project, output, step, results=op2 or [])
    answer(as_json, quiet, lambda: loads_lines(done, rows(top)), lambda: loads_dict(done))
