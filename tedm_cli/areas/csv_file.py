"""The CSV of thermal areas: one line node_id,area per grid."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from tedm_cli.area_names import area_name_fact
from tedm_cli.arrays import IntArray
from tedm_cli.errors import InputError
from tedm_cli.regular_file import require_regular_file

_GRID_ID = re.compile(r"[1-9][0-9]{0,8}")  # Nastran's ids have at most nine digits


def read_area_csv(path: Path) -> dict[str, IntArray]:
    """Grid ids of each thermal area from a CSV with the header `node_id,area`, areas in order of first appearance.

    Raises
    ------
    InputError : no such file, another header, a line that is not an id and a name, a grid named twice.
    """
    require_regular_file(path)
    try:
        with open(path, newline="", encoding="utf-8-sig") as stream:
            rows = list(csv.reader(stream))
    except OSError as exc:
        raise InputError(f"cannot be read ({exc.strerror})", where=str(path)) from exc
    except (UnicodeDecodeError, csv.Error) as exc:
        raise InputError(f"not a CSV in UTF-8 ({exc})", where=str(path)) from exc
    if not rows or [c.strip() for c in rows[0]] != ["node_id", "area"]:
        raise InputError("must begin with the header node_id,area", where=f"{path}:1")
    out: dict[str, list[int]] = {}
    first: dict[int, int] = {}
    spelled: dict[str, str] = {}
    for number, row in enumerate(rows[1:], start=2):
        if not "".join(row).strip():
            continue
        place = f"{path}:{number}"
        if len(row) != 2 or not _GRID_ID.fullmatch(row[0].strip()):
            raise InputError(f"wanted a grid id and an area name, found {','.join(row)[:60]!r}", where=place)
        grid, name = int(row[0]), row[1].strip()
        if fact := area_name_fact(name):
            raise InputError(fact, where=place)
        if grid in first:
            raise InputError(f"grid {grid} is in line {first[grid]} already", where=place)
        if spelled.setdefault(name.upper(), name) != name:
            # Nastran does not tell upper from lower case in labels.
            raise InputError(f"area {name!r} is also spelled {spelled[name.upper()]!r}", where=place)
        first[grid] = number
        out.setdefault(name, []).append(grid)
    if not out:
        raise InputError("names no thermal area", where=str(path))
    return {name: np.array(sorted(ids), dtype=np.int64) for name, ids in out.items()}


def area_csv_text(areas: Mapping[str, IntArray]) -> str:
    """Grid ids of each area as `read_area_csv` reads them, areas in their order."""
    rows = [f"{grid},{name}" for name, ids in areas.items() for grid in ids]
    return "\n".join(["node_id,area", *rows]) + "\n"
