"""Timing of a piece of work against its peer, in one process."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median

RUNS = 7


@dataclass(frozen=True)
class Times:
    """Seconds of several runs: of the processor (user and system, all threads), and of the clock."""

    processor: tuple[float, ...]
    clock: tuple[float, ...]

    @property
    def best(self) -> float:
        """Least seconds of processor: what other programs disturb least."""
        return min(self.processor)

    @property
    def median(self) -> float:
        return median(self.processor)


@dataclass(frozen=True)
class Result:
    """A piece of work and its peer in the same run; `each` is the number of things done and what they are."""

    ours: Times
    peer: Times | None
    note: str = ""
    each: tuple[float, str] | None = None

    @property
    def each_s(self) -> float:
        """Best seconds of processor for one of the things done."""
        return self.ours.best / (self.each[0] if self.each else 1.0)

    @property
    def ratio(self) -> float | None:
        """Of the best seconds of processor."""
        return self.ours.best / self.peer.best if self.peer else None


def timed(
    work: Callable[[], object],
    peer: Callable[[], object] | None,
    note: str = "",
    runs: int = RUNS,
    each: tuple[float, str] | None = None,
) -> Result:
    """Run both in turn, so that a change of the machine's speed meets both; a single run has no warm-up."""
    calls = [call for call in (work, peer) if call]
    if runs > 1:
        for call in calls:
            call()
    found: list[list[tuple[float, float]]] = [[] for _ in calls]
    for _ in range(runs):
        for call, times in zip(calls, found, strict=True):
            clock, processor = time.perf_counter(), time.process_time()
            call()
            times.append((time.process_time() - processor, time.perf_counter() - clock))
    ours, *theirs = (Times(tuple(one[0] for one in times), tuple(one[1] for one in times)) for times in found)
    return Result(ours, theirs[0] if theirs else None, note, each)
