"""TEMP cards of fields over all grids, for a Nastran of the user's own."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from decimal import ROUND_HALF_EVEN, Decimal

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.nastran.loads.temperature_sets import plain

FIELD = 16  # characters of a large field


def field_text(value: Decimal) -> str:
    """A real number with all the digits that a large field has room for; with an exponent where that shows more.

    A number below 1e-3 loses digits to zeros: 1.23456789012E-5 has 12 of them.
    """
    if value and abs(value) < Decimal("1e-3"):
        digits, exponent = f"{value:.15E}".split("E")
        tail = f"E{int(exponent)}"
        room = FIELD - len(tail)
        return _rounded(Decimal(digits), room) + tail
    return _rounded(value, FIELD)


def _rounded(value: Decimal, room: int) -> str:
    whole = f"{value:f}".partition(".")[0]
    decimals = max(room - len(whole) - 1, 0)
    text = plain(value.quantize(Decimal(1).scaleb(-decimals), rounding=ROUND_HALF_EVEN))
    return text if len(text) <= room else plain(value.quantize(Decimal(1).scaleb(1 - decimals)))


def grid_temperature_lines(sid: int, rest: Decimal, grid_id: IntArray, temperature: Sequence[Decimal]) -> Iterator[str]:
    """TEMPD of what no TEMP names, and TEMP of the grids, in large fields.

    Parameters
    ----------
    rest, temperature : in the deck's own scale; [n], of the grids.
    """
    yield f"{'TEMPD*':<8}{sid:>16}{field_text(rest):>16}"
    yield "*"
    pairs = [f"{grid:>16}{field_text(t):>16}" for grid, t in zip(grid_id.tolist(), temperature, strict=True)]
    for start in range(0, len(pairs), 3):
        three = pairs[start : start + 3]
        fields = "".join([f"{sid:>16}", *three])
        yield f"{'TEMP*':<8}{fields[:64]}"
        yield f"{'*':<8}{fields[64:]}".rstrip()


def absolute(step: FloatArray, rest: Decimal, degrees_per_kelvin: Decimal) -> list[Decimal]:
    """Temperatures in the deck's scale of steps (K) above the reference."""
    return [rest + Decimal(repr(float(value))) * degrees_per_kelvin for value in np.asarray(step)]
