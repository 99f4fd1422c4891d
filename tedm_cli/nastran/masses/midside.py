"""Midside nodes: each lies near the middle of its edge, or the element has taken the nodes of another one.

A card whose first line is lost leaves its continuation to the card before, which then seems to have midside nodes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.fem.shapes import CARDS, Shape

_FARTHEST = 0.6  # of the edge's length, from its middle; on a half circle it is a half


def check_midside(elements: Sequence[Any], shape: Shape, position: FloatArray, where: str) -> None:
    """Refuse elements of one shape, nodes at `position` [E, n, 3], with a midside node far from its edge's middle."""
    if not shape.edges or not len(elements):
        return
    first, second = (position[:, [edge[end] for edge in shape.edges]] for end in (0, 1))
    _refuse_far(elements, position[:, shape.corners :], first, second, where)


def check_partial(
    elements: Sequence[Any], position: FloatArray, rows: Callable[[IntArray, str], IntArray], where: str
) -> None:
    """The same of elements that lack some of their midside nodes; `rows` gives rows of `position` [N, 3] by grid id."""
    for element in elements:
        shape = next((s for s in CARDS.get(element.type, ()) if s.edges), None)
        if shape is None:
            continue
        corners = position[rows(np.array(element.nodes[: shape.corners], dtype=np.int64), "an element")]
        middle = np.full((len(shape.edges), 3), np.nan)
        for i, grid in enumerate(element.nodes[shape.corners :]):
            if grid:
                middle[i] = position[rows(np.array([grid], dtype=np.int64), "an element")[0]]
        first, second = (corners[[edge[end] for edge in shape.edges]] for end in (0, 1))
        _refuse_far([element], middle[None], first[None], second[None], where)


def _refuse_far(elements: Sequence[Any], middle: FloatArray, first: FloatArray, second: FloatArray, where: str) -> None:
    """Arrays [E, m, 3]."""
    off = np.linalg.norm(middle - (first + second) / 2.0, axis=2)
    far = np.argwhere(off > _FARTHEST * np.linalg.norm(second - first, axis=2))
    if far.size:
        row, column = far[0]
        element = elements[row]
        grid = element.nodes[CARDS[element.type][0].corners + column]
        raise InputError(
            f"{element.type} {element.eid}: its midside node {grid} is"
            f" {off[row, column] / np.linalg.norm((second - first)[row, column]):.3g} of its edge's length from the"
            " middle of that edge",
            where=where,
            hint="are its lines in order, and none of another element among them?",
        )
