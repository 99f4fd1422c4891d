"""Progress of long work on stderr, with the time left; silent when stderr is not a terminal."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator

Step = Callable[[int, int, str], None]


def silent(done: int, total: int, what: str) -> None:
    """A `Step` that says nothing."""


@contextlib.contextmanager
def progress(quiet: bool = False) -> Iterator[Step]:
    """Yield a function `step(done, total, what)` that draws one bar per `what`."""
    if quiet or not sys.stderr.isatty():
        yield silent
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    # What is printed meanwhile goes above the bar, if it goes to the terminal at all.
    screen = sys.stdout.isatty()
    with Progress(*columns, console=Console(stderr=True), transient=True, redirect_stdout=screen) as bar:
        tasks: dict[str, TaskID] = {}

        def step(done: int, total: int, what: str) -> None:
            if what not in tasks:
                tasks[what] = bar.add_task(what, total=total)
            bar.update(tasks[what], completed=done, total=total)

        yield step


@contextlib.contextmanager
def waiting(quiet: bool, what: str) -> Iterator[None]:
    """Show `what` and the time since the beginning, for work that does not say how far it is."""
    if quiet or not sys.stderr.isatty():
        yield
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        bar.add_task(what, total=None)
        yield


def counter(step: Step, total: int, what: str) -> Callable[[int], None]:
    """A function that is told how much was done since its last call, where `step` wants to know how much in all."""
    done = 0

    def advance(more: int) -> None:
        nonlocal done
        done += more
        step(done, total, what)

    return advance
