"""The compensation masses of a configuration, from its CSV and its tables."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import scipy

from tedm_cli.config.base import ID_RANGE
from tedm_cli.config.model.file import ModelConfig, axes_of_rotation
from tedm_cli.config.project import Project
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.gravity.compensation import CompensationMass, Tie
from tedm_cli.quantities import ANGLE, COORDINATE, LENGTH, MASS
from tedm_cli.tables.csv_table import Row, csv_line, read_table

CENTRE, SIZE = ("x_m", "y_m", "z_m"), ("size_x_m", "size_y_m", "size_z_m")
ROTATION = ("rotation_x_rad", "rotation_y_rad", "rotation_z_rad")
COLUMNS = {
    "name": None,
    **dict.fromkeys(CENTRE, COORDINATE),
    **dict.fromkeys(SIZE, LENGTH),
    **dict.fromkeys(ROTATION, ANGLE),
    "mass_kg": MASS,
}
TIE, GROUP = "grid", "group"
_RANGE = re.compile(ID_RANGE.strip("^$") + "|[1-9][0-9]{0,8}")


def compensation_file(project: Project, config: ModelConfig) -> Path | None:
    """The CSV of blocks that the model configuration names, if it names one."""
    name = config.gravity.compensation_masses
    return None if name is None else project.resolve(name)


def compensation_masses(project: Project, config: ModelConfig) -> list[CompensationMass]:
    """All blocks, those of the CSV first.

    Raises
    ------
    InputError : the CSV or a line of it is wrong, or two of its lines name the same block.
    ConfigError : a table names a block that is there already; a block is of a group that no area has.
    """
    path, tables = compensation_file(project, config), config.compensation_mass
    blocks = [] if path is None else _listed(path)
    blocks += [_placed(table.block(), str(project.model), f"compensation_mass[{i}]") for i, table in enumerate(tables)]
    names = [block.name for block in blocks]
    problems = [
        ("compensation_mass", f"two blocks have the name {name!r}")
        for name in sorted({n for n in names if names.count(n) > 1})
    ]
    groups = sorted({rule.group for rule in config.areas.rule})
    problems += [
        ("compensation_mass", f"block {block.name!r}: no rule of [areas] has the group {block.group!r};"
         f" there are: {', '.join(groups) or 'none'}")
        for block in blocks
        if block.group and block.group not in groups
    ]  # fmt: skip
    if problems:
        raise ConfigError(problems, where=str(project.model))
    return blocks


def csv_text(blocks: Sequence[CompensationMass]) -> str:
    """Blocks as a CSV that `compensation_masses` of the model may name: read again, they are the same to the last digit
    but for their axes, which are rounded."""
    more = [TIE] * any(b.tie is not None for b in blocks) + [GROUP] * any(b.group for b in blocks)
    lines = [csv_line([*COLUMNS, *more])]
    for b in blocks:
        turn = scipy.spatial.transform.Rotation.from_matrix(b.axes.T).as_rotvec()
        numbers = [repr(float(v) + 0.0) for v in (*b.centre_m, *b.size_m, *turn, b.mass_kg)]
        last = {TIE: "" if b.tie is None else _tie_cell(b.tie), GROUP: b.group}
        lines.append(csv_line([b.name, *numbers, *(last[name] for name in more)]))
    return "".join(lines)


def _tie_cell(tie: Tie) -> str:
    ids = " ".join(f"{low}" if low == high else f"{low}:{high}" for low, high in tie.ids)
    return f"set {ids}" if tie.kind == "set" else ids


def _listed(path: Path) -> list[CompensationMass]:
    """The blocks of a CSV."""
    rows = read_table(path, COLUMNS, [TIE, GROUP])
    first: dict[str, int] = {}
    for row in rows:
        name = row.text["name"]
        if (line := first.setdefault(name, row.line)) != row.line:
            raise InputError(f"the block {name!r} is in line {line} already", where=f"{path}:{row.line}")
    return [_placed(_block(row, f"{path}:{row.line}"), str(path), f"line {row.line}") for row in rows]


def _placed(block: CompensationMass, file: str, table: str) -> CompensationMass:
    """With the place where its tie stands."""
    if block.tie is None:
        return block
    key = f"{table}, {TIE}" if table.startswith("line") else f"{table}.{block.tie.kind}"
    return replace(block, tie=replace(block.tie, file=file, key=key))


def _block(row: Row, where: str) -> CompensationMass:
    return CompensationMass(
        name=row.text["name"],
        centre_m=np.array([row.number[c] for c in CENTRE]),
        size_m=np.array([row.number[c] for c in SIZE]),
        mass_kg=row.number["mass_kg"],
        axes=axes_of_rotation([row.number[c] for c in ROTATION]),
        tie=_tie(row.text.get(TIE, ""), where),
        group=row.text.get(GROUP, ""),
    )


def _tie(cell: str, where: str) -> Tie | None:
    """`4711`, `4711 4800:4810` or `set 12`, as a column of the CSV has them; nothing of a block that stays still."""
    if not cell:
        return None
    first, *rest = words = cell.split()
    is_set = first.lower() == "set"
    ids = rest if is_set else words
    if not ids or not all(_RANGE.fullmatch(word) for word in ids):
        raise InputError(
            f"{TIE}: {cell[:40]!r} names no grids",
            where=where,
            hint="write 4711, or 4711 4800:4810, or set 12; leave it empty where the block stays still",
        )
    ranges = [(int(low), int(high or low)) for low, _, high in (word.partition(":") for word in ids)]
    for low, high in ranges:
        if low > high:
            raise InputError(f"{TIE}: '{low}:{high}' must be 'low:high'", where=where)
    return Tie("set" if is_set else "grid", tuple(ranges))
