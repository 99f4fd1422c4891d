"""What each node of an element stands for of its volume: by these the mean of a field over elements is a sum."""

from __future__ import annotations

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.fem.measure import blocks, whole_rule
from tedm_cli.fem.shapes import CARDS, PYRAMID_AS_BRICK, Shape, shape_of
from tedm_cli.nastran.geometry import ModelGeometry


def node_volumes(geometry: ModelGeometry) -> FloatArray:
    """Integral of the shape function of each node over its element, times thickness or section, [M], m³.

    Parameters
    ----------
    geometry : M is the length of the elements' `node_index`. Springs, dampers and the like have no volume.
    """
    e = geometry.elements
    counts = np.diff(e.node_offset)
    out = np.zeros(len(e.node_index))
    cards = np.array(e.type, dtype=str)
    for card in np.unique(cards):
        for count in np.unique(counts[cards == card]).tolist():
            place = np.flatnonzero((cards == card) & (counts == count))
            at = e.node_offset[place][:, None] + np.arange(count)
            brick = card == "CPYRAM"
            shape = CARDS["CHEXA"][0] if brick else shape_of(str(card), count)
            if shape is None:
                continue
            corners = at[:, PYRAMID_AS_BRICK] if brick else at
            volume = _shares(shape, geometry.position_m[e.node_index[corners]])
            if shape.dimension < 3:
                volume *= e.section[place][:, None]
            np.add.at(out, corners, volume)  # the apex of a pyramid is four corners of the brick
    return out


def _shares(shape: Shape, nodes: FloatArray) -> FloatArray:
    """Integrals of the shape functions [E, n] over elements with nodes [E, n, 3]; also where numbered inside out."""
    out = np.zeros(nodes.shape[:2])
    for part in blocks(len(nodes)):
        values, weight = whole_rule(shape, nodes[part])
        out[part] = np.copysign(1.0, weight.sum(axis=1))[:, None] * (weight @ values)
    return out
