"""The model as unit_loads.h5 tells it: its mass, and the thermal areas of its grids."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tedm_cli.arrays import IntArray
from tedm_cli.contracts import UNIT_LOADS
from tedm_cli.files.store import Reader
from tedm_cli.gravity.masses import ElementMasses, MassDistribution, PointMasses, lever_nodes, mass_distribution
from tedm_cli.results.ties import turning_grids


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
    """Row of the thermal area of each grid [N], -1: none."""
    offset = unit.array(UNIT_LOADS.AREA_NODE_OFFSET)
    label = np.full(unit.dataset(UNIT_LOADS.GRID_ID).shape[0], -1)
    label[unit.array(UNIT_LOADS.AREA_NODE_INDEX)] = np.repeat(np.arange(len(offset) - 1), np.diff(offset))
    return label


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


def mass_of(unit: Reader, *, lumped: bool = False) -> MassDistribution:
    """The mass of the model in unit_loads.h5, over its elements or lumped to its grids; levers as `lever_nodes_of`."""
    masses = mass_distribution(
        unit.array(UNIT_LOADS.GRID_POSITION),
        ElementMasses(
            id=unit.array(UNIT_LOADS.ELEMENT_ID),
            card=unit.strings(UNIT_LOADS.ELEMENT_TYPE),
            mass=unit.array(UNIT_LOADS.ELEMENT_MASS),
            node_offset=unit.array(UNIT_LOADS.ELEMENT_NODE_OFFSET),
            node_index=unit.array(UNIT_LOADS.ELEMENT_NODE_INDEX),
            lever=unit.array(UNIT_LOADS.ELEMENT_LEVER),
            section=unit.array(UNIT_LOADS.ELEMENT_SECTION),
            weight=unit.array(UNIT_LOADS.ELEMENT_WEIGHT),
        ),
        _concentrated(unit),
        lumped=lumped,
        grid_id=unit.array(UNIT_LOADS.GRID_ID),
    )
    return replace(masses, lever_node=np.union1d(masses.lever_node, turning_grids(unit)))
