"""A solver that writes on the standard output, kept from it: what is printed there are results."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import Any


def solved_quietly(solver: Callable[..., Any], *args: Any, **options: Any) -> Any:
    """``solver(*args, **options)``, whatever it prints from outside of Python left out (HiGHS has such lines)."""
    sys.stdout.flush()
    try:
        kept = os.dup(1)
    except OSError:  # there is no standard output
        return solver(*args, **options)
    nothing = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nothing, 1)
        return solver(*args, **options)
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nothing)
