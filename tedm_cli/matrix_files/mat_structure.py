"""Whether a MAT file is what its headers say, found out before anything is allocated by them.

Headers of damaged and of malicious files name sizes that the file does not have: SciPy allocates by them, follows types
outside its tables and nesting without end. Here the elements are walked, compressed ones are inflated up to a bound,
and what is left is plain and consistent. Format: MathWorks, *MAT-File Format*, chapters 1 (level 5) and 2 (level 4).
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass

#: Of the file once inflated, as for NPZ.
MOST_BYTES = 2**28
_HEADER = 128
_DEEPEST = 16
_MATRIX, _COMPRESSED = 14, 15
_SIZE = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8, 16: 1, 17: 2, 18: 4}  # of data types, bytes
_CELL, _STRUCT, _OBJECT, _CHAR, _SPARSE = 1, 2, 3, 4, 5
_NUMERIC = range(6, 16)
_COMPLEX = 1 << 11
_LEVEL_4_SIZE = {0: 8, 1: 4, 2: 4, 3: 2, 4: 2, 5: 1}


class MatError(Exception):
    """What is wrong with the file."""


@dataclass(frozen=True)
class _Element:
    """Type and contents of an element of the order of bytes `order`, and where the next one begins."""

    kind: int
    data: memoryview
    end: int


def plain_mat(raw: bytes) -> bytes:
    """A MAT file of level 4 or 5 without compression, checked; raises `MatError`."""
    if len(raw) < 20:
        raise MatError("is too short for a MAT file")
    if 0 in raw[:4]:  # level 5 begins with text
        _check_level_4(raw)
        return raw
    order = {b"IM": "<", b"MI": ">"}.get(raw[126:128])
    if order is None:
        raise MatError("is no MAT file of level 4 or 5")
    out, at, room = [raw[:_HEADER]], _HEADER, MOST_BYTES
    view = memoryview(raw)
    while at < len(raw):
        element = _element(view, at, order)
        whole = bytes(view[at : element.end])
        if element.kind == _COMPRESSED:
            whole = _inflated(element.data, room)
            element = _element(memoryview(whole), 0, order)
            if element.end != len(whole):
                raise MatError("has a compressed element with something behind it")
        if element.kind != _MATRIX:
            raise MatError(f"has an element of type {element.kind} in place of a matrix")
        _check_matrix(element.data, order, 0)
        room -= len(whole)
        if room < 0:
            raise MatError(f"holds more than {MOST_BYTES:,} bytes")
        out.append(whole)
        at = element.end if view[at : at + 4] != struct.pack(f"{order}I", _COMPRESSED) else _next(view, at, order)
    return b"".join(out)


def _next(view: memoryview, at: int, order: str) -> int:
    """Where the element behind a compressed one begins: these are not padded."""
    return at + 8 + int(struct.unpack_from(f"{order}I", view, at + 4)[0])


def _inflated(data: memoryview, room: int) -> bytes:
    inflater = zlib.decompressobj()
    try:
        out = inflater.decompress(data, room + 1)
    except zlib.error as exc:
        raise MatError(f"has a compressed element that is damaged ({exc})") from exc
    if len(out) > room:
        raise MatError(f"inflates to more than {MOST_BYTES:,} bytes")
    if not inflater.eof:
        raise MatError("has a compressed element that is cut off")
    return out


def _element(view: memoryview, at: int, order: str) -> _Element:
    if len(view) - at < 8:
        raise MatError(f"ends inside the header of an element at byte {at:,}")
    kind, size = struct.unpack_from(f"{order}II", view, at)
    if kind >> 16:  # a small element: its size and up to four bytes of data in place of the size
        size, kind = kind >> 16, kind & 0xFFFF
        if size > 4:
            raise MatError(f"has a small element of {size} bytes at byte {at:,}")
        return _Element(kind, view[at + 4 : at + 4 + size], at + 8)
    if at + 8 + size > len(view):
        raise MatError(f"has an element of {size:,} bytes at byte {at:,}, where {len(view) - at - 8:,} are left")
    padded = size if kind == _COMPRESSED else size + -size % 8
    return _Element(kind, view[at + 8 : at + 8 + size], min(at + 8 + padded, len(view)))


def _check_matrix(data: memoryview, order: str, depth: int) -> None:
    """Check the contents of a matrix element; `MatError` for what its headers say and it does not have."""
    if depth > _DEEPEST:
        raise MatError(f"is nested more than {_DEEPEST} deep")
    if not len(data):
        return  # an empty matrix
    parts = _parts(data, order)
    flags = _take(parts, "array flags")
    if flags.kind != 6 or len(flags.data) != 8:
        raise MatError("has a matrix without flags")
    (word,) = struct.unpack_from(f"{order}I", flags.data)
    kind, is_complex = word & 0xFF, bool(word & _COMPLEX)
    if kind not in (_CELL, _STRUCT, _OBJECT, _CHAR, _SPARSE, *_NUMERIC):
        raise MatError(f"has a matrix of class {kind}, which is not read")
    sizes = _take(parts, "dimensions")
    if sizes.kind != 5 or len(sizes.data) % 4 or not 8 <= len(sizes.data) <= 128:
        raise MatError("has a matrix without dimensions")
    shape = struct.unpack(f"{order}{len(sizes.data) // 4}i", sizes.data)
    if min(shape) < 0:
        raise MatError(f"has a matrix of shape {shape}")
    if _take(parts, "a name").kind != 1:
        raise MatError("has a matrix without a name")
    count = math.prod(shape)
    if kind in (_CELL, _STRUCT, _OBJECT):
        _check_nested(parts, kind, count, shape, order, depth)
    elif kind == _SPARSE:
        if count * 8 > MOST_BYTES:
            raise MatError(f"has a sparse matrix of shape {shape}; in full it would have {count * 8:,} bytes")
        for _ in range(3 + is_complex):
            _data(parts)
    else:
        for _ in range(1 + is_complex):
            found = _data(parts)
            # Numbers may be stored in a smaller type than their class; of text in UTF-8 a letter may take four bytes.
            held = len(found.data) // _SIZE[found.kind]
            if held != count and not (kind == _CHAR and found.kind == 16 and count <= held <= 4 * count):
                raise MatError(f"has a matrix of shape {shape} with {held:,} entries")


def _check_nested(
    parts: Iterator[_Element], kind: int, count: int, shape: tuple[int, ...], order: str, depth: int
) -> None:
    """The matrices inside a cell array or a structure: as many as its shape and its fields say."""
    fields = 1
    if kind != _CELL:
        if kind == _OBJECT:
            _take(parts, "the name of a class")
        width = _take(parts, "the length of field names")
        if width.kind != 5 or len(width.data) != 4:
            raise MatError("has a structure without the length of its field names")
        (length,) = struct.unpack(f"{order}i", width.data)
        names = _take(parts, "field names")
        if length <= 0 or len(names.data) % length:
            raise MatError(f"has a structure with field names of {length} letters in {len(names.data)} bytes")
        fields = len(names.data) // length
    inside = list(parts)
    if len(inside) != count * fields:
        raise MatError(f"has a cell array or structure of shape {shape} with {len(inside):,} entries")
    for element in inside:
        if element.kind != _MATRIX:
            raise MatError(f"has an element of type {element.kind} inside a cell array or structure")
        _check_matrix(element.data, order, depth + 1)


def _parts(data: memoryview, order: str) -> Iterator[_Element]:
    at = 0
    while at < len(data):
        element = _element(data, at, order)
        yield element
        at = element.end


def _take(parts: Iterator[_Element], what: str) -> _Element:
    found = next(parts, None)
    if found is None:
        raise MatError(f"has a matrix without {what}")
    return found


def _data(parts: Iterator[_Element]) -> _Element:
    found = _take(parts, "its data")
    if found.kind not in _SIZE:
        raise MatError(f"has numbers of type {found.kind}")
    return found


def _check_level_4(raw: bytes) -> None:
    at = 0
    order = "<" if struct.unpack_from("<i", raw)[0] in range(5000) else ">"
    while at < len(raw):
        if len(raw) - at < 20:
            raise MatError(f"ends inside the header of a matrix at byte {at:,}")
        mopt, rows, columns, is_complex, letters = struct.unpack_from(f"{order}5i", raw, at)
        size = _LEVEL_4_SIZE.get(mopt // 10 % 10)
        if mopt not in range(5000) or size is None or mopt % 10 > 2 or is_complex not in (0, 1):
            raise MatError("is no MAT file of level 4 or 5")
        if min(rows, columns, letters) < 0:
            raise MatError(f"has a matrix of shape ({rows}, {columns})")
        wanted = 20 + letters + rows * columns * size * (1 + is_complex)
        if wanted > len(raw) - at:
            raise MatError(f"has a matrix of {wanted:,} bytes at byte {at:,}, where {len(raw) - at:,} are left")
        at += wanted
