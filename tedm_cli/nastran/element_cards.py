"""TEMPP1 and TEMPRB cards of unit loads: elements with temperatures of their own, by lists and ranges of their ids."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from decimal import Decimal

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.nastran.temperature_sets import MAX_ID, plain

_RUN = 5  # consecutive ids from which on a range is written
_LISTED = 8  # further ids of a card, those of one continuation in small fields
_LARGE_FIELD = 16


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
        texts = [(real(float(a), unit), real(float(b), unit)) for a, b in values]
        for pair in dict.fromkeys(texts):
            mine = ids[rows[[t == pair for t in texts]]]
            one, two = pair
            fields = [plain(mean), one] if name == "TEMPP1" else [*[plain(mean)] * 2, one, one, two, two]
            for first, rest in _lists(mine):
                lines += _card(name, [str(sid), str(first), *fields], rest)
    return lines


def real(value: float, unit: Decimal = Decimal(1)) -> str:
    """`value` times `unit` as a large field holds it, short where it is."""
    short = plain((Decimal(repr(value)) * unit).normalize() + 0)
    if len(short) <= _LARGE_FIELD // 2:
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


def _card(name: str, fields: Sequence[str], rest: Sequence[str]) -> list[str]:
    """Lines of a card with its list `rest` in lines of their own; in large fields where small ones are too narrow."""
    large = max(map(len, fields)) > _LARGE_FIELD // 2 or int(fields[1]) > MAX_ID or any(len(r) > 8 for r in rest)
    width, per_line, mark = (_LARGE_FIELD, 4, "*") if large else (8, 8, "+")
    padded = list(fields) + [""] * (-len(fields) % 8)
    if rest:
        padded += [""] * (8 if name == "TEMPRB" else 0)  # temperatures of fibres, for stresses
        padded += list(rest) + [""] * (-len(rest) % 8)
    rows = [padded[k : k + per_line] for k in range(0, len(padded), per_line)]
    while not large and not any(rows[-1]):
        rows.pop()
    starts = [f"{name}{'*' if large else '':{8 - len(name)}}", *[f"{mark:8}"] * (len(rows) - 1)]
    return [(start + "".join(f"{f:>{width}}" for f in row)).rstrip() for start, row in zip(starts, rows, strict=True)]
