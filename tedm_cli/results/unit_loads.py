"""The model as unit_loads.h5 tells it: its mass, and the thermal areas of its grids."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tedm_cli.arrays import BoolArray, IntArray
from tedm_cli.contracts import UNIT_LOADS
from tedm_cli.files.store import Reader
from tedm_cli.gravity.masses import ElementMasses, MassDistribution, PointMasses, lever_nodes, mass_distribution
from tedm_cli.results.gravity.ties import turning_grids


def _concentrated(unit: Reader) -> PointMasses:
    return PointMasses(
        name=[
            f"{card} {i}"
            for card, i in zip(
                unit.strings(UNIT_LOADS.MASS_CONCENTRATED_CARD),
                unit.array(UNIT_LOADS.MASS_CONCENTRATED_ID),
                strict=True,
            )
        ],
        mass=unit.array(UNIT_LOADS.MASS_CONCENTRATED),
        node=unit.array(UNIT_LOADS.MASS_CONCENTRATED_NODE),
        offset=unit.array(UNIT_LOADS.MASS_CONCENTRATED_LEVER),
    )


def area_of_grids(unit: Reader) -> IntArray:
    """Row of the thermal area of each grid [N], -1: none; no gradient, which is another load on what has an area.

    A grid that no area warms is of the first area of elements that one of its elements is of.
    """
    label = np.full(unit.dataset(UNIT_LOADS.GRID_ID).shape[0], -1)
    of_element = area_of_elements(unit)
    loaded = np.flatnonzero(of_element >= 0)
    if loaded.size:
        offset, node = unit.array(UNIT_LOADS.ELEMENT_NODE_OFFSET), unit.array(UNIT_LOADS.ELEMENT_NODE_INDEX)
        for row in loaded[np.argsort(-of_element[loaded], kind="stable")].tolist():
            label[node[offset[row] : offset[row + 1]]] = of_element[row]
    members, owner = _members(unit, UNIT_LOADS.AREA_NODE_OFFSET, UNIT_LOADS.AREA_NODE_INDEX)
    label[members] = owner
    return label


def areas_of_rows(unit: Reader, rows: IntArray) -> list[tuple[str, ...]]:
    """Names of all thermal areas of a mean temperature that each of the grids `rows` [n] is in, by itself or as a grid
    of one of their elements."""
    names = unit.strings(UNIT_LOADS.AREA_NAME)
    members, owner = _members(unit, UNIT_LOADS.AREA_NODE_OFFSET, UNIT_LOADS.AREA_NODE_INDEX)
    found = [set(owner[members == row].tolist()) for row in rows]
    carried, carrier = _members(unit, UNIT_LOADS.AREA_ELEMENT_OFFSET, UNIT_LOADS.AREA_ELEMENT_INDEX)
    if carried.size:
        offset, node = unit.array(UNIT_LOADS.ELEMENT_NODE_OFFSET), unit.array(UNIT_LOADS.ELEMENT_NODE_INDEX)
        of_element = np.repeat(np.arange(len(offset) - 1), np.diff(offset))
        for own, row in zip(found, rows, strict=True):
            own.update(carrier[np.isin(carried, of_element[node == row])].tolist())
    return [tuple(names[area] for area in sorted(own)) for own in found]


def area_of_elements(unit: Reader) -> IntArray:
    """Row of the thermal area whose load names each element [E] by a card of its own; -1: none, or a gradient alone."""
    label = np.full(unit.dataset(UNIT_LOADS.ELEMENT_ID).shape[0], -1)
    members, owner = _members(unit, UNIT_LOADS.AREA_ELEMENT_OFFSET, UNIT_LOADS.AREA_ELEMENT_INDEX)
    label[members] = owner
    return label


def _members(unit: Reader, offset: str, index: str) -> tuple[IntArray, IntArray]:
    """Members of the areas of mean temperatures, and the row of the area of each."""
    owner = np.repeat(np.arange(len(unit.strings(UNIT_LOADS.AREA_KIND))), np.diff(unit.array(offset)))
    mean = np.array(unit.strings(UNIT_LOADS.AREA_KIND))[owner] == "mean"
    return unit.array(index)[mean], owner[mean]


def lever_nodes_of(unit: Reader) -> IntArray:
    """Rows of the grids in unit_loads.h5 from which something with mass is offset, and of those that turn tied blocks,
    ascending."""
    own = lever_nodes(
        unit.array(UNIT_LOADS.ELEMENT_MASS),
        unit.array(UNIT_LOADS.ELEMENT_NODE_OFFSET),
        unit.array(UNIT_LOADS.ELEMENT_NODE_INDEX),
        unit.array(UNIT_LOADS.ELEMENT_LEVER),
        _concentrated(unit),
    )
    return np.union1d(own, turning_grids(unit))


def mass_of(
    unit: Reader,
    *,
    lumped: bool = False,
    elements: BoolArray | None = None,
    concentrated: BoolArray | None = None,
) -> MassDistribution:
    """The mass of the model in unit_loads.h5, over its elements or lumped to its grids; levers as `lever_nodes_of`.

    `elements` [E] and `concentrated` [C] : those that count; all by default.
    """
    heavy, points = unit.array(UNIT_LOADS.ELEMENT_MASS), _concentrated(unit)
    if elements is not None:
        heavy = np.where(elements, heavy, 0.0)
    if concentrated is not None:
        points = replace(points, mass=np.where(concentrated, points.mass, 0.0))
    masses = mass_distribution(
        unit.array(UNIT_LOADS.GRID_POSITION),
        ElementMasses(
            id=unit.array(UNIT_LOADS.ELEMENT_ID),
            card=unit.strings(UNIT_LOADS.ELEMENT_TYPE),
            mass=heavy,
            node_offset=unit.array(UNIT_LOADS.ELEMENT_NODE_OFFSET),
            node_index=unit.array(UNIT_LOADS.ELEMENT_NODE_INDEX),
            lever=unit.array(UNIT_LOADS.ELEMENT_LEVER),
            section=unit.array(UNIT_LOADS.ELEMENT_SECTION),
            weight=unit.array(UNIT_LOADS.ELEMENT_WEIGHT),
        ),
        points,
        lumped=lumped,
        grid_id=unit.array(UNIT_LOADS.GRID_ID),
    )
    return replace(masses, lever_node=np.union1d(masses.lever_node, turning_grids(unit)))
