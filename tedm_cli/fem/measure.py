"""Volumes, areas and lengths of whole elements, and what is spread over them, by Gauss quadrature."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.fem.shapes import Shape, gauss_rule, measure

_BLOCK = 4096
_TANGLED = 1e-9  # rounding, as a share of an element's measure


def whole_rule(shape: Shape, nodes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Gauss points of whole elements: shape functions [q, n], and weights times the signed measure [E, q].

    Exact for polynomials of degree two in position, times a density linear over the element, on elements whose Jacobian
    is a polynomial: all solids, flat linear plates and straight lines. Warped plates and curved sides have a root in
    it; the rule is two points richer for plates.

    Parameters
    ----------
    shape : of the elements.
    nodes : [E, n, 3], m.
    """
    count = (5 if shape.edges else 3) + (1 if shape.dimension == 2 else 0)
    point, weight = gauss_rule((count,) * shape.dimension, shape.collapse)
    values, slopes = shape.functions(shape.to_element(point))
    return values, weight * measure(np.swapaxes(slopes, -1, -2) @ nodes[:, None])


def contents(shape: Shape, nodes: FloatArray, density: FloatArray) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Measure [E] (m³, m² or m) of elements, the integral [E] of a density given at their nodes, and which are tangled.

    The Jacobian of a tangled solid changes its sign: parts of it count as less than nothing.

    A solid numbered inside out counts as positive.

    Parameters
    ----------
    nodes : [E, n, 3], m; density : [E, n], per unit of the measure.
    """
    size, content, tangled = np.zeros(len(nodes)), np.zeros(len(nodes)), np.zeros(len(nodes), dtype=bool)
    for part in blocks(len(nodes)):
        values, weight = whole_rule(shape, nodes[part])
        total = weight.sum(axis=1)
        size[part] = np.abs(total)
        tangled[part] = np.abs(total) < (1.0 - _TANGLED) * np.abs(weight).sum(axis=1)
        content[part] = np.copysign(1.0, total) * np.einsum("eq,qn,en->e", weight, values, density[part], optimize=True)
    return size, content, tangled


def blocks(count: int) -> Iterator[slice]:
    """Slices of a bounded number of elements."""
    for start in range(0, count, _BLOCK):
        yield slice(start, start + _BLOCK)
