"""The thermal network from CSV tables: nodes, conductors, powers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray, IndexArray
from tedm_cli.config.thermal.file import NetworkTable
from tedm_cli.config.thermal.tmd import tmd_network
from tedm_cli.errors import InputError
from tedm_cli.quantities import (
    ABSOLUTE_TEMPERATURE,
    CELSIUS,
    CONDUCTANCE,
    COORDINATE,
    HEAT,
    HEAT_CAPACITY,
    RADIATIVE_AREA,
)
from tedm_cli.tables.csv_table import Row, number_of, read_table
from tedm_cli.thermal.linear import near_name
from tedm_cli.thermal.network import ARITHMETIC, BOUNDARY, DIFFUSIVE, ThermalNetwork
from tedm_cli.thermal.state import GivenNetwork

_ZERO_CELSIUS = 273.15  # K
_NODES = {"node": None, "capacity_J_K": HEAT_CAPACITY, "kind": None}
_KELVIN, _CELSIUS = "temperature_K", "temperature_degC"
_PLACE = ("x_m", "y_m", "z_m")
_CONDUCTORS = {"node_a": None, "node_b": None, "GL_W_K": CONDUCTANCE, "GR_m2": RADIATIVE_AREA}
_POWERS = {"node": None, "power_W": HEAT}


def read_network(table: NetworkTable, path_of: Callable[[str], Path]) -> GivenNetwork:
    """The network and the temperatures that are given of it; `path_of` says where the files are that it names.

    Raises
    ------
    InputError : what is wrong in the tables, with file and line; a node from which nothing leads to a boundary.
    """
    if table.tmd is not None:
        found = tmd_network(path_of(table.tmd), table.time_s, table.unit)
    else:
        found = _from_csv(
            path_of(str(table.nodes)),
            path_of(str(table.conductors)),
            None if table.powers is None else path_of(table.powers),
        )
    found.network.require_reached(where=found.where)
    return found if table.temperatures == "keep" else found.as_start()


@dataclass(frozen=True, eq=False)
class _Nodes:
    """The table of nodes: temperatures [n] in K, NaN where empty; places [n, 3], NaN where not told."""

    path: Path
    row: dict[str, int]
    kind: list[str]
    capacity: FloatArray
    temperature: FloatArray
    place: FloatArray

    def find(self, name: str, where: str) -> int:
        if name not in self.row:
            hint = near_name(name, tuple(self.row)) or "give the node, or leave the line out"
            raise InputError(f"node {name!r} is not in {self.path}", where=where, hint=hint)
        return self.row[name]


def _from_csv(nodes_path: Path, conductors_path: Path, powers_path: Path | None) -> GivenNetwork:
    nodes = _read_nodes(nodes_path)
    a, b, linear, radiative = _read_conductors(conductors_path, nodes)
    power = np.zeros(len(nodes.row))
    for row in read_table(powers_path, _POWERS) if powers_path else ():
        power[nodes.find(row.text["node"], f"{powers_path}:{row.line}")] += row.number["power_W"]
    network = ThermalNetwork(tuple(nodes.row), np.array(nodes.kind), nodes.capacity, power, a, b, linear, radiative)
    return GivenNetwork(network, nodes.temperature, np.full(len(power), np.nan), nodes.place, str(conductors_path))


def _read_nodes(path: Path) -> _Nodes:
    rows = read_table(path, _NODES, optional=(_KELVIN, _CELSIUS, *_PLACE))
    columns = rows[0].text
    units = [name for name in (_KELVIN, _CELSIUS) if name in columns]
    if len(units) != 1:
        fact = f"has both {' and '.join(units)}" if units else f"has no column {_KELVIN}, nor {_CELSIUS}"
        raise InputError(fact, where=f"{path}:1", hint="give one of them; it may be empty in lines to be solved for")
    told = [name for name in _PLACE if name in columns]
    if told and len(told) < len(_PLACE):
        raise InputError(f"has {', '.join(told)} alone of {', '.join(_PLACE)}", where=f"{path}:1")
    by_name: dict[str, int] = {}
    folded: dict[str, str] = {}
    for number, row in enumerate(rows):
        name, where = row.text["node"], f"{path}:{row.line}"
        if name in by_name:
            raise InputError(f"node {name!r} is there twice", where=where)
        if other := folded.get(name.casefold()):
            fact = f"nodes {other!r} and {name!r} differ in case only"
            raise InputError(fact, where=where, hint="rename one of them: nobody can tell them apart in a report")
        by_name[name], folded[name.casefold()] = number, name
        _check_kind(row, units[0], where)
    temperature = [_temperature(row, units[0], f"{path}:{row.line}") for row in rows]
    place = [[_optional(row, name, path) for name in told] or [np.nan] * 3 for row in rows]
    capacity = np.array([row.number["capacity_J_K"] for row in rows])
    return _Nodes(path, by_name, [row.text["kind"] for row in rows], capacity, np.array(temperature), np.array(place))


def _check_kind(row: Row, unit: str, where: str) -> None:
    name, kind, capacity = row.text["node"], row.text["kind"], row.number["capacity_J_K"]
    if kind not in (DIFFUSIVE, ARITHMETIC, BOUNDARY):
        raise InputError(f"kind must be diffusive, arithmetic or boundary, found {kind[:40]!r}", where=where)
    if kind == DIFFUSIVE and capacity == 0.0:
        fact = f"node {name!r} is diffusive, but its capacity is 0"
        raise InputError(fact, where=where, hint="give its capacity, or call it arithmetic")
    if kind == ARITHMETIC and capacity != 0.0:
        fact = f"node {name!r} is arithmetic, but its capacity is {capacity:g} J/K"
        raise InputError(fact, where=where, hint="an arithmetic node has none: write 0, or call it diffusive")
    if kind == BOUNDARY and not row.text[unit]:
        raise InputError(f"boundary {name!r} has no temperature", where=where, hint=f"fill in {unit}")


def _temperature(row: Row, unit: str, where: str) -> float:
    field = row.text[unit].replace(",", ".")
    if not field:
        return float("nan")
    if unit == _CELSIUS:
        return number_of(CELSIUS, unit, field, where) + _ZERO_CELSIUS
    return number_of(ABSOLUTE_TEMPERATURE, unit, field, where)


def _optional(row: Row, column: str, path: Path) -> float:
    field = row.text[column].replace(",", ".")
    return number_of(COORDINATE, column, field, f"{path}:{row.line}") if field else float("nan")


def _read_conductors(path: Path, nodes: _Nodes) -> tuple[IndexArray, IndexArray, FloatArray, FloatArray]:
    rows = read_table(path, _CONDUCTORS)
    ends = np.empty((len(rows), 2), dtype=np.intp)
    for number, row in enumerate(rows):
        where = f"{path}:{row.line}"
        ends[number] = [nodes.find(row.text[column], where) for column in ("node_a", "node_b")]
        if ends[number, 0] == ends[number, 1]:
            raise InputError(f"joins node {row.text['node_a']!r} to itself", where=where)
    linear, radiative = (np.array([row.number[column] for row in rows]) for column in ("GL_W_K", "GR_m2"))
    return ends[:, 0].copy(), ends[:, 1].copy(), linear, radiative
