"""Results in parts: reduced by several machines, and put together. Stages are imported inside, so --help is quick.

Parts need the stages of both halves of the model: what is read of its results, and what pulls on its test masses. They
meet here, as wings of `stages` do not know each other.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial as partial_of
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tedm_cli.cli.app import answer, app, open_project
from tedm_cli.cli.options import DEFAULT_BUILD, DEFAULT_CONFIG, BuildDir, Config, Json, Quiet, Verbose

if TYPE_CHECKING:
    from tedm_cli.config.project import Project
    from tedm_cli.progress import Step
    from tedm_cli.stages.model.merge import SensitivityOf


@app.command()
def merge(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FOLDER", help="Write here instead of into the build folder."),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Put parts of several machines together.

    Takes the parts that `tedm build-sensitivity --partial` has left in the build folder, one of each result file of
    model.op2, and writes unit_loads.h5, distortion.h5 and sensitivity.h5. Refused are parts of another model,
    configuration or version, and areas in no part or in two; the areas of all parts must add up to the uniform load.

    What needs the displacements of grids cannot be made of these files, and says so, such as build-adjoint and
    export-vtu.
    """
    from tedm_cli.cli.printing.merge import merge_dict, merge_lines
    from tedm_cli.progress import progress
    from tedm_cli.stages.model.merge import merge as stage

    project = open_project(config, build_dir, verbose)
    into = project if output is None else replace(project, build_dir=output)
    if output is None:
        _remember(project)
    with progress(quiet) as step:
        done = stage(project, into, _sensitivity_of(into, step, None), step)
    answer(as_json, quiet, lambda: merge_lines(done), lambda: merge_dict(done))


def in_parts(project: Project, partial: Path | None, scheduler: str | None, *, as_json: bool, quiet: bool) -> None:
    """`build-sensitivity` of one result file, or of all: by the workers of a scheduler, or here without one."""
    from tedm_cli.cli.printing.merge import merge_dict, merge_lines, part_dict, part_lines
    from tedm_cli.progress import progress
    from tedm_cli.stages.gravity.pulls import reduction_of
    from tedm_cli.stages.model.cluster import reduce_on_workers
    from tedm_cli.stages.model.one_pass import reduce_here
    from tedm_cli.stages.model.parts import build_part

    if partial is not None:
        with progress(quiet) as step:
            part = build_part(project, partial, reduction_of, step)
        answer(as_json, quiet, lambda: part_lines(part), lambda: part_dict(part))
        return
    _remember(project)
    with progress(quiet) as step:
        finish = partial_of(_sensitivity_of, project, step)
        if scheduler is None:
            done = reduce_here(project, reduction_of, finish, step)
        else:
            done = reduce_on_workers(project, scheduler, reduction_of, finish, step)
    answer(as_json, quiet, lambda: merge_lines(done), lambda: merge_dict(done))


def _sensitivity_of(project: Project, step: Step, pulls: Any) -> SensitivityOf:
    """Writes sensitivity.h5 of columns; `pulls`: what was summed for their operator, where it was here."""
    from tedm_cli.stages.gravity.sensitivity import GivenColumns, build_sensitivity

    return lambda columns, parts: build_sensitivity(project, None, step, GivenColumns(columns, parts, pulls))


def _remember(project: Project) -> None:
    """Write what the chain remembers of a project before what is made of it, as `tedm run` does: it goes on then."""
    from tedm_cli.stages.chain.make_rules import remember
    from tedm_cli.stages.chain.project_files import chain_files

    remember(chain_files(project).remembered())
