"""Tables on parts of a model: how exactly they are known, or what was measured of them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from tedm_cli.errors import InputError
from tedm_cli.quantities import BUILT_MASS, BUILT_OFFSET, POSITION_DEVIATION, RELATIVE_DEVIATION
from tedm_cli.tables.csv_table import Row, read_table

Kind = Literal["property", "area", "grid", "block"]
_KINDS: tuple[Kind, ...] = ("property", "area", "grid", "block")
_FORMS = '"property 12", "property 11:19", "area NAME", "grid 4711" (the concentrated masses on it)'
_RANGE = re.compile(r"[1-9][0-9]{0,8}(:[1-9][0-9]{0,8})?")
TOLERANCES = {"part": None, "sigma_mass": RELATIVE_DEVIATION, "sigma_position_m": POSITION_DEVIATION}
MEASURED = {"part": None, "mass_kg": BUILT_MASS, "dx_m": BUILT_OFFSET, "dy_m": BUILT_OFFSET, "dz_m": BUILT_OFFSET}


@dataclass(frozen=True)
class PartName:
    """Elements of a property, those of a thermal area, the concentrated masses on a grid, or a compensation mass.

    name : of an area or block; low, high : ids of properties or grids. where : file and line.
    """

    kind: Kind
    name: str
    low: int
    high: int
    where: str

    @property
    def words(self) -> str:
        """As the table says it."""
        if self.kind in ("area", "block"):
            return f"{self.kind} {self.name}"
        return f"{self.kind} {self.low}" + (f":{self.high}" if self.high != self.low else "")


@dataclass(frozen=True)
class PartTolerance:
    """Standard deviations of a part: of its mass, relative; of its place along each axis of the basic frame, m."""

    part: PartName
    mass: float
    position_m: float


@dataclass(frozen=True)
class MeasuredPart:
    """A part as it was built: its mass (0: as it is modelled), kg, and how far it is from its place, m, basic frame."""

    part: PartName
    mass_kg: float
    offset_m: tuple[float, float, float]


def read_tolerances(path: Path) -> list[PartTolerance]:
    """A table `part,sigma_mass,sigma_position_m`; `InputError` names the line of what is wrong."""
    return [
        PartTolerance(part, row.number["sigma_mass"], row.number["sigma_position_m"])
        for part, row in _parts(path, read_table(path, TOLERANCES), blocks=False)
    ]


def read_measured(path: Path) -> list[MeasuredPart]:
    """A table `part,mass_kg,dx_m,dy_m,dz_m`; `InputError` names the line of what is wrong."""
    return [
        MeasuredPart(part, row.number["mass_kg"], (row.number["dx_m"], row.number["dy_m"], row.number["dz_m"]))
        for part, row in _parts(path, read_table(path, MEASURED), blocks=True)
    ]


def _parts(path: Path, rows: Sequence[Row], *, blocks: bool) -> list[tuple[PartName, Row]]:
    first: dict[str, int] = {}
    found = []
    for row in rows:
        part = _part(row.text["part"], f"{path}:{row.line}", blocks=blocks)
        if (line := first.setdefault(part.words, row.line)) != row.line:
            raise InputError(f"{part.words} is in line {line} already", where=part.where)
        found.append((part, row))
    return found


def _part(cell: str, where: str, *, blocks: bool) -> PartName:
    word, _, rest = cell.partition(" ")
    name = rest.strip()
    kind = next((k for k in _KINDS if k == word), None)
    hint = f"write {_FORMS}" + (', or "block NAME"' if blocks else "")
    if kind is None or not name or (kind == "block" and not blocks):
        raise InputError(f"part: {cell[:40]!r} names no part of the model", where=where, hint=hint)
    if kind in ("area", "block"):
        return PartName(kind, name, 0, 0, where)
    if not _RANGE.fullmatch(name):
        raise InputError(f"part: {name[:40]!r} is no id, and no range of ids", where=where, hint=hint)
    low, _, high = name.partition(":")
    if high and int(high) < int(low):
        raise InputError(f"part: '{name}' must be 'low:high'", where=where)
    return PartName(kind, "", int(low), int(high or low), where)
