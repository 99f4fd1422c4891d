"""The same work on several things side by side, for code that spends its time outside the interpreter."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


class _StoppedError(Exception):
    """Work that nobody waits for any more."""


def side_by_side(
    work: Callable[[Item, Callable[[int], None]], Result], items: Sequence[Item], advance: Callable[[int], None]
) -> list[Result]:
    """``work(item, advance)`` of every item, on as many threads as there are processors.

    `advance` is called by one thread at a time. The exception of the first item that fails, or an interrupt, ends the
    other threads at their next call of it.
    """
    stopped, one = threading.Event(), threading.Lock()

    def guarded(more: int) -> None:
        if stopped.is_set():
            raise _StoppedError
        with one:
            advance(more)

    pool = ThreadPoolExecutor(max(1, min(len(items), os.cpu_count() or 1)))
    try:
        futures = [pool.submit(work, item, guarded) for item in items]
        return [future.result() for future in futures]
    except BaseException:
        stopped.set()
        raise
    finally:
        # Whoever interrupts does not wait for a compiler or a solver in another thread.
        pool.shutdown(wait=not isinstance(sys.exc_info()[1], KeyboardInterrupt), cancel_futures=True)
