"""The Typer application, the options that commands share, and what they do with them."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tedm_cli import __version__
from tedm_cli.cli.nearest import nearest_project
from tedm_cli.cli.streams import tell
from tedm_cli.errors import InputError

if TYPE_CHECKING:
    from tedm_cli.config.project import Project

app = typer.Typer(
    name="tedm",
    help="Thermo-elastic distortion modelling for drag-free satellites: from a Nastran model and its unit-load results"
    " to self-gravity and read-out noise, judged against requirements.",
    epilog="To begin: `tedm init demo`, `cd demo`, `tedm run`. Stages in order: write-deck, solve, ingest,"
    " build-distortion, build-sensitivity, build-optics, build-adjoint, run-case, run-series, build-dynamics, simulate,"
    " plot, report, view; `tedm run` runs all that are not up to date.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _project_file(ctx: typer.Context, given: Path) -> Path:
    """The project file that was given, or else that of this folder or of the nearest one above that has one."""
    if was_given(ctx, "config"):
        return given
    found = nearest_project()
    if found is None:
        raise InputError(
            "there is no project, no tedm.toml, here or in a folder above",
            where=str(Path.cwd()),
            hint="begin one: tedm init demo; or name the file of one elsewhere with --config",
        )
    return found.file


def _build_folder(ctx: typer.Context, given: Path) -> Path:
    """The build folder that was given, or else that beside the project found; of a project file given, it is here."""
    named = was_given(ctx, "build_dir") or was_given(ctx, "config")
    found = None if named else nearest_project()
    return given if found is None else found.folder / given


def was_given(ctx: typer.Context, name: str) -> bool:
    """Whether the command line gives this parameter."""
    source = ctx.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE"


Config = Annotated[
    Path,
    typer.Option(
        "-c",
        "--config",
        help="Project file; it names the other configuration files. Else tedm.toml, or configs/tedm.toml, of this"
        " folder or of the nearest above.",
        show_default=False,
        callback=_project_file,
    ),
]
BuildDir = Annotated[
    Path,
    typer.Option(
        "-d",
        "--build-dir",
        help="Folder of the files between stages. Else build, in the folder of the project that was found.",
        show_default=False,
        callback=_build_folder,
    ),
]
Output = Annotated[Path | None, typer.Option("-o", "--output", help="Write here instead of into the build folder.")]
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Print errors only.")]
Verbose = Annotated[int, typer.Option("-v", "--verbose", count=True, help="Say more on stderr; -vv adds tracebacks.")]
Json = Annotated[bool, typer.Option("--json", help="Print the answer as JSON.")]

DEFAULT_CONFIG = Path("tedm.toml")
DEFAULT_BUILD = Path("build")


@cache
def command_line() -> Any:
    """The commands of `app` as Typer runs them: made once, as the signatures of all of them are read for it."""
    return typer.main.get_command(app)


_verbosity = 0


def verbosity() -> int:
    """How often -v was given to the command that runs."""
    return _verbosity


def open_project(config: Path, build_dir: Path, verbose: int) -> Project:
    """Read the project file, and remember how much to say."""
    from tedm_cli.config.project import load_project

    global _verbosity
    _verbosity = verbose
    project = load_project(config, build_dir)
    if verbose:
        tell([f"{project.title}: {config}, results in {build_dir}"])
    return project


def say(quiet: bool, *lines: str) -> None:
    """Print results, unless they are not wanted."""
    if lines and not quiet:
        print("\n".join(lines))


def _version(value: bool) -> None:
    if value:
        print(f"tedm {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and leave.")
    ] = False,
) -> None:
    """Options before the subcommand."""
