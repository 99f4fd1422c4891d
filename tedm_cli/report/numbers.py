"""Numbers as words of a report."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tedm_cli.results.noise import SUPERSCRIPT, ratio_text


def sci(value: float, digits: int = 4) -> str:
    """A number with powers of ten raised, plain where it is of everyday size."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g}".replace("-0", "0").replace("-", "−")
    if 1e-3 <= abs(value) < 1e5:
        return f"{value:.{digits}g}".replace("-", "−") if abs(value) < 10**digits else f"{value:.0f}".replace("-", "−")
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    return f"{mantissa} × 10{str(int(exponent)).translate(SUPERSCRIPT)}".replace("-", "−")


def span(low: float, high: float) -> str:
    """A range of ratios; one number where its ends read the same."""
    ends = ratio_text(low), ratio_text(high)
    return ends[0] if ends[0] == ends[1] else " to ".join(ends)


def percent(share: float, digits: int = 0) -> str:
    """A share of the power; signed where it cancels."""
    text = f"{100 * share:.{digits}f} %"
    return text.removeprefix("-") if float(text[:-2]) == 0.0 else text.replace("-", "−")


def count(n: int, noun: str, plural: str = "") -> str:
    """`1 case`, `2 cases`."""
    return f"{n} {noun if n == 1 else plural or noun + 's'}"


def vector(values: Sequence[float]) -> str:
    return f"({', '.join(sci(float(v), 5) for v in values)})"


def listed(names: Sequence[str]) -> str:
    """`a`, `a and b`, `a, b and c`."""
    return " and ".join([", ".join(names[:-1]), names[-1]]) if len(names) > 1 else "".join(names)
