"""The adjoint. Stages are imported inside, so that --help is quick."""

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


@app.command("build-adjoint")
def build_adjoint(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    or_say_why: Annotated[
        bool,
        typer.Option(
            "--or-say-why",
            help="Where this model has no adjoint here, write a file that says why, and succeed; so the chain does.",
        ),
    ] = False,
    op2: Annotated[
        list[Path] | None,
        typer.Option(
            "--op2",
            metavar="FILE",
            help="Results of the deck of write-deck --adjoint, an OP2 or MSC Nastran's HDF5; may be repeated. Default:"
            " those of model.adjoint_op2, or the embedded solver solves.",
        ),
    ] = None,
    top: Top = DEFAULT_TOP,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Effect of each grid and material on each output.

    By one factorisation of the model that `solve` solves, whatever the number of areas, or by your own Nastran (--op2);
    the forces of temperatures are those of `solve` in both cases. The sums over the areas are held against [S_SG] and
    N. Read-outs are among the outputs where optics.h5 is. Materials and shells are ranked by what one per cent more of
    a modulus, an expansion, a density or a thickness does.
    """
    from tedm_cli.cli.printing.adjoint import adjoint_dict, adjoint_lines
    from tedm_cli.progress import progress
    from tedm_cli.stages.adjoint.build import build_adjoint as stage

    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        done = stage(project, output, step, or_say_why=or_say_why, results=op2 or [])
    answer(as_json, quiet, lambda: adjoint_lines(done, rows(top)), lambda: adjoint_dict(done))
