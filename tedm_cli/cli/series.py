"""What run-series and simulate --series share: all series that are named are run, then the first refusal is told."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

from tedm_cli.cli.app import say
from tedm_cli.config.project import Project
from tedm_cli.progress import Step

R = TypeVar("R")
Run = Callable[[Project, Sequence[str], Path | None, Step, Callable[[R], None]], None]


def run_named_series(
    project: Project,
    wanted: list[str],
    output: Path | None,
    *,
    run: Run[R],
    lines: Callable[[R], list[str]],
    as_dict: Callable[[R], dict[str, Any]] | None,
    violated: Callable[[R], str],
    quiet: bool,
) -> None:
    """Run the series that are wanted, print what became of them, and raise what is to be told in the end.

    Parameters
    ----------
    run : the stage. lines, as_dict : a result in words, and for programs where that is asked for.
    violated : name of a series that exceeds a requirement, where that is an error; else "".

    Raises
    ------
    UsageError : one output for several series. PhysicsError : a requirement that is violated.
    TedmError : the first refusal of a series, when the others have been told of.
    """
    from tedm_cli.errors import PhysicsError, TedmError, UsageError
    from tedm_cli.progress import progress
    from tedm_cli.stages.temperature_series import select_series

    names = select_series(project, wanted)
    if output is not None and len(names) > 1:
        raise UsageError(f"--output names one file, but {len(names)} series are run")
    done: list[R] = []
    refused: TedmError | None = None
    try:
        with progress(quiet) as step:
            run(project, names, output, step, done.append)
    except TedmError as error:
        if not done:
            raise
        refused = error
    if as_dict is not None:
        print(json.dumps([as_dict(r) for r in done], indent=1))
    else:
        for r in done:
            say(quiet, *lines(r))
    if refused is not None:
        raise refused
    if failed := [name for r in done if (name := violated(r))]:
        raise PhysicsError(f"requirements are violated in series {', '.join(failed)}")
