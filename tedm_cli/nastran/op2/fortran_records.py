"""The records of a Fortran file: each has its length before and behind it, which is the one redundancy an OP2 has."""

from __future__ import annotations

import mmap
import struct
from pathlib import Path

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
    with open(path, "rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
        order = _ORDERS.get(data[:4])
        if order is None:
            raise InputError(
                "neither an OP2 nor HDF5 (it begins as neither does)",
                where=str(path),
                hint="PARAM,POST,-1 in the deck makes Nastran write an OP2",
            )
        problem = _walk(data, struct.Struct(f"{order}i"))
    if problem:
        raise InputError(
            f"truncated or damaged: {problem}",
            where=str(path),
            hint="is the file complete, and was it copied as binary? did the solver end without a FATAL message?",
        )


def _walk(data: mmap.mmap, count: struct.Struct) -> str:
    """What is wrong with the first record that is not whole."""
    at, end = 0, len(data)
    while at < end:
        if at + 8 > end:
            return f"it ends within the record at byte {at:,}"
        (size,) = count.unpack_from(data, at)
        last = at + 4 + size
        if size < 0:
            return f"the record at byte {at:,} has a length of {size:,} bytes"
        if last + 4 > end:
            return f"the record at byte {at:,} is {size:,} bytes long, the file has {end:,}"
        (again,) = count.unpack_from(data, last)
        if again != size:
            return f"the record at byte {at:,} begins with a length of {size:,} bytes and ends with {again:,}"
        at = last + 4
    return ""
