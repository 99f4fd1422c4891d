"""The lines of a block of bulk data, and the cards that they make."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tedm_cli.arrays import BoolArray, IntArray
from tedm_cli.nastran.bulk.numbers import SPACE, Bytes, padded, window
from tedm_cli.nastran.comments import has_lost_fields

NAME = 8  # columns
_TAIL = 72  # columns before the name of the continuation
_COLUMNS = 80
_MOST_COMMAS = 9
_UPPER = np.frombuffer(bytes(range(256)).upper(), dtype=np.uint8)
_COMMA, _DOLLAR, _STAR, _PLUS, _EQUALS = b",$*+="


class NotPlainError(Exception):
    """A deck that only pyNastran can judge as a whole; it never reaches a user."""


def word(name: bytes) -> int:
    """The first field of a line as one number."""
    return int(np.frombuffer(name.ljust(NAME), dtype=np.uint64)[0])


@dataclass(frozen=True)
class Lines:
    """L lines with code of a block: not those that are blank, or comments alone.

    block : from `padded`. number : [L], counted from 0 in the block. start, end : [L], end without the comment.
    head : [L, 8], first fields in upper case, without what follows a comma. noted : [L], has a comment.
    commas : [L + 1], of all lines before; comma : their places.
    """

    block: Bytes
    number: IntArray
    start: IntArray
    end: IntArray
    head: Bytes
    noted: BoolArray
    commas: IntArray
    comma: IntArray

    @cached_property
    def word(self) -> NDArray[np.uint64]:
        """First fields [L], each as one number."""
        return np.ascontiguousarray(self.head).view(np.uint64)[:, 0]

    @cached_property
    def is_free(self) -> BoolArray:
        """Whether a line [L] is in free fields."""
        return np.diff(self.commas) > 0

    @cached_property
    def continues(self) -> BoolArray:
        """Whether a line [L] goes on with the card of the line before."""
        blank = self.word == word(b"")
        return np.asarray(blank | (self.head[:, 0] == _PLUS) | (self.head[:, 0] == _STAR))

    @cached_property
    def is_odd(self) -> BoolArray:
        """Whether a line [L] has anything besides plain fields in one of the three forms, as a line by itself."""
        odd = self.noted | (self.end - self.start > _COLUMNS) | self._has(_EQUALS)
        starred = self._has(_STAR)
        count, free = np.diff(self.commas), self.is_free
        first = self.comma[np.minimum(self.commas[:-1], max(len(self.comma) - 1, 0))] if len(self.comma) else self.start
        blank = self.head == SPACE
        split = (blank[:, :-1] & ~blank[:, 1:]).any(axis=1)  # a name of two words, or behind blanks
        ninth = np.flatnonzero(count == _MOST_COMMAS)
        odd[ninth] |= self.end[ninth] - self.comma[self.commas[ninth] + _MOST_COMMAS - 1] > NAME + 1
        odd |= free & (starred | (count > _MOST_COMMAS) | (first > self.start + NAME) | split)
        return np.asarray(odd | (starred & ~free & ~(self.head == _STAR).any(axis=1)))

    def until(self, row: int) -> Lines:
        """The lines before a row."""
        return Lines(
            self.block,
            self.number[:row],
            self.start[:row],
            self.end[:row],
            self.head[:row],
            self.noted[:row],
            self.commas[: row + 1],
            self.comma,
        )

    def _has(self, character: int) -> BoolArray:
        found = np.zeros(len(self.start), dtype=bool)
        at = np.flatnonzero(self.block == character)
        if at.size and found.size:
            row = np.searchsorted(self.start, at, side="right") - 1
            inside = (row >= 0) & (at < self.end[row])  # not of comments and of other lines
            found[row[inside]] = True
        return found

    def tail(self, rows: IntArray) -> Bytes:
        """The tenth field [n, 8] of lines."""
        start, end = self.start[rows] + _TAIL, self.end[rows]
        free = self.is_free[rows]
        if free.any():
            count = np.diff(self.commas)[rows]
            ninth = free & (count == _MOST_COMMAS)
            start = np.where(free, end, start)
            start[ninth] = self.comma[self.commas[rows[ninth]] + _MOST_COMMAS - 1] + 1
        return window(self.block, np.minimum(start, end), end, NAME)


def lines_of(data: bytes, before: str, whole: bytes) -> Lines:
    """The lines of a block whose last line has its end.

    Parameters
    ----------
    data : with tabs expanded; `whole` : as it stands. before : the line above the block.

    Raises
    ------
    NotPlainError : a comment that was fields, a carriage return within a line.
    """
    block = padded(data)
    end = np.flatnonzero(block == ord("\n"))
    start = np.concatenate([[0], end[:-1] + 1]).astype(np.int64)
    code, noted = end.copy(), np.zeros(len(end), dtype=bool)
    dollars = np.flatnonzero(block == _DOLLAR)
    if dollars.size:
        row = np.searchsorted(end, dollars)
        noted[row] = True
        code[row[::-1]] = dollars[::-1]  # the first of a line is written last
        _refuse_lost_fields(whole, np.flatnonzero(noted), before)
    head = _UPPER[window(block, start, np.minimum(start + NAME, code), NAME)]
    comma = np.flatnonzero(block == _COMMA)
    if comma.size:
        cut = np.logical_or.accumulate(head == _COMMA, axis=1)
        head[cut] = SPACE
    blank = (head == SPACE).all(axis=1)
    said = ~blank
    rest = np.flatnonzero(blank & (code > start))
    for rows in np.array_split(rest, len(rest) // 65536 + 1):
        seen = np.minimum(code[rows], start[rows] + _COLUMNS)
        said[rows] = (window(block, start[rows], seen, _COLUMNS) != SPACE).any(axis=1)
        long = rows[code[rows] > seen]
        said[long] = [bool(data[start[r] : code[r]].strip(b" ")) for r in long.tolist()]
    kept = np.flatnonzero(said)
    inside = np.searchsorted(comma, code[kept])  # commas of comments are none
    first = np.searchsorted(comma, start[kept])
    counts = inside - first
    flat = np.repeat(first - np.concatenate([[0], np.cumsum(counts)[:-1]]), counts) + np.arange(counts.sum())
    return Lines(
        block,
        kept,
        start[kept],
        code[kept],
        head[kept],
        noted[kept],
        np.concatenate([[0], np.cumsum(counts)]),
        comma[flat.astype(np.int64)],
    )


def _refuse_lost_fields(whole: bytes, rows: IntArray, before: str) -> None:
    texts = whole.decode("latin-1").split("\n")
    for row in rows.tolist():
        if "$" in texts[row] and has_lost_fields(texts[row - 1] if row else before, texts[row]):
            raise NotPlainError


@dataclass(frozen=True)
class Cards:
    """C cards of some lines: first line [C] and number of lines [C], and whether each is in plain lines [C].

    is_free, is_large : [C], forms of the plain ones.
    """

    lines: Lines
    first: IntArray
    count: IntArray
    plain: BoolArray
    is_free: BoolArray
    is_large: BoolArray

    @property
    def word(self) -> NDArray[np.uint64]:
        """Names [C]."""
        return self.lines.word[self.first]


def cards_of(lines: Lines) -> Cards:
    """The cards of lines of which the first begins one."""
    begins = ~lines.continues
    first = np.flatnonzero(begins)
    count = np.diff(np.concatenate([first, [len(begins)]]))
    card = np.cumsum(begins) - 1
    free = lines.is_free
    large = (lines.head == _STAR).any(axis=1) & ~free
    odd = lines.is_odd | (free != free[first][card]) | (large != large[first][card])
    odd |= large & lines.continues & (lines.head[:, 0] != _STAR)
    before = np.flatnonzero(~begins) - 1
    if before.size:
        here, named = lines.tail(before), lines.head[before + 1]
        other = (here != named).any(axis=1)  # names in lower case are left to pyNastran
        for name in (here, named):
            other &= (name != SPACE).sum(axis=1) > 1
        odd[before] |= other
    plain = ~np.logical_or.reduceat(odd, first) if len(first) else np.zeros(0, dtype=bool)
    return Cards(lines, first, count, plain, free[first], large[first])
