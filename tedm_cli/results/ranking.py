"""The largest of several, where ties up to rounding must not choose."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

T = TypeVar("T")


def first_largest(items: Sequence[T], values: Sequence[float]) -> T:
    """The first of the items whose value is largest; symmetric models tie up to rounding, which must not choose."""
    return items[next(i for i, v in enumerate(values) if v >= max(values) * (1 - 1e-9))]
