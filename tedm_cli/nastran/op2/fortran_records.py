"""The records of a Fortran file: each has its length before and behind it, which is the one redundancy an OP2 has."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from tedm_cli.errors import InputError
from tedm_cli.regular_file import require_regular_file

# The first record of an OP2 has 4 or 8 bytes (32 or 64 bit), in either byte order.
_ORDERS = {struct.pack(f"{order}i", size): order for order in "<>" for size in (4, 8)}


def require_records(path: Path) -> None:
    """Walk an OP2 from record to record: to its end, and no further.

    Raises
    ------
    InputError : missing, empty, not an OP2, cut off, a record whose lengths differ or are impossible.
    """
    require_regular_file(path)
    if not path.is_file():
        hint = "run `tedm solve`, or Nastran on the unit-load deck"
        if path.suffix.lower() == ".h5":  # the embedded solver writes OP2
            hint = 'let MSC Nastran write it, as `tedm solve --run "nastran {deck}"` does, or copy its results there'
        raise InputError("no such result file", where=str(path), hint=hint)
    if not path.stat().st_size:
        raise InputError("empty file, neither OP2 nor HDF5", where=str(path))
    with open(path, "rb") as stream:  # not mapped: pages that are touched would count as memory
        order = _ORDERS.get(stream.read(4))
        if order is None:
            raise InputError(
                "neither an OP2 nor HDF5 (it begins as neither does)",
                where=str(path),
                hint="PARAM,POST,-1 in the deck makes Nastran write an OP2",
            )
        problem = _walk(stream, os.fstat(stream.fileno()).st_size, struct.Struct(f"{order}i"))
    if problem:
        raise InputError(
            f"truncated or damaged: {problem}",
            where=str(path),
            hint="is the file complete, and was it copied as binary? did the solver end without a FATAL message?",
        )


def _walk(stream: BinaryIO, end: int, count: struct.Struct) -> str:
    """What is wrong with the first record that is not whole."""
    at = 0
    stream.seek(0)
    while at < end:
        if at + 8 > end:
            return f"it ends within the record at byte {at:,}"
        (size,) = count.unpack(stream.read(4))
        last = at + 4 + size
        if size < 0:
            return f"the record at byte {at:,} has a length of {size:,} bytes"
        if last + 4 > end:
            return f"the record at byte {at:,} is {size:,} bytes long, the file has {end:,}"
        stream.seek(size, os.SEEK_CUR)  # within what is buffered nothing is read anew
        (again,) = count.unpack(stream.read(4))
        if again != size:
            return f"the record at byte {at:,} begins with a length of {size:,} bytes and ends with {again:,}"
        at = last + 4
    return ""


class BlockReader:
    """Reads what an OP2 keeps in one piece and writes in blocks, each behind a record with its length in words.

    The last block is followed by a record with a number that is not positive. What is read stands in one buffer, which
    the next read overwrites: memory grows with the largest piece alone.

    Parameters
    ----------
    stream : the file; `require_records` has found its records whole.
    order, word : byte order ("<" or ">"), and bytes of a word (4 or 8).
    """

    def __init__(self, stream: BinaryIO, order: str, word: int) -> None:
        self._stream = stream
        self._length, self._marker = struct.Struct(f"{order}i"), struct.Struct(f"{order}{'i' if word == 4 else 'q'}")
        self._buffer = bytearray(0)

    def read(self, *places: int) -> memoryview:
        """All blocks of the pieces that begin at the bytes `places`, joined.

        Raises
        ------
        ValueError : a record that is no such block.
        """
        lengths = [block for place in places for block in self._blocks(place)]
        if len(self._buffer) < sum(size for _, size in lengths):
            self._buffer = bytearray(sum(size for _, size in lengths))
        view, filled = memoryview(self._buffer), 0
        for at, size in lengths:
            self._stream.seek(at)
            if self._stream.readinto(view[filled : filled + size]) != size:  # type: ignore[attr-defined]
                raise ValueError(f"the block at byte {at:,} ends early")
            filled += size
        return view[:filled]

    def _blocks(self, place: int) -> Iterator[tuple[int, int]]:
        """Where each block begins, and its bytes."""
        at = place
        while (words := self._marked(at)) > 0:
            at += 8 + self._marker.size
            self._stream.seek(at)
            (size,) = self._length.unpack(self._stream.read(4))
            if size != words * self._marker.size:
                raise ValueError(f"the block at byte {at:,} has {size:,} bytes, its marker says {words:,} words")
            yield at + 4, size
            at += 8 + size

    def _marked(self, at: int) -> int:
        self._stream.seek(at)
        (size,) = self._length.unpack(self._stream.read(4))
        if size != self._marker.size:
            raise ValueError(f"no marker at byte {at:,}")
        return int(self._marker.unpack(self._stream.read(size))[0])
