"""A refusal as lines on stderr."""

from __future__ import annotations

import sys

from tedm_cli.errors import TedmError, printable


def print_refusal(exc: TedmError) -> None:
    """Print `error: where: fact` (a line for each problem of a configuration or layout) and `hint: fix`."""
    for line in str(exc).splitlines():
        prefix = f"{exc.where}: " if exc.where and not line.startswith(exc.where) else ""
        print(printable(f"error: {prefix}{line}"), file=sys.stderr)
    if exc.hint:
        print(printable(f"hint: {exc.hint}"), file=sys.stderr)
    sys.stderr.flush()
