"""TEMPP1 and TEMPRB cards of unit loads: elements with temperatures of their own.

Solvers differ in how they read lists of elements: those of TEMPRB stand in the third line for MSC Nastran and in the
second for MYSTRAN, which also loses a line that begins with + alone, and says nothing. So lists are written of TEMPP1
alone, in small fields and in lines that begin with blanks; of all else there is a card for each element.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from decimal import Decimal

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.nastran.loads.temperature_sets import MAX_ID, plain

_RUN = 5  # consecutive ids from which on a range is written
_LISTED = 8  # further ids of a card, those of one continuation in small fields
_SMALL, _LARGE = 8, 16  # columns of a field


def element_cards(
    sid: int,
    ids: IntArray,
    shell: BoolArray,
    mean: Decimal,
    gradient: FloatArray | None = None,
    unit: Decimal = Decimal(1),
) -> list[str]:
    """Cards that give elements `ids` [m] (ascending) a mean temperature and a gradient.

    Parameters
    ----------
    shell : [m], TEMPP1 for those, TEMPRB for the others.
    mean : in the deck's scale, exact as written.
    gradient : [m, 2], K/m; of a shell along its normal and 0, of a bar in planes 1 and 2; None: nothing but zero.
    unit : what 1 K/m is in the deck.
    """
    lines = []
    for name, chosen in (("TEMPP1", shell), ("TEMPRB", ~shell)):
        rows = np.flatnonzero(chosen)
        values = np.zeros((len(rows), 2)) if gradient is None else gradient[rows]
        alike: dict[tuple[str, str], list[int]] = {}
        for eid, (a, b) in zip(ids[rows].tolist(), values.tolist(), strict=True):
            alike.setdefault((real(a, unit), real(b, unit)), []).append(eid)
        for (one, two), mine in alike.items():
            fields = [plain(mean), one] if name == "TEMPP1" else [*[plain(mean)] * 2, one, one, two, two]
            small = max(map(len, fields)) <= _SMALL and mine[-1] <= MAX_ID
            if small and name == "TEMPP1":
                for first, rest in _lists(np.array(mine)):
                    lines.append(_small(name, [str(sid), str(first), *fields]))
                    lines += [_small("", rest)] if rest else []
            else:
                for eid in mine:
                    card = [str(sid), str(eid), *fields]
                    lines += [_small(name, card)] if small else _large(name, card)
    return lines


def real(value: float, unit: Decimal = Decimal(1)) -> str:
    """`value` times `unit` as a large field holds it, short where it is."""
    short = plain((Decimal(repr(value)) * unit).normalize() + 0)
    if len(short) <= _SMALL:
        return short
    mantissa, exponent = f"{Decimal(repr(value)) * unit:.9e}".split("e")
    return f"{mantissa}{int(exponent):+d}"


def _lists(ids: IntArray) -> Iterator[tuple[int, list[str]]]:
    """The first element of each card, and its list."""
    left: list[int] = []
    for run in np.split(ids, np.flatnonzero(np.diff(ids) != 1) + 1):
        if len(run) >= _RUN:
            yield int(run[0]), [str(run[1]), "THRU", str(run[-1])]
        else:
            left += [int(i) for i in run]
    for k in range(0, len(left), 1 + _LISTED):
        yield left[k], [str(i) for i in left[k + 1 : k + 1 + _LISTED]]


def _small(name: str, fields: Sequence[str]) -> str:
    return f"{name:8}" + "".join(f"{f:>{_SMALL}}" for f in fields)


def _large(name: str, fields: Sequence[str]) -> list[str]:
    """The lines of a card of up to eight large fields."""
    parts = ("".join(f"{f:>{_LARGE}}" for f in part) for part in (fields[:4], fields[4:]))
    return [(start + part).rstrip() for start, part in zip((f"{name + '*':8}", "*       "), parts, strict=True)]
