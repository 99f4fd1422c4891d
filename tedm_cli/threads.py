"""The same work on several things side by side, for code that spends its time outside the interpreter; or on one."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

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


class _Limit:
    """How many threads of this process are in `one_thread`, and what puts the libraries back."""

    lock = threading.Lock()
    inside = 0
    limits: Any = None


@contextlib.contextmanager
def one_thread() -> Iterator[None]:
    """Products of matrices are made by one thread each, in the whole process: by how many changes their last bits."""
    from threadpoolctl import threadpool_limits

    with _Limit.lock:
        if _Limit.inside == 0:
            _Limit.limits = threadpool_limits(limits=1)
        _Limit.inside += 1
    try:
        yield
    finally:
        with _Limit.lock:
            _Limit.inside -= 1
            if _Limit.inside == 0:
                _Limit.limits.restore_original_limits()
