"""Write displacements as a Nastran OP2 file (table OUGV1, real, SORT1, statics), one subcase after the other.

Records as PARAM,POST,-1 asks for them, 32-bit little-endian. Layout: DMAP Programmer's Guide, data block OUG.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from pathlib import Path
from typing import BinaryIO

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.files.store import replacing

# The file keeps 10 id + device code in 32 bits.
MAX_GRID_ID = 99_999_999
MAX_LABEL = 128
_ROW_WORDS = 8  # 10 id + device code, grid type, three translations, three rotations
_HEADER_WORDS = 146
# A record gives its length in bytes in 32 bits.
MAX_GRIDS = (2**31 - 1) // (4 * _ROW_WORDS)
_PLOT = 2  # device code
_GRID = 1  # grid type
_STATICS, _DISPLACEMENTS, _REAL = 1, 1, 1
# A constant date: the same displacements give the same bytes.
_MONTH, _DAY, _YEAR = 1, 2, 0


def write_op2(path: Path, grid_ids: IntArray, cases: Iterable[tuple[int, str, FloatArray]]) -> None:
    """Write the displacements of static subcases; single precision, as Nastran does.

    The file is complete or absent: it is written beside the target under a temporary name, flushed to disk and renamed.

    Parameters
    ----------
    path : target, replaced if it exists.
    grid_ids : [N], 1 to 99,999,999.
    cases : subcase id, label (ASCII, at most 128 characters) and motion [N, 6] in m and rad, each subcase once.
        Consumed and written one by one; 32 bytes per grid are held, whatever their number.

    Raises
    ------
    InputError
        For ids, labels or numbers that the format cannot hold, and repeated subcase ids.
    """
    if len(grid_ids) == 0 or grid_ids.min() < 1 or grid_ids.max() > MAX_GRID_ID:
        raise InputError(f"grid ids must lie between 1 and {MAX_GRID_ID:,}", where=str(path))
    if len(grid_ids) > MAX_GRIDS:
        raise InputError(f"{len(grid_ids):,} grids; an OP2 holds {MAX_GRIDS:,} in a subcase", where=str(path))
    rows = np.empty((len(grid_ids), _ROW_WORDS), dtype="<i4")
    rows[:, 0], rows[:, 1] = 10 * grid_ids + _PLOT, _GRID
    motions = rows.view("<f4")[:, 2:]
    written = set[int]()
    with replacing(path) as temporary, open(temporary, "wb") as stream:
        _write_start(stream)
        subtable = -3
        for subcase, label, motion in cases:
            _check(path, subcase, label, written)
            with np.errstate(over="ignore"):  # what overflows is no longer finite
                motions[...] = motion
            if not np.isfinite(motions).all():
                raise InputError("displacements are not finite in single precision", where=f"{path}: subcase {subcase}")
            _write_markers(stream, subtable, 1, 0, _HEADER_WORDS)
            _write_record(stream, _header(subcase, label))
            _write_markers(stream, subtable - 1, 1, 0, rows.size)
            _write_record(stream, rows.data)
            written.add(subcase)
            subtable -= 2
        if not written:
            raise InputError("no subcase to write", where=str(path))
        _write_markers(stream, subtable, 1, 0, 0, 0)


def _check(path: Path, subcase: int, label: str, written: set[int]) -> None:
    where = f"{path}: subcase {subcase}"
    if subcase in written:
        raise InputError("the subcase id is used twice", where=where)
    if not label.isascii() or len(label) > MAX_LABEL:
        raise InputError(f"the label {label!r} is not plain ASCII of at most {MAX_LABEL} characters", where=where)


def _write_start(stream: BinaryIO) -> None:
    """What every file begins with, and the table's name and date."""
    _write_markers(stream, 3)
    _write_record(stream, struct.pack("<3i", _MONTH, _DAY, _YEAR))
    _write_markers(stream, 7)
    _write_record(stream, b"NASTRAN FORT TAPE ID CODE - ")
    _write_markers(stream, 2)
    _write_record(stream, b"XXXXXXXX")
    _write_markers(stream, -1, 0, 2)
    _write_record(stream, b"OUGV1   ")
    _write_markers(stream, -1, 7)
    _write_record(stream, struct.pack("<7i", 102, 0, 0, 0, 512, 0, 0))
    _write_markers(stream, -2, 1, 0, 7)
    _write_record(stream, struct.pack("<8s5i", b"OUG1    ", _MONTH, _DAY, _YEAR, 0, 1))


def _header(subcase: int, label: str) -> bytes:
    """The header record of a subcase: 50 words, then title, subtitle and label."""
    words = [0] * 50
    words[:5] = [10 * _STATICS + _PLOT, _DISPLACEMENTS, 0, subcase, subcase]  # word 5: number of the load set
    words[8:10] = [_REAL, _ROW_WORDS]
    return struct.pack("<50i128s128s128s", *words, b" " * 128, b" " * 128, label.encode("ascii").ljust(MAX_LABEL))


def _write_markers(stream: BinaryIO, *numbers: int) -> None:
    for number in numbers:
        stream.write(struct.pack("<3i", 4, number, 4))


def _write_record(stream: BinaryIO, data: bytes | memoryview) -> None:
    view = memoryview(data)
    length = struct.pack("<i", view.nbytes)
    stream.write(length)
    stream.write(view)
    stream.write(length)
