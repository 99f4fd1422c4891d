"""Commands on what has been computed: figures, report, files. Stages are imported inside, so that --help is quick."""

from __future__ import annotations

import json
from enum import Enum
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


class _ReportFormat(Enum):
    html = "html"
    pdf = "pdf"
    md = "md"


class _FigureFormat(Enum):
    svg = "svg"
    pdf = "pdf"


@app.command()
def plot(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Folder of the figures, if not figures/ in the build folder.")
    ] = None,
    area: Annotated[
        list[str] | None,
        typer.Option("--area", metavar="NAME", help="Only the bench under 1 K of this thermal area; may be repeated."),
    ] = None,
    fmt: Annotated[
        _FigureFormat, typer.Option("--format", help="svg: what the report shows; pdf: for papers.")
    ] = _FigureFormat.svg,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Draw the figures.

    Of all cases and series run, of the optics, and of the bench under its worst areas.
    """
    from tedm_cli.progress import progress
    from tedm_cli.stages.reporting.plot import plot as stage

    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        paths = stage(project, output, step, area or (), fmt.value)
    say(quiet, f"{paths[0].parent}: {len(paths)} figure{'s' if len(paths) > 1 else ''}")


@app.command()
def report(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", help="One .html, .pdf or .md file instead of all three; its annex lies beside it."
        ),
    ] = None,
    fmt: Annotated[list[_ReportFormat] | None, typer.Option("--format", help="Only this one; may be repeated.")] = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Write the report and its annex: HTML, PDF and Markdown.

    Decision first, then what to do, then the evidence that decides; the annex (report_annex) holds all else. The pages
    need no other file. [report] in the project file gives title, mission, issue, date and prepared_by.
    """
    from tedm_cli.stages.reporting.report import report as stage

    paths = stage(open_project(config, build_dir, verbose), output, [f.value for f in fmt or ()])
    say(quiet, *(f"{path}: {path.stat().st_size / 1e6:.2f} MB" for path in paths))


@app.command()
def view(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Write view.html: the model in 3-D, to warm, turn and play.

    What happens when an area warms: the deformed model, sliders for the temperatures, and every output. The page needs
    no other file and no network.
    """
    from tedm_cli.progress import progress
    from tedm_cli.stages.reporting.view import view as stage

    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        done = stage(project, output, step)
    say(quiet, f"{done.path}: {done.path.stat().st_size / 1e6:.2f} MB, {done.drawn:,} of {done.grids:,} grids drawn")


@app.command()
def show(
    file: Annotated[Path, typer.Argument(help="An HDF5 file of tedm.")],
    as_json: Json = False,
) -> None:
    """Show what a file holds.

    Datasets with their units, what it was made from, and its main numbers.
    """
    from tedm_cli.cli.printing.show import show_lines
    from tedm_cli.stages.reporting.show import show_dict

    found = show_dict(file)
    if as_json:
        print(json.dumps(found, indent=1))
    else:
        print("\n".join(show_lines(found)))


@app.command()
def check(
    build_dir: BuildDir = DEFAULT_BUILD,
    as_json: Json = False,
) -> None:
    """Check that all files are up to date.

    Every HDF5 file of the build folder: its contract, its version, and whether its inputs are still the same.
    """
    from tedm_cli.errors import InputError
    from tedm_cli.stages.chain.check import check_folder

    results = check_folder(build_dir)
    if as_json:
        print(json.dumps([r.as_dict() for r in results], indent=1))
    else:
        for r in results:
            print("\n".join(r.lines()))
    bad = [r.path.name for r in results if r.problems]
    if bad:
        raise InputError(
            f"{len(bad)} of {len(results)} files are not up to date: {', '.join(bad)}",
            where=str(build_dir),
            hint="`tedm run` makes them anew",
        )


@app.command("make-rules", hidden=True)
def make_rules(config: Config = DEFAULT_CONFIG, build_dir: BuildDir = DEFAULT_BUILD, output: Output = None) -> None:
    """Write the Make variables of a project: its inputs and its cases."""
    from tedm_cli.stages.chain.make_rules import make_rules as stage

    stage(open_project(config, build_dir, 0), output)
