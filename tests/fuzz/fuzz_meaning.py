"""What a text of a user says, read by the standard library alone, and the same said again in plain writing.

A damaged file that a command takes must be read as what it now says: its plain writing makes the same numbers.
"""

from __future__ import annotations

import csv
import datetime
import io
import json
import re
import tomllib
from pathlib import Path
from typing import Any

#: What `tedm` itself writes behind an apostrophe, so that no spreadsheet takes it for a formula.
_APOSTROPHE = re.compile("'+[=+\\-@\t\r\n\uff0b\uff0d\uff1d\uff20]")


def meaning(name: str, data: bytes) -> object:
    """What the file says: the tables of a TOML, the cells of a CSV, the corners of an STL.

    ValueError or csv.Error where it says nothing.

    Floats are held by their digits: two files say the same when these are equal, NaN or not.
    """
    if Path(name).suffix == ".toml":
        return json.dumps(_plain(tomllib.loads(data.decode("utf-8"))))
    if Path(name).suffix == ".stl":
        return _corners(data)
    text = io.StringIO(data.decode("utf-8-sig"), newline="")
    rows = [[_cell(cell) for cell in row] for row in csv.reader(text, strict=True)]
    return [row for row in rows if any(row)]


def written(name: str, data: bytes) -> bytes:
    """The same in plain writing: no comments, no blanks, numbers as Python writes them."""
    if Path(name).suffix == ".toml":
        return _toml(tomllib.loads(data.decode("utf-8"))).encode("utf-8")
    rows = meaning(name, data)
    assert isinstance(rows, list)
    if Path(name).suffix == ".stl":
        lines = ["solid plain"]
        for n in range(0, len(rows), 3):
            lines += ["facet normal 0 0 0", "outer loop", *(f"vertex {x} {y} {z}" for x, y, z in rows[n : n + 3])]
            lines += ["endloop", "endfacet"]
        return "\n".join([*lines, "endsolid plain", ""]).encode("utf-8")
    out = io.StringIO(newline="")
    csv.writer(out, lineterminator="\n").writerows([[_apostrophe(cell) for cell in row] for row in rows])
    return out.getvalue().encode("utf-8")


def _corners(data: bytes) -> list[tuple[str, ...]]:
    """The corners of the triangles of an ASCII STL file, word by word."""
    words = data.decode("utf-8").split()
    at = [n for n, word in enumerate(words) if word.lower() == "vertex"]
    return [tuple(repr(float(word)) for word in words[n + 1 : n + 4]) for n in at]


def _plain(value: Any) -> Any:
    """With floats and dates as text, which JSON keeps; a float is none of the integers."""
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, list):
        return [_plain(v) for v in value]
    return value if isinstance(value, (bool, int, str)) else f"{type(value).__name__} {value!r}"


def _toml(table: dict[str, Any]) -> str:
    """A line for each key of the root, with everything below it inline."""
    return "".join(f"{_string(key)} = {_value(value)}\n" for key, value in table.items())


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_string(k)} = {_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, (datetime.date, datetime.time)):
        return value.isoformat()
    return repr(value)


def _string(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _cell(field: str) -> str:
    field = field.strip()
    field = field[1:] if _APOSTROPHE.match(field) else field
    if re.fullmatch(r"[+-]?[0-9]+", field):
        return str(int(field)) if len(field) < 300 else field
    try:
        return repr(float(field)) if "_" not in field else field
    except ValueError:
        return field


def _apostrophe(cell: str) -> str:
    """Text that begins as `tedm` would take off an apostrophe for."""
    return "'" + cell if cell.startswith("'") and _APOSTROPHE.match("'" + cell) else cell
