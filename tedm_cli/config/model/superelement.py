"""Superelements of a configuration: what stands for a structure that is given as matrices, and its lists."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import Field, field_validator

from tedm_cli.area_names import area_name_fact
from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.config.base import IDENTIFIER, MATRIX_NAME, FileName, Id, Strict
from tedm_cli.config.model.areas import AreaName
from tedm_cli.errors import InputError
from tedm_cli.quantities import COORDINATE, ID, MASS
from tedm_cli.tables.csv_table import read_table

if TYPE_CHECKING:
    from tedm_cli.config.project import Project

PLACE = ("x_m", "y_m", "z_m")
AREA_COLUMNS = {"area": None, **dict.fromkeys(PLACE, COORDINATE)}
MASS_COLUMNS = {"node": ID, **dict.fromkeys(PLACE, COORDINATE), "mass_kg": MASS}
MatrixName = Annotated[str, Field(pattern=MATRIX_NAME)]


class SuperelementTable(Strict):
    """A structure that is reduced to grids of the deck, such as a spacecraft whose owner gives no mesh."""

    name: Annotated[str, Field(pattern=IDENTIFIER)] = Field(description="Name of the superelement, in messages.")
    matrices: FileName = Field(
        description="OUTPUT4 (`.op4`), or bulk data with DMIG cards: stiffness, thermal loads and recovery, in the "
        "units of the deck."
    )
    interface: list[Id] = Field(
        min_length=1,
        description="Grids of the deck that the matrices begin with, six freedoms each, in their order.",
    )
    areas: FileName = Field(
        description="A CSV `area,x_m,y_m,z_m`: the thermal areas, in the order of the columns of the loads, with their "
        "centroids in the basic frame."
    )
    masses: FileName | None = Field(
        default=None,
        description="A CSV `node,x_m,y_m,z_m,mass_kg`, and `area` if known: the grids with mass in the order of the "
        "recovery. Without it the superelement has no mass.",
    )
    shared: list[AreaName] = Field(
        default_factory=list,
        description="Areas of the superelement that the deck has too: they are at both sides of the interface.",
    )
    grounded: bool = Field(
        default=False, description="Whether the reduced structure is held by itself. Else it must move freely as one."
    )
    stiffness: MatrixName = Field(default="KAA", description="Name of the stiffness in the file.")
    loads: MatrixName = Field(default="PA", description="Name of the thermal loads, a column for +1 K on each area.")
    recovery: MatrixName = Field(
        default="GRA", description="Name of the motions of grids with mass by those of the interface."
    )
    thermal_recovery: MatrixName = Field(
        default="URA", description="Name of what each area adds to these motions per K, with the interface at rest."
    )

    @field_validator("interface")
    @classmethod
    def _once(cls, value: list[int]) -> list[int]:
        twice = sorted({i for i in value if value.count(i) > 1})
        if twice:
            raise ValueError(f"grid {twice[0]} is there twice")
        return value


@dataclass(frozen=True, eq=False)
class Superelement:
    """A superelement with its lists: k areas, r grids with mass.

    centroid [k, 3], position [r, 3], m, basic frame; mass [r] and area_mass [k], kg, the
    latter without interface grids; node [r] and the area of each, in
    upper case, or nothing.
    """

    table: SuperelementTable
    matrices: Path
    area: tuple[str, ...]
    centroid: FloatArray
    area_mass: FloatArray
    node: IntArray
    node_area: tuple[str, ...]
    position: FloatArray
    mass: FloatArray

    @property
    def interface(self) -> IntArray:
        return np.array(self.table.interface, dtype=np.int64)

    @property
    def own(self) -> tuple[str, ...]:
        """Names of the areas that the deck does not have."""
        shared = {name.upper() for name in self.table.shared}
        return tuple(name for name in self.area if name.upper() not in shared)


def superelement_files(project: Project, tables: list[SuperelementTable]) -> list[Path]:
    """The files that superelements are read from."""
    return [
        project.resolve(name)
        for table in tables
        for name in (table.matrices, table.areas, table.masses)
        if name is not None
    ]


def load_superelements(project: Project, tables: list[SuperelementTable]) -> list[Superelement]:
    """Superelements of a configuration with their lists.

    Raises
    ------
    InputError : a list that cannot be read, that names something twice, or names no area; a shared area that the
        superelement does not have; an area or a grid of two superelements.
    """
    out: list[Superelement] = []
    owner: dict[str | int, str] = {}
    for table in tables:
        areas, masses = project.resolve(table.areas), None if table.masses is None else project.resolve(table.masses)
        one = _loaded(table, project.resolve(table.matrices), areas, masses)
        for key in (*(name.upper() for name in one.own), *one.node.tolist()):
            if key in owner:
                what = f"grid {key}" if isinstance(key, int) else f"area '{key}'"
                fact = f"{what} of superelement '{table.name}' is one of superelement '{owner[key]}' already"
                raise InputError(fact, where=str(masses if isinstance(key, int) else areas))
            owner[key] = table.name
        out.append(one)
    return out


def _loaded(table: SuperelementTable, matrices: Path, areas: Path, masses: Path | None) -> Superelement:
    lines: dict[str, int] = {}
    rows = read_table(areas, AREA_COLUMNS)
    for row in rows:
        name = row.text["area"]
        if fact := area_name_fact(name):
            raise InputError(fact, where=f"{areas}:{row.line}")
        if (line := lines.setdefault(name.upper(), row.line)) != row.line:
            raise InputError(f"area '{name}' is in line {line} already", where=f"{areas}:{row.line}")
    unknown = [name for name in table.shared if name.upper() not in lines]
    if unknown:
        raise InputError(f"does not have the shared area '{unknown[0]}'", where=str(areas))
    weights = [] if masses is None else read_table(masses, MASS_COLUMNS, ["area"])
    nodes: dict[int, int] = {}
    area_mass = dict.fromkeys(lines, 0.0)
    for row in weights:
        node = row.number["node"]
        if node != int(node):
            raise InputError(f"node must be a whole number, found {node:g}", where=f"{masses}:{row.line}")
        if (line := nodes.setdefault(int(node), row.line)) != row.line:
            raise InputError(f"node {int(node)} is in line {line} already", where=f"{masses}:{row.line}")
        if name := row.text.get("area", ""):
            if name.upper() not in area_mass:
                raise InputError(f"there is no area '{name[:60]}' in {areas}", where=f"{masses}:{row.line}")
            if int(node) not in table.interface:  # those are grids of the deck, with what is on them
                area_mass[name.upper()] += row.number["mass_kg"]

    return Superelement(
        table=table,
        matrices=matrices,
        area=tuple(row.text["area"] for row in rows),
        centroid=np.array([[row.number[c] for c in PLACE] for row in rows]),
        area_mass=np.array(list(area_mass.values())),
        node=np.array(list(nodes), dtype=np.int64),
        node_area=tuple(row.text.get("area", "").upper() for row in weights),
        position=np.array([[row.number[c] for c in PLACE] for row in weights]).reshape(-1, 3),
        mass=np.array([row.number["mass_kg"] for row in weights]),
    )
