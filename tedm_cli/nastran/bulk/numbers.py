"""Fields of bulk data as numbers, a column of cards at a time, where they are written plainly.

A field that is read here is read as pyNastran reads it, to the bit. What is unusual, or no number, is left to it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tedm_cli.arrays import BoolArray, FloatArray, IntArray

Bytes = NDArray[np.uint8]
Ids: TypeAlias = NDArray[Any]  # integers of any width: columns of millions of cards are kept in 4 bytes

SPACE = 0x20
MOST_DIGITS = 9  # of an integer; what has more may be larger than any id
_MARGIN = 128  # blanks behind a block, so that a window may reach over its end

# classes of characters
_BLANK, _DIGIT, _POINT, _SIGN, _LETTER, _OTHER = range(6)
_CLASS = np.full(256, _OTHER, dtype=np.uint8)
_CLASS[SPACE] = _BLANK
_CLASS[list(b"0123456789")] = _DIGIT
_CLASS[list(b".")] = _POINT
_CLASS[list(b"+-")] = _SIGN
_CLASS[list(b"eEdD")] = _LETTER

# What has been read of a real number. An exponent has at most two digits; its sign may stand without a letter.
_LEAD, _SIGNED, _WHOLE, _BARE_POINT, _POINTED, _FRACTION = range(6)
_EXPONENT, _EXPONENT_SIGN, _IMPLIED, _ONE, _TWO, _TRAIL, _BAD = range(6, 13)
_NEXT = np.full((13, 6), _BAD, dtype=np.uint8)
_ENDS = np.isin(np.arange(13), (_POINTED, _FRACTION, _ONE, _TWO, _TRAIL))
for _state, _by_class in {
    _LEAD: {_BLANK: _LEAD, _DIGIT: _WHOLE, _POINT: _BARE_POINT, _SIGN: _SIGNED},
    _SIGNED: {_DIGIT: _WHOLE, _POINT: _BARE_POINT},
    _WHOLE: {_DIGIT: _WHOLE, _POINT: _POINTED},
    _BARE_POINT: {_DIGIT: _FRACTION},
    _POINTED: {_DIGIT: _FRACTION, _SIGN: _IMPLIED, _LETTER: _EXPONENT, _BLANK: _TRAIL},
    _FRACTION: {_DIGIT: _FRACTION, _SIGN: _IMPLIED, _LETTER: _EXPONENT, _BLANK: _TRAIL},
    _EXPONENT: {_DIGIT: _ONE, _SIGN: _EXPONENT_SIGN},
    _EXPONENT_SIGN: {_DIGIT: _ONE},
    _IMPLIED: {_DIGIT: _ONE},
    _ONE: {_DIGIT: _TWO, _BLANK: _TRAIL},
    _TWO: {_BLANK: _TRAIL},
    _TRAIL: {_BLANK: _TRAIL},
}.items():
    for _class, _after in _by_class.items():
        _NEXT[_state, _class] = _after
_FLAT = _NEXT.ravel()


@dataclass(frozen=True)
class Column:
    """One field of n cards: value [n] (0 where blank), which are blank [n], which are read [n], blank ones too."""

    value: NDArray[np.float64] | IntArray
    blank: BoolArray
    read: BoolArray


def padded(data: bytes) -> Bytes:
    """The bytes of a block, and blanks behind them."""
    return np.frombuffer(data + b" " * _MARGIN, dtype=np.uint8)


def window(block: Bytes, start: IntArray, end: IntArray, width: int) -> Bytes:
    """Characters [n, width] of fields that begin and end there, with blanks behind shorter ones.

    Parameters
    ----------
    block : from `padded`. start, end : [n]. width : at most 80.
    """
    out: Bytes = np.lib.stride_tricks.sliding_window_view(block, width)[start]
    out[np.arange(width) >= (end - start)[:, None]] = SPACE
    return out


def integers(text: Bytes) -> Column:
    """Integers without a sign, of characters [n, width]."""
    cards = len(text)
    value, digits = np.zeros(cards, dtype=np.int64), np.zeros(cards, dtype=np.uint8)
    good, ended = np.ones(cards, dtype=bool), np.zeros(cards, dtype=bool)
    for column in np.ascontiguousarray(text.T):
        digit = (column >= ord("0")) & (column <= ord("9"))
        blank = column == SPACE
        good &= (digit & ~ended) | blank
        ended |= blank & (digits > 0)
        value = np.where(digit, 10 * value + column - ord("0"), value)
        digits += digit
    good &= digits <= MOST_DIGITS
    return Column(np.where(good, value, 0), digits == 0, good)


def reals(text: Bytes) -> Column:
    """Real numbers, of characters [n, width]: with a point, and an exponent of at most two digits."""
    state = np.zeros(len(text), dtype=np.uint8)
    implied = np.zeros(len(text), dtype=np.int64)  # columns of signs of exponents without a letter, from 1 on
    for number, column in enumerate(np.ascontiguousarray(_CLASS[text].T), start=1):
        state = _FLAT[6 * state + column]
        at = state == _IMPLIED
        if at.any():
            implied[at] = number
    blank, read = state == _LEAD, _ENDS[state]
    direct = read & (implied == 0)
    plain = np.where((text | 0x20) == ord("d"), np.uint8(ord("e")), text)
    plain[~direct] = SPACE
    plain[~direct, 0] = ord("0")
    value = _converted(plain)
    rows = np.flatnonzero(read & ~direct)
    if rows.size:
        value[rows] = _converted(_with_letters(text[rows], implied[rows] - 1))
    return Column(value, blank, read | blank)


def _with_letters(text: Bytes, at: IntArray) -> Bytes:
    """The same numbers with an `e` before the sign in column `at` [n]: `1.5-3` is `1.5e-3`."""
    columns = np.arange(text.shape[1] + 1)
    source = np.minimum(columns - (columns > at[:, None]), text.shape[1] - 1)
    out: Bytes = np.take_along_axis(text, source, axis=1)
    out[np.arange(len(out)), at] = ord("e")
    return out


def _converted(text: Bytes) -> FloatArray:
    """Numbers in Python's form, with blanks around them."""
    return np.ascontiguousarray(text).view(f"S{text.shape[1]}")[:, 0].astype(np.float64)
