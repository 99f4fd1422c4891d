"""Mapped temperatures as a CSV, HDF5, cards of Nastran, or a mesh for ParaView."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.contracts import TEMPERATURES
from tedm_cli.exports.mesh import element_cells
from tedm_cli.exports.vtu import MeshArray, Names, array_name, distinct, write_vtu
from tedm_cli.files.provenance import Provenance
from tedm_cli.files.store import create, replacing
from tedm_cli.mapping.averages import NONE
from tedm_cli.nastran.loads.grid_temperatures import absolute, grid_temperature_lines
from tedm_cli.nastran.loads.temperature_sets import free_set_ids, plain, reference_temperature
from tedm_cli.nastran.loads.temperatures import selects_material_temperature
from tedm_cli.stages.thermal.map_build import Mapping
from tedm_cli.tables.csv_table import csv_line

FORMATS = (".csv", ".bdf", ".h5", ".vtu")


@dataclass(frozen=True, eq=False)
class MappedField:
    """m sets: their names, tau [n, m] of the nodes and field [N, m] of all grids, NaN where the map does not reach.

    `unit` of the temperatures: K, or K/√Hz of those that go with a noise.
    """

    mapping: Mapping
    name: list[str]
    tau: FloatArray
    field: FloatArray
    unit: str = "K"


def write_field(
    path: Path | None, mapped: MappedField, trace: Callable[[], Provenance]
) -> tuple[list[Path], list[int], list[str]]:
    """Files written, the set ids of cards, and remarks; by the suffix of the name, see `FORMATS`."""
    suffix = "" if path is None else path.suffix.lower()
    if path is None:
        return [], [], []
    if suffix == ".vtu":
        return _write_mesh(path, mapped), [], []
    if suffix == ".bdf":
        return _write_cards(path, mapped)
    if suffix == ".h5":
        _write_hdf5(path, mapped, trace())
    else:
        _write_csv(path, mapped)
    return [path], [], []


def _reached(mapped: MappedField) -> IntArray:
    return np.flatnonzero(mapped.mapping.through.mapped)


def _write_csv(path: Path, mapped: MappedField) -> None:
    rows = _reached(mapped)
    ids = mapped.mapping.fem.geometry.grid_id[rows].tolist()
    with replacing(path) as temporary, open(temporary, "w", encoding="utf-8", newline="") as stream:
        stream.write(csv_line(["grid", *mapped.name]))
        for grid, values in zip(ids, mapped.field[rows], strict=True):
            stream.write(f"{grid}," + ",".join(f"{value:.12g}" for value in values.tolist()) + "\n")


def _write_hdf5(path: Path, mapped: MappedField, trace: Provenance) -> None:
    rows, geometry = _reached(mapped), mapped.mapping.fem.geometry
    with create(path, TEMPERATURES, trace) as writer:
        writer.write(TEMPERATURES.GRID_ID, geometry.grid_id[rows])
        writer.write(TEMPERATURES.GRID_POSITION, geometry.position_m[rows])
        writer.write(TEMPERATURES.MAP_NODE, mapped.mapping.node)
        writer.write(TEMPERATURES.SET_NAME, mapped.name)
        writer.write(TEMPERATURES.GIVEN, mapped.tau.T)
        writer.write(TEMPERATURES.TEMPERATURE, np.ascontiguousarray(mapped.field[rows].T))


def _write_cards(path: Path, mapped: MappedField) -> tuple[list[Path], list[int], list[str]]:
    """Cards to be included: a temperature set for each set, from the temperature at which the model is at rest."""
    fem = mapped.mapping.fem
    reference = reference_temperature(
        fem.model,
        fem.config.model.reference_temperature_K,
        material_temperature=selects_material_temperature(fem.model),
        where=str(fem.source),
    )
    sids = free_set_ids(fem.model, len(mapped.name) + reference.is_initial, str(fem.source))
    degrees = fem.geometry.units.degrees_per_kelvin
    rows = _reached(mapped)
    ids = fem.geometry.grid_id[rows]
    with replacing(path) as temporary, open(temporary, "w", encoding="ascii", newline="\n") as stream:
        stream.write(f"$ Temperatures of {len(rows)} grids; at rest {plain(reference.value)}\n$ In the case control:\n")
        for sid, name in zip(sids, mapped.name, strict=False):
            shown = name.encode("ascii", "replace").decode("ascii")[:40]
            stream.write(f"$   TEMPERATURE(LOAD) = {sid:<9} $ {shown}\n")
        if reference.is_initial:
            stream.write(f"$ and above all subcases:\n$   TEMPERATURE(INITIAL) = {sids[-1]}\n")
            stream.writelines(f"{line}\n" for line in grid_temperature_lines(sids[-1], reference.value, ids[:0], []))
        for number, sid in zip(range(len(mapped.name)), sids, strict=False):
            values = absolute(mapped.field[rows, number], reference.value, degrees)
            stream.writelines(f"{line}\n" for line in grid_temperature_lines(sid, reference.value, ids, values))
    return [path], sids[: len(mapped.name)], list(reference.notes)


def _write_mesh(path: Path, mapped: MappedField) -> list[Path]:
    mapping = mapped.mapping
    geometry = mapping.fem.geometry
    e = geometry.elements
    cells, _ = element_cells(e.type, e.node_offset, e.node_index)
    rows = np.concatenate([np.zeros(0, dtype=np.int64), *(c.row for c in cells)])
    on_points = [MeshArray("grid_id", geometry.grid_id, "1", "Nastran id of the grid")]
    on_points += [
        MeshArray(
            array_name("temperature", name),
            mapped.field[:, i].copy(),
            mapped.unit.replace("√Hz", "sqrt(Hz)"),
            f"{name}, above the reference; nan: not mapped",
        )
        for i, name in enumerate(mapped.name)
    ]
    on_cells = [MeshArray("element_id", e.id[rows], "1", "Nastran id of the element")]
    names = []
    if mapping.association is not None:
        node = mapping.association.place_node[e.node_offset[rows]]
        meaning = f"number of the thermal node at its first grid, from 0 on, {NONE}: none"
        on_cells.append(MeshArray("thermal_node", node, "1", meaning))
        names.append(Names("thermal_node", mapping.node, mapping.node))
    return write_vtu(path, geometry.position_m, cells, distinct(on_points), on_cells, names)
