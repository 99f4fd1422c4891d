"""The mass of the model as unit_loads.h5 tells it."""

from __future__ import annotations

from tedm_cli.arrays import IntArray
from tedm_cli.files.store import Reader
from tedm_cli.gravity.masses import ElementMasses, MassDistribution, PointMasses, lever_nodes, mass_distribution


def _concentrated(unit: Reader) -> PointMasses:
    return PointMasses(
        name=[
            f"{card} {i}"
            for card, i in zip(
                unit.strings("/mass/concentrated_card"), unit.array("/mass/concentrated_id"), strict=True
            )
        ],
        mass=unit.array("/mass/concentrated"),
        node=unit.array("/mass/concentrated_node"),
        offset=unit.array("/mass/concentrated_lever"),
    )


def lever_nodes_of(unit: Reader) -> IntArray:
    """Rows of the grids in unit_loads.h5 from which something with mass is offset, ascending."""
    return lever_nodes(
        unit.array("/element/mass"),
        unit.array("/element/node_offset"),
        unit.array("/element/node_index"),
        unit.array("/element/lever"),
        _concentrated(unit),
    )


def mass_of(unit: Reader, *, lumped: bool = False) -> MassDistribution:
    """The mass of the model in unit_loads.h5, spread over its elements or lumped to its grids."""
    return mass_distribution(
        unit.array("/grid/position"),
        ElementMasses(
            id=unit.array("/element/id"),
            card=unit.strings("/element/type"),
            mass=unit.array("/element/mass"),
            node_offset=unit.array("/element/node_offset"),
            node_index=unit.array("/element/node_index"),
            lever=unit.array("/element/lever"),
            section=unit.array("/element/section"),
            weight=unit.array("/element/weight"),
        ),
        _concentrated(unit),
        lumped=lumped,
        grid_id=unit.array("/grid/id"),
    )
