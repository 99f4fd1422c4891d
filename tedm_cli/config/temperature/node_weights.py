"""Tables node,area,weight: how the temperatures of a thermal model's nodes make those of areas."""

from __future__ import annotations

import math
from pathlib import Path

from tedm_cli.errors import InputError
from tedm_cli.noise.columns import NodeWeights
from tedm_cli.quantities import AREA_WEIGHT
from tedm_cli.tables.csv_table import read_table

COLUMNS = {"node": None, "area": None, "weight": AREA_WEIGHT}
_SUM = 1e-6  # by which the weights of an area may differ from 1
_SHOWN = 6


def read_node_weights(path: Path) -> NodeWeights:
    """Weights by area and node.

    Raises
    ------
    InputError : the table cannot be read, has a node of an area twice, or the weights of an area do not make 1.
    """
    weights: dict[str, dict[str, float]] = {}
    for row in read_table(path, COLUMNS):
        node, area = row.text["node"], row.text["area"]
        of_area = weights.setdefault(area, {})
        if node in of_area:
            raise InputError(f"node {node!r} of area {area!r} is there twice", where=f"{path}:{row.line}")
        of_area[node] = row.number["weight"]
    sums = {area: math.fsum(of.values()) for area, of in weights.items()}
    wrong = [f"{area} ({total:.9g})" for area, total in sums.items() if abs(total - 1.0) > _SUM]
    if wrong:
        shown = ", ".join(wrong[:_SHOWN]) + (f" and {len(wrong) - _SHOWN} more" if len(wrong) > _SHOWN else "")
        raise InputError(
            f"the weights of {len(wrong)} of {len(sums)} areas do not add up to 1: {shown}",
            where=str(path),
            hint="the temperature of an area is the weighted mean of its nodes, so its weights must add up to 1",
        )
    return NodeWeights(weights, str(path))
