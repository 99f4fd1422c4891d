"""What is to be said of a test mass, a compensation mass and a subsystem of the satellite."""

from __future__ import annotations

import numpy as np

from tedm_cli.config.project import Project
from tedm_cli.contracts import SENSITIVITY
from tedm_cli.files.store import Reader
from tedm_cli.noise.areas import AreaTable
from tedm_cli.results.areas import unit_per
from tedm_cli.results.explained import Cell, Column, Table, Told, by_size
from tedm_cli.results.gravity.compensation import read_blocks
from tedm_cli.results.gravity.field import read_field
from tedm_cli.results.titles import by_subsystem, mass_title
from tedm_cli.results.wording import vector
from tedm_cli.stages.explain.areas import Rows
from tedm_cli.stages.explain.judged import verdict_table


def explain_test_mass(name: str, gravity: Reader, areas: AreaTable, rows: Rows) -> Told:
    """Its place, its outputs with the area that each hangs on most, and what limits its field at rest."""
    field = read_field(gravity)
    i, means = field.test_mass.index(name), np.flatnonzero(~areas.gradient)
    listed: list[tuple[Cell, ...]] = []
    for label, (unit, row) in rows.items():
        if f"_{name}_" in f"_{label}":
            first = means[int(np.abs(row[means]).argmax())]
            size = float(np.linalg.norm(row[means]))
            listed.append((label, size, unit_per(unit, "K"), str(areas.name[first]), float(row[first])))
    columns = (
        *(Column("output"), Column("size", "number"), Column("unit"), Column("largest by"), Column("value", "number")),
    )
    shape = gravity.strings(SENSITIVITY.TEST_MASS_SHAPE)[i]
    facts = (f"{shape}, {field.mass_kg[i]:.6g} kg, centre at {vector(field.position_m[i].tolist())} m, basic frame",)
    note = "size: root of the sum of squares over the areas of a mean temperature"
    tables = (Table("outputs", columns, tuple(listed)), verdict_table(gravity, lambda v: name in v.place.split("-")))
    return Told(name, "test mass", mass_title(name), facts, tables, (note,))


def explain_block(name: str, gravity: Reader) -> Told:
    """A compensation mass: where it is, what it follows, and how far it moves."""
    blocks = read_blocks(gravity)
    i = blocks.name.index(name)
    facts = [
        f"{blocks.mass_kg[i]:.6g} kg, centre at {vector(blocks.centre[i].tolist())} m, basic frame",
        f"tied to {blocks.tie[i]}" if blocks.tie[i] else "tied to nothing: it stays still, and is in the field at rest",
    ]
    names, units = gravity.strings(SENSITIVITY.AREA_NAME), gravity.strings(SENSITIVITY.AREA_UNIT)
    size = np.linalg.norm(blocks.translation[:, i], axis=1).tolist()
    rows = [(n, v, unit_per("m", u)) for n, v, u in zip(names, size, units, strict=True) if v]
    columns = (Column("area"), Column("moves it by", "number"), Column("unit"))
    return Told(
        name, "compensation mass", name, tuple(facts), (Table("motion", columns, by_size(rows, 1), ranked=True),)
    )


def explain_subsystem(name: str, project: Project, gravity: Reader) -> Told:
    """What limits the field at rest of a subsystem, alone and together with others."""
    table = verdict_table(gravity, lambda v: name in v.subsystem.split("+"))
    facts = () if table.rows else (f"no limit at rest in {project.model} is on it",)
    return Told(name, "subsystem of the satellite", by_subsystem(name), facts, (table,))
