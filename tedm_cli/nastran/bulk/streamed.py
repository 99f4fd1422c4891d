"""Files of a deck read in blocks: plain cards as columns, and the lines that are left, for pyNastran."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np

from tedm_cli.arrays import IntArray
from tedm_cli.nastran.bulk.lines import Lines, NotPlainError, cards_of, lines_of, word
from tedm_cli.nastran.bulk.numbers import SPACE
from tedm_cli.nastran.bulk.plain import PlainCards
from tedm_cli.nastran.deck_lines import Head

_BLOCK = 1 << 22  # bytes
_INCLUDE, _BEGIN, _END = b"INCLUDE", b"BEGIN", b"ENDDATA"


class StreamedDeck:
    """The plain cards of a deck, read file by file as pyNastran asks for their lines.

    plain : what has been read of it.
    """

    def __init__(self, path: Path, head: Head) -> None:
        """`NotPlainError`: the bulk data do not begin in the main file."""
        self.plain = PlainCards()
        self._main, self._begin = path.resolve(), head.begin.number
        self._head = {file.resolve() for file in head.files}
        self._numbers: list[list[int]] = []
        if head.begin.file.resolve() != self._main:
            raise NotPlainError

    def left(self, path: Path) -> list[str]:
        """The lines of the next file that are not plain cards.

        Raises
        ------
        NotPlainError : cards that depend on what stands around them, such as one that goes on in another file.
        """
        file = path.resolve()
        numbered: list[tuple[int, str]] = []
        with open(path, "rb") as stream:
            if file in self._head:
                numbered += _raw(stream, 0, self._begin if file == self._main else None)
            if file == self._main or file not in self._head:
                numbered += self._bulk(stream, len(numbered), is_main=file == self._main)
        self._numbers.append([number for number, _ in numbered])
        return [line for _, line in numbered]

    def number(self, file: int, line: int) -> int:
        """Number of a line, from 0 on, in its file, of the line with this number among those that were left of it."""
        return self._numbers[file][line]

    def _bulk(self, stream: BinaryIO, first: int, *, is_main: bool) -> Iterator[tuple[int, str]]:
        """Lines of bulk data that are not plain, with their numbers from `first` on."""
        carried, before, is_begun = b"", "", False
        while True:
            more = stream.read(_BLOCK)
            data = carried + more if more or carried.endswith(b"\n") else carried + b"\n"
            cut = data.rfind(b"\n") + 1
            part, carried = data[:cut].replace(b"\r\n", b"\n"), data[cut:]
            if not part:
                continue
            if b"\r" in part:
                raise NotPlainError
            lines = lines_of(part.expandtabs() if b"\t" in part else part, before, part)
            ends = np.concatenate([[-1], np.flatnonzero(np.frombuffer(part, dtype=np.uint8) == ord("\n"))])
            if len(lines.number) and not is_begun and lines.continues[0]:
                raise NotPlainError
            is_begun = is_begun or len(lines.number) > 0
            stop = _end_of_data(lines, is_main=is_main)
            cards = cards_of(lines.until(len(lines.number) if stop is None else stop))
            done = len(ends) - 1
            if stop is not None:
                done = int(lines.number[stop])
            elif more and len(cards.first):  # the last card may go on in the next block
                done = int(lines.number[cards.first[-1]])
                cards = cards_of(lines.until(int(cards.first[-1])))
            left = np.repeat(~self.plain.take(cards), cards.count)
            _refuse_torn_includes(cards.lines, cards.first[cards.count > 1], part, ends)
            for number in cards.lines.number[left].tolist():
                yield first + number, part[ends[number] + 1 : ends[number + 1] + 1].decode("latin-1")
            rest = part[ends[done] + 1 :]
            if stop is not None:
                after = (rest + carried + stream.read()).replace(b"\r\n", b"\n")
                yield from enumerate(_texts(after), start=first + done)
                return
            before = part[ends[done - 1] + 1 : ends[done]].decode("latin-1") if done else before
            carried, first = rest + carried, first + done
            if not more:
                return


def _raw(stream: BinaryIO, first: int, most: int | None) -> Iterator[tuple[int, str]]:
    """So many lines as they are, or all."""
    for number, raw in enumerate(stream, start=first):
        if b"\r" in raw.rstrip(b"\r\n"):
            raise NotPlainError
        yield number, raw.rstrip(b"\r\n").decode("latin-1") + "\n"
        if number + 1 == most:
            return


def _texts(data: bytes) -> list[str]:
    if b"\r" in data:
        raise NotPlainError
    return [f"{line}\n" for line in data.decode("latin-1").removesuffix("\n").split("\n")]


def _end_of_data(lines: Lines, *, is_main: bool) -> int | None:
    """The line of ENDDATA; `NotPlainError` where it or another line says that the bulk data are not in one piece."""
    head = lines.head
    indented = (head[:, 0] == SPACE) & ~lines.continues
    if indented.any() or _starts(lines, _BEGIN).size:
        raise NotPlainError
    ends = _starts(lines, _END)
    if not ends.size:
        return None
    if not is_main or int(lines.word[ends[0]]) != word(_END):
        raise NotPlainError
    return int(ends[0])


def _starts(lines: Lines, name: bytes) -> IntArray:
    """Rows of the lines that begin with a name."""
    return np.flatnonzero((lines.head[:, : len(name)] == np.frombuffer(name, dtype=np.uint8)).all(axis=1))


def _refuse_torn_includes(lines: Lines, several: IntArray, part: bytes, ends: IntArray) -> None:
    """`NotPlainError` where something goes on after INCLUDE, in the rows of cards of several lines: its name or a card.

    A name goes on until its closing quote; else it is the last card of the included file that goes on.
    """
    for row in np.intersect1d(_starts(lines, _INCLUDE), several).tolist():
        number = lines.number[row]
        if part[ends[number] + 1 : ends[number + 1]].split(b"$")[0].count(b"'") % 2 == 0:
            raise NotPlainError
