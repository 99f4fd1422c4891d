"""Standard output and standard error: open whatever the caller did, without signs that steer a terminal."""

from __future__ import annotations

import contextlib
import io
import os
import re
import sys
from collections.abc import Iterable, Iterator
from typing import Any

from tedm_cli.cli.entries import placed_lines
from tedm_cli.errors import ConfigError, TedmError

# Control characters but the line feed, what turns the direction of writing, spaces of no width, other line ends, halves
# of characters. What joins or parts letters of some scripts stays.
_STEERING = re.compile(
    "[\x00-\x09\x0b-\x1f\x7f-\x9f\u061c\u200b\u200e\u200f\u2028-\u202e\u2060-\u2064\u2066-\u2069\ud800-\udfff\ufeff]"
)


class OutputLostError(Exception):
    """Standard output cannot be written; `__cause__` says why."""


class Answers(io.TextIOBase):
    """Standard output. A failure to write it is told apart from failures of files.

    A reader of a pipe who has left (`| head`) is none: what would still be printed is dropped.
    """

    def __init__(self, stream: Any) -> None:
        self._stream = stream
        self._lost: OSError | None = None

    def write(self, text: str) -> int:
        with self._told_apart():
            self._stream.write(inert(text))
        return len(text)

    def flush(self) -> None:
        with self._told_apart():
            self._stream.flush()

    def close(self) -> None:
        """The stream itself stays open, and a finaliser that flushes it once more would have nobody to tell."""

    def isatty(self) -> bool:
        return bool(self._stream.isatty())

    def fileno(self) -> int:
        return int(self._stream.fileno())

    def writable(self) -> bool:
        return True

    @contextlib.contextmanager
    def _told_apart(self) -> Iterator[None]:
        if self._lost is not None:  # somebody has caught it
            raise OutputLostError from self._lost
        try:
            yield
        except BrokenPipeError:
            _forget(self._stream)
        except OSError as exc:
            self._lost = exc
            _forget(self._stream)
            raise OutputLostError from exc


@contextlib.contextmanager
def answers() -> Iterator[None]:
    """Put `Answers` in the place of standard output."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a name in another encoding is no reason to fail
    before = sys.stdout
    sys.stdout = Answers(before)
    try:
        yield
    finally:
        sys.stdout = before


def inert(text: str) -> str:
    """The text with every sign that would steer a terminal in its place as an escape, such as \\x1b."""
    return _STEERING.sub(lambda found: found[0].encode("unicode_escape").decode("ascii"), text)


def tell(lines: Iterable[str]) -> None:
    """Print lines on standard error, which may be closed or full: then nobody wants to know."""
    try:
        for line in lines:
            sys.stderr.write(inert(line).replace("\n", "\\n") + "\n")
        sys.stderr.flush()
    except OSError:
        _forget(sys.stderr)


def refusal_lines(exc: TedmError) -> list[str]:
    """`error: where: fact` (a line for each problem of a configuration or layout) and `hint: fix`."""
    lines = []
    for line in placed_lines(exc) if isinstance(exc, ConfigError) else exc.fact.split("\n"):
        prefix = f"{exc.where}: " if exc.where and not line.startswith(exc.where) else ""
        lines.append(f"error: {prefix}{line}")
    return [*lines, f"hint: {exc.hint}"] if exc.hint else lines


def _forget(stream: Any) -> None:
    """What is still buffered must not fail a second time when the process ends."""
    with contextlib.suppress(OSError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)


def open_all() -> None:
    """Open the streams that the caller has closed, before any file or pipe is taken for one of them.

    Standard output can then not be written, which whoever writes to it is told.
    """
    for number, flags in ((0, os.O_RDONLY), (1, os.O_RDONLY), (2, os.O_WRONLY)):
        try:
            os.fstat(number)
        except OSError:
            handle = os.open(os.devnull, flags)
            if handle != number:
                os.dup2(handle, number)
                os.close(handle)
    if sys.stdout is None:
        sys.stdout = open(1, "w", closefd=False)  # noqa: SIM115 (as long as the process)
    if sys.stderr is None:
        sys.stderr = open(2, "w", closefd=False)  # noqa: SIM115
