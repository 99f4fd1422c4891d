"""The fields of cards of one name and one number of lines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, IntArray
from tedm_cli.nastran.bulk.lines import NAME, Cards
from tedm_cli.nastran.bulk.numbers import Bytes, Column, integers, reals, window

_LARGE = 16  # columns of a large field
_WIDEST = 20  # characters of a field in free form


@dataclass(frozen=True)
class Form:
    """Free, small or large fields."""

    is_free: bool
    is_large: bool

    @property
    def per_line(self) -> int:
        """Fields of a line, without its name and that of its continuation."""
        return 4 if self.is_large else 8

    @property
    def suffix(self) -> str:
        """What stands behind the name of a card."""
        return "*" if self.is_large else ""


FORMS = (Form(False, False), Form(False, True), Form(True, False))


class Fields:
    """The fields of n cards of the same form, counted from 0 behind the name; `read` [n] says which cards are plain."""

    def __init__(self, cards: Cards, rows: IntArray, form: Form) -> None:
        self._cards, self._form = cards, form
        self.first = cards.first[rows]
        self.read: BoolArray = np.ones(len(rows), dtype=bool)

    def integer(self, field: int, *, optional: bool = False) -> IntArray:
        """Integers [n]; 0 where they are blank."""
        column = integers(self._text(field))
        self._judge(column, optional=optional)
        return np.asarray(column.value, dtype=np.int64)

    def real(self, field: int) -> Column:
        """Reals [n], which may be blank."""
        column = reals(self._text(field))
        self._judge(column, optional=True)
        return column

    def integer_or_real(self, field: int) -> tuple[Column, Column]:
        """Integers and reals [n]; a field is one of the two, or blank in both."""
        text = self._text(field)
        whole, real = integers(text), reals(text)
        self.read &= whole.read | real.read
        return whole, real

    def components(self, field: int) -> IntArray:
        """Components, 1 to 6 in ascending order, as one number; 0 where they are blank."""
        text = self._text(field)
        column = integers(text)
        self._judge(column, optional=True)
        value = np.asarray(column.value, dtype=np.int64)
        rows = np.flatnonzero(~column.blank)
        digits = (text[rows] != ord(" ")).sum(axis=1)
        self.read[rows] &= np.isin(value[rows], _COMPONENTS) & (value[rows] >= 10 ** (digits - 1))  # no zero leads
        return value

    def blank(self, start: int, end: int) -> None:
        """The fields from `start` to before `end` must be blank."""
        for field in range(start, end):
            self.read &= (self._text(field) == ord(" ")).all(axis=1)

    def _judge(self, column: Column, *, optional: bool) -> None:
        self.read &= column.read & (~column.blank | optional)

    def _text(self, field: int) -> Bytes:
        lines, form = self._cards.lines, self._form
        line = self.first + field // form.per_line
        place, limit = field % form.per_line, lines.end[line]
        if not form.is_free:
            width = _LARGE if form.is_large else NAME
            start = np.minimum(lines.start[line] + NAME + width * place, limit)
            return window(lines.block, start, np.minimum(start + width, limit), width)
        before, after = lines.commas[line] + place, lines.commas[line + 1]
        last = max(len(lines.comma) - 1, 0)
        start = np.where(before < after, lines.comma[np.minimum(before, last)] + 1, limit)
        end = np.where(before + 1 < after, lines.comma[np.minimum(before + 1, last)], limit)
        long = end - start > _WIDEST
        self.read &= ~long
        width = max(int((end - start)[~long].max(initial=1)), 1)
        return window(lines.block, start, np.where(long, start, end), width)


_COMPONENTS = [
    int("".join(chosen)) for bits in range(1, 64) for chosen in [[str(i + 1) for i in range(6) if bits >> i & 1]]
]
