"""Commands on what has been computed: figures, report, files. Stages are imported inside, so that --help is quick."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from tedm_cli.cli import completion
from tedm_cli.cli.app import answer, app, begin, open_project
from tedm_cli.cli.headings import examples
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


class _ReportFormat(Enum):
    html = "html"
    pdf = "pdf"
    md = "md"


class _FigureFormat(Enum):
    svg = "svg"
    pdf = "pdf"


@app.command(epilog=examples("tedm plot", "tedm plot --area STRUT_1 --format pdf"))
def plot(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", metavar="FOLDER", help="Folder of the figures. Default: figures, in the build folder."
        ),
    ] = None,
    area: Annotated[
        list[str] | None,
        typer.Option(
            "--area",
            metavar="AREA",
            autocompletion=completion.areas,
            help="Only the bench under 1 K of this thermal area; may be repeated.",
        ),
    ] = None,
    fmt: Annotated[
        _FigureFormat, typer.Option("--format", help="svg: what the report shows; pdf: for papers.")
    ] = _FigureFormat.svg,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Draw the figures.

    Of all cases and series run, of the optics, and of the bench under its worst areas.
    """
    from tedm_cli.cli.printing.written import figure_lines, written_dict
    from tedm_cli.progress import progress
    from tedm_cli.stages.reporting.plot import plot as stage

    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        paths = stage(project, output, step, area or (), fmt.value)
    answer(as_json, quiet, lambda: figure_lines(paths), lambda: written_dict(paths))


@app.command(epilog=examples("tedm report", "tedm report -o review.pdf"))
def report(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE",
            help="One .html, .pdf or .md file instead of all three; its annex lies beside it.",
        ),
    ] = None,
    fmt: Annotated[
        list[_ReportFormat] | None,
        typer.Option("--format", metavar="<html|pdf|md>", help="Only this one; may be repeated. Default: all three."),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Write report and annex: HTML, PDF and Markdown.

    Decision first, then what to do, then the evidence that decides; the annex (report_annex) holds all else. The pages
    need no other file. [report] in the project file gives title, mission, issue, date and prepared_by.
    """
    from tedm_cli.cli.printing.written import written_dict, written_lines
    from tedm_cli.stages.reporting.report import report as stage

    paths = stage(open_project(config, build_dir, verbose), output, [f.value for f in fmt or ()])
    answer(as_json, quiet, lambda: written_lines(paths), lambda: written_dict(paths))


@app.command()
def view(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Write view.html: the model in 3-D, to warm and turn.

    What happens when an area or a thermal node warms: the deformed model, sliders for the temperatures, and every
    output. The page needs no other file and no network.
    """
    from tedm_cli.cli.printing.written import view_dict, view_lines
    from tedm_cli.progress import progress
    from tedm_cli.stages.reporting.view import view as stage

    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        done = stage(project, output, step)
    answer(as_json, quiet, lambda: view_lines(done), lambda: view_dict(done))


@app.command(epilog=examples("tedm show build/case03.h5"))
def show(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", autocompletion=completion.files, help="An HDF5 file that tedm has made.")
    ],
    top: Top = DEFAULT_TOP,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Show what a file says and holds.

    First its verdicts or main numbers, then what it was made from, then its datasets with their units.
    """
    from tedm_cli.cli.printing.show import show_lines
    from tedm_cli.stages.reporting.show import show_dict

    begin(verbose, f"reading {file}")
    found = show_dict(file)
    answer(as_json, quiet, lambda: show_lines(found, rows(top)), lambda: found)


@app.command()
def check(
    build_dir: BuildDir = DEFAULT_BUILD,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Check that all files are up to date.

    Every HDF5 file of the build folder: its contract, its version, and whether its inputs are still the same.
    """
    from tedm_cli.errors import InputError
    from tedm_cli.stages.chain.check import check_folder

    begin(verbose, f"checking {build_dir}")
    results = check_folder(build_dir)
    answer(
        as_json, quiet, lambda: [line for r in results for line in r.lines()], lambda: [r.as_dict() for r in results]
    )
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
