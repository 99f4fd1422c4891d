"""Volumes, areas and lengths of whole elements, and what is spread over them, by Gauss quadrature."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.fem.shapes import Shape, gauss_rule, measure

_BLOCK = 4096


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


def contents(shape: Shape, nodes: FloatArray, density: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Measure [E] (m³, m² or m) of elements, and the integral [E] of a density given at their nodes.

    A solid numbered inside out counts as positive.

    Parameters
    ----------
    nodes : [E, n, 3], m; density : [E, n], per unit of the measure.
    """
    size, content = np.zeros(len(nodes)), np.zeros(len(nodes))
    for part in blocks(len(nodes)):
        values, weight = whole_rule(shape, nodes[part])
        total = weight.sum(axis=1)
        size[part] = np.abs(total)
        content[part] = np.copysign(1.0, total) * np.einsum("eq,qn,en->e", weight, values, density[part], optimize=True)
    return size, content


def blocks(count: int) -> Iterator[slice]:
    """Slices of a bounded number of elements."""
    for start in range(0, count, _BLOCK):
        yield slice(start, start + _BLOCK)
