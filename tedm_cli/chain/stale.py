"""Which steps of a chain have to run, and why: by the times of files, as Make does, and by what the files say."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from tedm_cli.chain.graph import Step

Times = Callable[[Path], int | None]
Contents = Callable[[Path], Sequence[str]]


def stale_steps(steps: Iterable[Step], time_of: Times, wrong: Contents) -> dict[Step, tuple[str, ...]]:
    """The steps that have to run, in their order, and why.

    Parameters
    ----------
    steps : in an order in which they can run.
    time_of : when a file was last changed; None where it is not there.
    wrong : what is wrong with a file that is there, and no older than what it is made of.
    """
    stale: dict[Step, tuple[str, ...]] = {}
    made: set[Path] = set()
    for step in steps:
        reasons = _by_time(step, made, time_of) or [why for path in step.outputs for why in wrong(path)]
        if reasons:
            stale[step] = tuple(reasons)
            made.update(step.outputs)
    return stale


def missing_inputs(steps: Iterable[Step], time_of: Times) -> list[Path]:
    """The files that are not there, and that none of the steps makes."""
    made: set[Path] = set()
    missing: list[Path] = []
    for step in steps:
        missing += [path for path in step.inputs if path not in made and time_of(path) is None]
        made.update(step.outputs)
    return list(dict.fromkeys(missing))


def _by_time(step: Step, made: set[Path], time_of: Times) -> list[str]:
    times = [time_of(path) for path in step.outputs]
    there = [time for time in times if time is not None]
    if len(there) < len(times):
        return [f"{path.name} is not there" for path, time in zip(step.outputs, times, strict=True) if time is None]
    anew = [path for path in step.inputs if path in made]
    oldest = min(there)
    newer = [p for p in step.inputs if p not in made and (time := time_of(p)) is not None and time > oldest]
    return [*(f"{path.name} is rebuilt" for path in anew), *(f"{path.name} is newer" for path in newer)]


class Queue:
    """Steps that wait for others, handed out one by one as they become ready."""

    def __init__(self, steps: Iterable[Step]) -> None:
        self._waiting = list(steps)
        self._unmade = {path for step in self._waiting for path in step.outputs}

    def next(self) -> Step | None:
        """A step whose inputs are all made, which is then under way; None where there is none now."""
        for step in self._waiting:
            if not self._unmade.intersection(step.inputs):
                self._waiting.remove(step)
                return step
        return None

    def done(self, step: Step) -> None:
        """Tell that a step has made its files."""
        self._unmade.difference_update(step.outputs)
