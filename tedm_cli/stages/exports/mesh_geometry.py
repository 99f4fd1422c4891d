"""The finite-element mesh of unit_loads.h5 for a viewer: cells, and what is known of grids and elements at rest."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import AnyArray, FloatArray, IntArray
from tedm_cli.contracts import DISTORTION, UNIT_LOADS
from tedm_cli.errors import InputError
from tedm_cli.exports.mesh import Cells, bricks, element_cells, label_of_cells, vertices
from tedm_cli.exports.vtu import MeshArray, Names
from tedm_cli.files.store import Reader
from tedm_cli.results.gravity.compensation import Blocks
from tedm_cli.results.unit_loads import area_of_elements, area_of_grids

OPTICAL, BLOCK = "optical element", "compensation mass"


@dataclass(frozen=True, eq=False)
class MeshGeometry:
    """Points [N, 3] (m, basic frame), cells, arrays on both, names behind numbers; cards and numbers of elements that
    have no cell. Arrays on points are of the grids, which come first; behind them are the corners of blocks. `element`:
    row of the element of each cell, -1 of others."""

    points: FloatArray
    cells: list[Cells]
    on_points: list[MeshArray]
    on_cells: list[MeshArray]
    names: list[Names]
    left_out: dict[str, int]
    element: IntArray


def mesh_geometry(unit: Reader, distortion: Reader | None, blocks: Blocks | None) -> MeshGeometry:
    """Elements, then concentrated masses and (with `distortion`) optical elements, each as a cell at its grid; then
    compensation masses, as cells on points of their own."""
    card = np.array(unit.strings(UNIT_LOADS.ELEMENT_TYPE), dtype=str)
    cells, left = element_cells(
        card, unit.array(UNIT_LOADS.ELEMENT_NODE_OFFSET), unit.array(UNIT_LOADS.ELEMENT_NODE_INDEX)
    )
    row = np.concatenate([np.zeros(0, dtype=np.int64), *(c.row for c in cells)])
    heavy = unit.array(UNIT_LOADS.MASS_CONCENTRATED_NODE)
    optical: list[str] = []
    grid = np.zeros(0, dtype=np.int64)
    if distortion is not None and distortion.has(DISTORTION.OPTICAL_NAME):
        optical, grid = distortion.strings(DISTORTION.OPTICAL_NAME), optical_grids(unit, distortion)
    cells += [vertices(node) for node in (heavy, grid) if len(node)]
    position = unit.array(UNIT_LOADS.GRID_POSITION)
    block_names, corner = ([], np.zeros((0, 3))) if blocks is None else (blocks.name, blocks.corner.reshape(-1, 3))
    if block_names:
        cells.append(bricks(len(position), len(block_names)))
    types = [*card[row].tolist(), *unit.strings(UNIT_LOADS.MASS_CONCENTRATED_CARD)]
    types += [*[OPTICAL] * len(grid), *[BLOCK] * len(block_names)]
    type_names = sorted(set(types), key=lambda name: (name == BLOCK, name == OPTICAL, name))
    number = {name: i for i, name in enumerate(type_names)}

    def column(path: str, concentrated: AnyArray | float, other: AnyArray | float, block: AnyArray | float) -> AnyArray:
        counts = (len(heavy), len(grid), len(block_names))
        parts = [np.broadcast_to(v, n) for v, n in zip((concentrated, other, block), counts, strict=True)]
        return np.concatenate([unit.array(path)[row], *parts])

    ids = unit.array(UNIT_LOADS.GRID_ID)
    of_blocks = (0.0, 0.0) if blocks is None else (blocks.mass_kg, blocks.density)
    label, (groups, group_of) = area_of_grids(unit), _groups(unit)
    of_points = np.concatenate([label, np.full(len(corner), -1)])
    area = np.concatenate([np.zeros(0, dtype=np.int64), *(label_of_cells(c.nodes, of_points) for c in cells)])
    of_element = area_of_elements(unit)[row]
    area[: len(row)] = np.where(of_element >= 0, of_element, area[: len(row)])
    none = np.full(len(types), -1)
    which, which_block = none.copy(), none
    which[len(row) + len(heavy) :][: len(grid)] = np.arange(len(grid))
    which_block[len(types) - len(block_names) :] = np.arange(len(block_names))
    on_cells = [
        MeshArray(
            "element_id",
            column(UNIT_LOADS.ELEMENT_ID, unit.array(UNIT_LOADS.MASS_CONCENTRATED_ID), ids[grid], 0),
            "1",
            "Nastran element id; of optical elements the id of their grid; 0: compensation mass",
        ),
        MeshArray("element_type", np.array([number[t] for t in types]), "1", "Nastran card"),
        MeshArray("property_id", column(UNIT_LOADS.ELEMENT_PROPERTY_ID, 0, 0, 0), "1", "Nastran property id; 0: none"),
        MeshArray(
            "element_area",
            area,
            "1",
            "thermal area whose load names the element, else that of most of its grids; -1: none",
        ),
        MeshArray("element_group", group_of[area], "1", "group of that thermal area; -1: none"),
        MeshArray(
            "element_mass",
            column(UNIT_LOADS.ELEMENT_MASS, unit.array(UNIT_LOADS.MASS_CONCENTRATED), 0.0, of_blocks[0]),
            "kg",
            "mass",
            total=True,
        ),
        MeshArray(
            "density",
            column(UNIT_LOADS.ELEMENT_DENSITY, np.nan, np.nan, of_blocks[1]),
            "kg/m^3",
            "density of the material; nan: no single one",
        ),
        MeshArray(
            "expansion",
            column(UNIT_LOADS.ELEMENT_EXPANSION, np.nan, np.nan, np.nan),
            "1/K",
            "thermal expansion of the material",
        ),
        MeshArray(
            "section",
            column(UNIT_LOADS.ELEMENT_SECTION, 0.0, 0.0, 0.0),
            "m or m^2",
            "thickness of plates, cross-section of lines",
        ),
        MeshArray("optical_element", which, "1", "optical element; -1: none"),
        MeshArray("compensation_mass", which_block, "1", "compensation mass; -1: none"),
    ]
    on_points = [
        MeshArray("grid_id", ids, "1", "Nastran grid id; -1: corner of a compensation mass"),
        MeshArray("area_index", label, "1", "thermal area; -1: none"),
        MeshArray("group_index", group_of[label], "1", "group of the thermal area; -1: none"),
        MeshArray("mass", unit.array(UNIT_LOADS.MASS_LUMPED), "kg", "lumped mass of the grid", total=True),
    ]
    areas, group = unit.strings(UNIT_LOADS.AREA_NAME), unit.strings(UNIT_LOADS.AREA_GROUP)
    names = [
        *(Names(array, areas, group) for array in ("element_area", "area_index")),
        *(Names(array, groups, groups) for array in ("element_group", "group_index")),
        Names("element_type", type_names, type_names),
        Names("optical_element", optical, optical),
        Names("compensation_mass", block_names, block_names),
    ]
    left_out = dict(sorted(Counter(card[left].tolist()).items()))
    element = np.full(len(types), -1)
    element[: len(row)] = row
    return MeshGeometry(np.concatenate([position, corner]), cells, on_points, on_cells, names, left_out, element)


def optical_grids(unit: Reader, distortion: Reader) -> IntArray:
    """Rows of the grids [E] that carry the optical elements; none, where there are no optics."""
    if not distortion.has(DISTORTION.OPTICAL_GRID):
        return np.zeros(0, dtype=np.int64)
    ids, wanted = unit.array(UNIT_LOADS.GRID_ID), distortion.array(DISTORTION.OPTICAL_GRID)
    rows = np.minimum(np.searchsorted(ids, wanted), len(ids) - 1)
    if (ids[rows] != wanted).any():
        raise InputError(
            f"names grids of optical elements that {unit.path.name} does not hold",
            where=str(distortion.path),
            hint=f"rebuild it with `{distortion.kind.made_by}`, or `tedm run`",
        )
    return np.asarray(rows, dtype=np.int64)


def _groups(unit: Reader) -> tuple[list[str], IntArray]:
    """Names of the groups, and the group of each area [k], with -1 behind the last for what is in none."""
    group = unit.strings(UNIT_LOADS.AREA_GROUP)
    names = list(dict.fromkeys(group))
    return names, np.array([*(names.index(g) for g in group), -1])
