"""Triangles of an STL file, binary or ASCII."""

from __future__ import annotations

import re

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import PhysicsError

_HEADER, _RECORD = 84, 50
_VERTEX = re.compile(rb"^\s*vertex\s+(\S+)\s+(\S+)\s+(\S+)\s*$", re.IGNORECASE | re.MULTILINE)


def stl_triangles(content: bytes) -> FloatArray:
    """Triangles [t, 3, 3] in the file's own unit; the normals that it states are not looked at.

    Raises
    ------
    PhysicsError : it is no STL file, or cut off; says where.
    """
    if len(content) >= _HEADER:
        count = int.from_bytes(content[80:84], "little")
        if len(content) == _HEADER + _RECORD * count:
            return _binary(content, count)
    if content.lstrip()[:5].lower() == b"solid" and b"vertex" in content[:100_000].lower():
        return _ascii(content)
    if len(content) >= _HEADER and content[:5].lower() != b"solid":
        raise PhysicsError(
            f"says that it has {count:,} triangles, {_HEADER + _RECORD * count:,} bytes, but has {len(content):,}",
            hint="a binary STL file is cut off, or this is another kind of file",
        )
    raise PhysicsError(
        "is no STL file: neither binary nor ASCII, which starts with 'solid' and has lines 'vertex x y z'"
    )


def _binary(content: bytes, count: int) -> FloatArray:
    record = np.dtype([("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("attribute", "<u2")])
    return np.frombuffer(content, record, count, _HEADER)["corner"].astype(np.float64)


def _ascii(content: bytes) -> FloatArray:
    try:
        content.decode("utf-8")
    except UnicodeDecodeError as error:
        place = content[: error.start].count(b"\n") + 1
        raise PhysicsError(f"line {place} is no text: it is not UTF-8", hint="the file is damaged") from error
    facets = len(re.findall(rb"^\s*endfacet\b", content, re.IGNORECASE | re.MULTILINE))
    lines = len(re.findall(rb"^\s*vertex\b", content, re.IGNORECASE | re.MULTILINE))
    found = _VERTEX.findall(content)
    if len(found) != lines:
        for number, line in enumerate(content.split(b"\n"), 1):
            if re.match(rb"\s*vertex\b", line, re.IGNORECASE) and not _VERTEX.match(line):
                raise PhysicsError(
                    f"line {number}: {line.decode(errors='replace').strip()!r} has not three coordinates"
                )
    if lines != 3 * facets or not re.search(rb"^\s*endsolid\b", content, re.IGNORECASE | re.MULTILINE):
        raise PhysicsError(
            f"has {facets} facets that end and {lines} vertices, and should have three each and end with 'endsolid'",
            hint="the file is cut off",
        )
    try:
        values = np.array(found, dtype=object).astype(bytes).astype(np.float64)
    except ValueError as error:
        raise PhysicsError(f"a coordinate is no number: {error}") from error
    return np.asarray(values.reshape(-1, 3, 3))
