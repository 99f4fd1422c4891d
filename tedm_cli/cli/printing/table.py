"""A table of text: columns padded to their widest entry."""

from __future__ import annotations

from collections.abc import Sequence

_ROUNDING = 1e-9  # of the largest of their kind, numbers this small are rounding


def above_rounding(value: float, scale: float) -> float:
    """The value, and 0 where it is rounding beside numbers of the size `scale`."""
    return value if abs(value) > _ROUNDING * abs(scale) else 0.0


def scientific(value: float, scale: float, digits: int) -> str:
    """A number with `digits` behind the point; 0 where it is rounding beside numbers of the size `scale`."""
    shown = above_rounding(value, scale)
    return f"{shown:.{digits}e}" if shown else "0"


def table(head: Sequence[str], rows: Sequence[Sequence[str]], right: Sequence[int] = ()) -> list[str]:
    """Columns padded to their widest entry; columns in `right` are aligned to the right."""
    widths = [max(len(str(r[i])) for r in [head, *rows]) for i in range(len(head))]

    def line(cells: Sequence[str]) -> str:
        padded = [c.rjust(w) if i in right else c.ljust(w) for i, (c, w) in enumerate(zip(cells, widths, strict=True))]
        return "  ".join(padded).rstrip()

    return [line(head), "  ".join("-" * w for w in widths), *(line(r) for r in rows)]
