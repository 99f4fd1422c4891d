"""Thermal areas: their definition in a CSV, and their attributes by name pattern."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tedm_cli.config.model import AreasTable
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.noise.areas import AreaTable

_GRID_ID = re.compile(r"[1-9][0-9]{0,8}")  # Nastran's ids have at most nine digits
_AREA_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_.-]{0,55}")


def read_area_csv(path: Path) -> dict[str, NDArray[np.int64]]:
    """Grid ids of each thermal area from a CSV with the header `node_id,area`, areas in order of first appearance.

    Raises
    ------
    InputError : no such file, another header, a line that is not an id and a name, a grid named twice.
    """
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
        if len(row) != 2 or not _GRID_ID.fullmatch(row[0].strip()) or not _AREA_NAME.fullmatch(row[1].strip()):
            raise InputError(
                "wanted a grid id and an area name of letters, digits, _ . - that begins with a letter,"
                f" found {','.join(row)[:60]!r}",
                where=place,
            )
        grid, name = int(row[0]), row[1].strip()
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


def area_attributes(
    names: Sequence[str], centroids_m: NDArray[np.float64], table: AreasTable, *, where: str
) -> AreaTable:
    """Group, shield and side of each area from the first rule whose pattern matches its name.

    The side comes from the centroid [k,3] (basic frame) where the rule does not give it.

    Raises
    ------
    ConfigError : areas that no rule matches, and rules that match no area.
    """
    problems = []
    used = set()
    group, shield, side = [], [], []
    for name, centroid in zip(names, centroids_m, strict=True):
        number = next((i for i, r in enumerate(table.rule) if fnmatchcase(name, r.match)), None)
        if number is None:
            problems.append(("areas.rule", f"no rule matches the thermal area '{name}'"))
            continue
        rule = table.rule[number]
        used.add(number)
        group.append(rule.group)
        shield.append(rule.shield)
        y = float(centroid[1])
        side.append(rule.side or ("mid" if abs(y) < table.mid_half_width_m else "+y" if y > 0 else "-y"))
    for number, rule in enumerate(table.rule):
        if number not in used:
            taken = any(fnmatchcase(name, rule.match) for name in names)
            fact = "matches no thermal area" + (" that an earlier rule has left over" if taken else "")
            problems.append((f"areas.rule[{number}].match", f"'{rule.match}' {fact}"))
    if problems:
        shown = ", ".join(names[:8]) + (f" and {len(names) - 8} more" if len(names) > 8 else "")
        raise ConfigError(problems, where=where, hint=f"the model's areas: {shown}")
    return AreaTable(name=np.array(names), group=np.array(group), shield=np.array(shield), side=np.array(side))
