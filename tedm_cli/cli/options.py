"""Arguments and options that commands share: each has one name, one word in place of its value, and one help text."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from tedm_cli.cli import completion
from tedm_cli.config.nearest import NO_PROJECT, nearest_project
from tedm_cli.errors import InputError

#: What stands in place of a value in help and usage lines; choices are listed instead.
METAVARS = {
    "ADDRESS": "address of a dask scheduler, such as tcp://HOST:8786",
    "AREA": "name of a thermal area",
    "CASE": "id of a correlation case in the cases file",
    "COMMAND": "a command line of another program",
    "CRITERION": "name of a criterion in the file of a trade",
    "FIGURE": "number of a published figure",
    "FILE": "path of a file",
    "FOLDER": "path of a folder",
    "GRIDS": "ids of grids, divided by commas",
    "HZ": "frequency in hertz",
    "MATRICES": "a file of matrices: optics, sensitivity or distortion",
    "MM": "a length in millimetres",
    "N": "a whole number",
    "NAME": "any name that report and prints use",
    "OFFSETS": "coordinates and where they are let go, in m and rad",
    "OUTPUT": "name of an output, such as TM1_a_x or A_TM1_x",
    "PATH": "path of a folder, or of a single file",
    "RATIO": "a number, relative",
    "ROW": "name of a set of temperatures, in the first column of its table",
    "SECONDS": "a time in seconds",
    "SERIES": "name of a time series in the cases file",
    "SET": "name of a set of photodiodes",
    "STAGE": "name of a command of the chain",
    "VARIANT": "name of a variant in the file of a trade",
}


class Format(Enum):
    """What matrices are written as."""

    csv = "csv"
    npz = "npz"
    mat = "mat"


def was_given(ctx: typer.Context, name: str) -> bool:
    """Whether the command line gives this parameter."""
    source = ctx.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE"


def at_least(least: int) -> Callable[[int | None], int | None]:
    """A callback that refuses smaller numbers, where one is given."""

    def check(value: int | None) -> int | None:
        if value is not None and value < least:
            raise typer.BadParameter(f"{value} is less than {least}")
        return value

    return check


def _project_file(ctx: typer.Context, given: Path) -> Path:
    """The project file that was given, or else that of this folder or of the nearest one above that has one."""
    if was_given(ctx, "config"):
        return given
    found = nearest_project()
    if found is None:
        raise InputError(
            NO_PROJECT,
            where=str(Path.cwd()),
            hint="begin one: tedm init demo; or name the file of one elsewhere with --config",
        )
    return found.file


def _build_folder(ctx: typer.Context, given: Path) -> Path:
    """The build folder that was given, or else that beside the project found; of a project file given, it is here."""
    named = was_given(ctx, "build_dir") or was_given(ctx, "config")
    found = None if named else nearest_project()
    return given if found is None else found.folder / given


Config = Annotated[
    Path,
    typer.Option(
        "-c",
        "--config",
        metavar="FILE",
        help="Project file; it names the other configuration files. Default: tedm.toml or configs/tedm.toml, searched"
        " here, then upwards.",
        show_default=False,
        callback=_project_file,
    ),
]
BuildDir = Annotated[
    Path,
    typer.Option(
        "-d",
        "--build-dir",
        metavar="FOLDER",
        help="Folder of the files between stages. Default: build, in the folder of the project.",
        show_default=False,
        callback=_build_folder,
    ),
]
Output = Annotated[
    Path | None, typer.Option("-o", "--output", metavar="FILE", help="Write here instead of into the build folder.")
]
Matrices = Annotated[
    Path | None,
    typer.Option(
        "-o", "--output", metavar="PATH", help="Folder, or a .npz or .mat file. Default: export, in the build folder."
    ),
]
Formats = Annotated[Format, typer.Option("--format", help="csv: a file per matrix; npz, mat: all in one.")]
Json = Annotated[bool, typer.Option("--json", help="Print the results as JSON.")]
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Print errors only; with --json, no progress.")]
Verbose = Annotated[
    int, typer.Option("-v", "--verbose", count=True, show_default=False, help="Say more; -vv adds tracebacks.")
]
Nastran = Annotated[
    str | None, typer.Option("--nastran", metavar="COMMAND", help="Your own solver, as in `tedm solve --run`.")
]
Top = Annotated[
    int, typer.Option("--top", metavar="N", callback=at_least(0), help="Rows of each ranked table; 0: all of them.")
]
FailOnViolation = Annotated[
    bool,
    typer.Option(
        "--fail-on-violation", help="Exit with 5 when a requirement is violated; with 0 where nothing is judged."
    ),
]
Case = Annotated[str, typer.Argument(metavar="CASE", autocompletion=completion.cases, help="A case that was run.")]
Cases = Annotated[
    list[str],
    typer.Argument(
        metavar="CASE", autocompletion=completion.cases, help="Cases of the cases file (3, 4b, T), or `all`."
    ),
]
AnyCases = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="CASE", autocompletion=completion.cases, help="Cases of the cases file (3, 4b, T), or `all`."
    ),
]
CasesRun = Annotated[
    list[str] | None,
    typer.Argument(metavar="CASE", autocompletion=completion.cases, help="Cases that were run. Default: all of them."),
]
CompareMesh = Annotated[
    Path | None,
    typer.Option(
        "--compare-mesh",
        metavar="PATH",
        help="Build folder, or project file, of a second mesh with the same areas: estimates the error of the mesh.",
    ),
]
Series = Annotated[
    list[str],
    typer.Argument(metavar="SERIES", autocompletion=completion.series, help="Time series of the cases file, or `all`."),
]
Of = Annotated[
    list[str] | None,
    typer.Option(
        "--of",
        metavar="OUTPUT",
        autocompletion=completion.outputs,
        help="TM1_a_x, A_TM1_x, ...; may be repeated. Default: what is judged.",
    ),
]

DEFAULT_CONFIG = Path("tedm.toml")
DEFAULT_BUILD = Path("build")
DEFAULT_TOP = 10


def rows(top: int) -> int | None:
    """`--top` as the end of a slice: None for all."""
    return top or None
