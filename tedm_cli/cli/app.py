"""The Typer application, and how its commands begin and say what came out."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tedm_cli import __version__
from tedm_cli.cli.headings import Headed
from tedm_cli.cli.streams import tell

if TYPE_CHECKING:
    from tedm_cli.config.project import Project

app = typer.Typer(
    name="tedm",
    help="Thermo-elastic distortion modelling for drag-free satellites: from a Nastran model and its unit-load results"
    " to self-gravity and read-out noise, judged against requirements.",
    cls=Headed,
    epilog="""To begin: `tedm init demo`, `cd demo`, `tedm run`. The last runs all stages that are not up to date; its
help lists them in order. `tedm COMMAND --help` explains a command. `tedm --install-completion` lets the shell complete
commands, and the names of a project's cases, outputs and areas.""",
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


@cache
def command_line() -> Any:
    """The commands of `app` as Typer runs them: made once, as the signatures of all of them are read for it."""
    group: Any = typer.main.get_command(app)
    for command in group.commands.values():
        for parameter in command.params:
            if parameter.param_type_name == "argument":
                # What an argument is stands in its name; Typer would add the Python type behind it.
                parameter.display_type_rich = _no_type
    return group


def _no_type(ctx: typer.Context) -> None:
    """What help says of the type of an argument."""


_verbosity = 0


def verbosity() -> int:
    """How often -v was given to the command that runs."""
    return _verbosity


def begin(verbose: int, *told: str) -> None:
    """Remember how much to say; of what is `told`, with -v, that this is begun."""
    global _verbosity
    _verbosity = verbose
    if verbose:
        tell(told)


def open_project(config: Path, build_dir: Path, verbose: int) -> Project:
    """Read the project file, and remember how much to say."""
    from tedm_cli.config.project import load_project

    begin(verbose)
    project = load_project(config, build_dir)
    begin(verbose, f"{project.title}: {config}, results in {build_dir}")
    return project


def say(quiet: bool, *lines: str) -> None:
    """Print results, unless they are not wanted."""
    if lines and not quiet:
        print("\n".join(lines))


def answer(as_json: bool, quiet: bool, lines: Callable[[], Iterable[str]], as_dict: Callable[[], Any]) -> None:
    """Print results for a person, unless they are not wanted, or for a program."""
    if as_json:
        from tedm_cli.cli.printing.as_json import json_text

        print(json_text(as_dict()))
    else:
        say(quiet, *([] if quiet else lines()))


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
