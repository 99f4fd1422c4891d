"""Timing of a piece of work against its peer."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median

RUNS = 7


@dataclass(frozen=True)
class Result:
    """Median seconds of the work and of its peer in the same run, and what else is to be said."""

    ours: float
    peer: float
    note: str = ""


def timed(work: Callable[[], object], peer: Callable[[], object], note: str = "", runs: int = RUNS) -> Result:
    """Run both in turn, so that a change of the machine's speed meets both; a single run has no warm-up."""
    if runs > 1:
        work(), peer()
    ours, theirs = [], []
    for _ in range(runs):
        for call, times in ((work, ours), (peer, theirs)):
            start = time.perf_counter()
            call()
            times.append(time.perf_counter() - start)
    return Result(median(ours), median(theirs), note)
