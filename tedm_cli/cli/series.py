"""What run-series and simulate --series share: all series that are named are run, then the first refusal is told."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

from tedm_cli.cli.app import answer
from tedm_cli.cli.streams import tell
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
    as_dict: Callable[[R], dict[str, Any]],
    as_json: bool,
    violated: Callable[[R], str],
    quiet: bool,
) -> None:
    """Run the series that are wanted, print what became of them, and raise what is to be told in the end.

    Parameters
    ----------
    run : the stage. lines, as_dict : a result in words, and for programs.
    violated : name of a series that exceeds a requirement, where that is an error; else "".

    Raises
    ------
    UsageError : one output for several series. PhysicsError : a requirement that is violated.
    TedmError : the first refusal of a series, when the others have been told of.
    """
    from tedm_cli.errors import PhysicsError, TedmError, UsageError
    from tedm_cli.progress import progress
    from tedm_cli.stages.temperature_series import no_series, select_series

    names = select_series(project, wanted)
    if not names:
        if as_json:
            tell([no_series(project)])
        answer(as_json, quiet, lambda: [no_series(project)], lambda: [])
        return
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
    answer(as_json, quiet, lambda: [line for r in done for line in lines(r)], lambda: [as_dict(r) for r in done])
    if refused is not None:
        raise refused
    if failed := [name for r in done if (name := violated(r))]:
        raise PhysicsError(f"requirements are violated in series {', '.join(failed)}")
