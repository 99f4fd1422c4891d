"""The compensation masses of a configuration, from its CSV and its tables."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tedm_cli.config.model import ModelConfig, axes_of_rotation
from tedm_cli.config.project import Project
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.gravity.compensation import CompensationMass
from tedm_cli.quantities import ANGLE, COORDINATE, LENGTH, MASS
from tedm_cli.tables.csv_table import Row, read_table

CENTRE, SIZE = ("x_m", "y_m", "z_m"), ("size_x_m", "size_y_m", "size_z_m")
ROTATION = ("rotation_x_rad", "rotation_y_rad", "rotation_z_rad")
COLUMNS = {
    "name": None,
    **dict.fromkeys(CENTRE, COORDINATE),
    **dict.fromkeys(SIZE, LENGTH),
    **dict.fromkeys(ROTATION, ANGLE),
    "mass_kg": MASS,
}


def compensation_file(project: Project, config: ModelConfig) -> Path | None:
    """The CSV of blocks that the model configuration names, if it names one."""
    name = config.gravity.compensation_masses
    return None if name is None else project.resolve(name)


def compensation_masses(project: Project, config: ModelConfig) -> list[CompensationMass]:
    """All blocks, those of the CSV first.

    Raises
    ------
    InputError : the CSV or a line of it is wrong, or two of its lines name the same block.
    ConfigError : a table names a block that is there already.
    """
    path = compensation_file(project, config)
    blocks = [] if path is None else _listed(path)
    blocks += [table.block() for table in config.compensation_mass]
    names = [block.name for block in blocks]
    problems = [
        ("compensation_mass", f"two blocks have the name {name!r}")
        for name in sorted({n for n in names if names.count(n) > 1})
    ]
    if problems:
        raise ConfigError(problems, where=str(project.model))
    return blocks


def _listed(path: Path) -> list[CompensationMass]:
    """The blocks of a CSV."""
    rows = read_table(path, COLUMNS)
    first: dict[str, int] = {}
    for row in rows:
        name = row.text["name"]
        if (line := first.setdefault(name, row.line)) != row.line:
            raise InputError(f"the block {name!r} is in line {line} already", where=f"{path}:{row.line}")
    return [_block(row) for row in rows]


def _block(row: Row) -> CompensationMass:
    return CompensationMass(
        name=row.text["name"],
        centre_m=np.array([row.number[c] for c in CENTRE]),
        size_m=np.array([row.number[c] for c in SIZE]),
        mass_kg=row.number["mass_kg"],
        axes=axes_of_rotation([row.number[c] for c in ROTATION]),
    )
