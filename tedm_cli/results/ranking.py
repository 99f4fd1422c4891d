"""The largest of several, where ties up to rounding must not choose."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

T = TypeVar("T")
ALIKE = 1e-6  # relative difference of what is told once


def first_largest(items: Sequence[T], values: Sequence[float]) -> T:
    """The first of the items whose value is largest; symmetric models tie up to rounding, which must not choose."""
    return items[next(i for i, v in enumerate(values) if v >= max(values) * (1 - 1e-9))]


def all_largest(items: Sequence[T], values: Sequence[float]) -> list[T]:
    """The items whose value is largest, those that differ from it by no more than what is told once as well."""
    return [item for item, v in zip(items, values, strict=True) if v >= max(values) * (1 - ALIKE)]
