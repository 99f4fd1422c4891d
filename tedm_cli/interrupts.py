"""Ctrl-C and requests to end: they reach the work wherever it is, and never cut in two what must stay whole.

Python raises `KeyboardInterrupt` wherever the main thread happens to be. There it can be lost: in a callback of a C
library or a finaliser it is printed and forgotten, and libraries catch it with bare `except`. It can also come between
two steps that belong together, such as writing a file and giving it its name. So an interrupt waits while a function
marked `whole` runs, and is repeated until it has come out at the command line.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import signal
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from types import CodeType, FrameType, TracebackType
from typing import Any, TypeVar

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_SOON_S, _AGAIN_S = 0.02, 1.0  # next try of an interrupt that had to wait, and of one that was raised
_PATIENCE_S = 2.0  # for a C library that does not return to the interpreter

Function = TypeVar("Function", bound=Callable[..., Any])

# Leaving a context is cleaning up, whoever's it is.
_WHOLE: set[CodeType] = {contextlib._GeneratorContextManager.__exit__.__code__}

#: Files under construction, for an end that leaves no time for `finally`.
unfinished: set[Path] = set()


def whole(function: Function) -> Function:
    """Mark a function, or a generator while it runs: an interrupt waits until it is done."""
    _WHOLE.add(function.__code__)
    return function


class Interrupts:
    """Context in which SIGINT, SIGTERM and SIGHUP raise `KeyboardInterrupt`, again and again until it is left.

    Signals that whoever started the process wants to be ignored (`nohup`, jobs in the background) stay ignored.
    Leaving swallows the interrupt; `number` is then its signal. `release` gives the signals back.
    """

    def __init__(self) -> None:
        self.number: int | None = None
        self._over = False
        self._done = threading.Event()
        self._before: dict[int, Any] = {}
        self._hook = sys.unraisablehook
        self._wakeup = -1

    def __enter__(self) -> Interrupts:
        if threading.current_thread() is not threading.main_thread():
            return self  # signals belong to the main thread
        sys.unraisablehook = self._unraisable
        for number in _SIGNALS:
            if signal.getsignal(number) not in (signal.SIG_IGN, None):
                self._before[number] = signal.signal(number, self._handle)
        if self._before:
            self._before[signal.SIGALRM] = signal.signal(signal.SIGALRM, self._handle)
            self._watch()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, exc: BaseException | None, trace: TracebackType | None
    ) -> bool:
        self._over = True
        self._done.set()
        if isinstance(exc, KeyboardInterrupt):
            self.number = self.number or signal.SIGINT
        return isinstance(exc, KeyboardInterrupt)

    def release(self) -> None:
        """Give the signals back; from then on an interrupt ends the process without a word on its way out."""
        if self.number is not None:
            # Python remembers an interrupt that came through `eval` or `exec`, and would end by the signal and not with
            # the code it is given. The next `eval` forgets it.
            eval("0")
        if not self._before:
            return
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.set_wakeup_fd(-1)
        os.close(self._wakeup)  # ends the watch
        atexit.unregister(_leave)
        atexit.register(_leave)
        for number, handler in self._before.items():
            signal.signal(number, handler)
        sys.unraisablehook = self._hook

    def _handle(self, number: int, frame: FrameType | None) -> None:
        if self._over:
            return
        if number != signal.SIGALRM:
            self.number = self.number or number
        if self.number is None:
            return
        waits = _within_whole(frame)
        signal.setitimer(signal.ITIMER_REAL, _SOON_S if waits else _AGAIN_S)
        if not waits:
            raise KeyboardInterrupt

    def _unraisable(self, args: Any) -> None:
        """An interrupt that is lost on its way comes again: nothing to tell."""
        if not issubclass(args.exc_type, KeyboardInterrupt):
            self._hook(args)

    def _watch(self) -> None:
        """A thread that ends the process when the main thread does not come back from a C library to be interrupted."""
        reads, writes = os.pipe()
        os.set_blocking(writes, False)
        signal.set_wakeup_fd(writes, warn_on_full_buffer=False)
        self._wakeup = writes

        def run() -> None:
            asked = {int(n) for n in _SIGNALS}
            try:
                while numbers := os.read(reads, 1):
                    if numbers[0] in asked and not self._done.wait(_PATIENCE_S):
                        while _within_whole(sys._current_frames().get(main)):
                            if self._done.wait(_SOON_S):
                                return
                        for path in list(unfinished):
                            path.unlink(missing_ok=True)
                        os._exit(128 + numbers[0])
            finally:
                os.close(reads)

        main = threading.main_thread().ident or 0
        threading.Thread(target=run, daemon=True).start()


for _method in (Interrupts.__enter__, Interrupts.__exit__, Interrupts.release):
    whole(_method)


def leave_if_threads_run(code: int) -> None:
    """End the process at once where the interpreter would wait for threads that are still at work."""
    if any(not t.daemon and t is not threading.main_thread() for t in threading.enumerate()):
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def _within_whole(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code in _WHOLE:
            return True
        frame = frame.f_back
    return False


def _leave() -> None:
    """The interpreter shuts down: what was to be done is done."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
