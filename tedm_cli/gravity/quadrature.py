"""Gauss points of the elements as sources of gravity, with their interpolation to the nodes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import PhysicsError
from tedm_cli.fem.shapes import gauss_rule, polynomials
from tedm_cli.gravity.cells import CLOSEST, Cells, cut, points_of_cells
from tedm_cli.gravity.masses import ElementBlock, MassDistribution, PointMasses
from tedm_cli.gravity.testmass import TestMass, to_test_mass_frame

_BLOCK_ELEMENTS = 1 << 12
_BLOCK_POINTS = 1 << 14
_TANGLED = 1e-9


@dataclass(frozen=True, eq=False)
class QuadraturePoints:
    """Sources q of cells c with their interpolation: ``x = Σ_n values[n] (x_n + lever_n)`` and so for displacements.

    owner : [c], index of the element in its block (of the point mass in its table).
    position : [c, q, 3], frame of the test mass, m.
    mass : [c, q], kg.
    values : [c or 1, q, n], shape functions.
    nodes : [c, n], rows of the grid table.
    lever : [c, n, 3], basic frame, m.
    """

    owner: IntArray
    position: FloatArray
    mass: FloatArray
    values: FloatArray
    nodes: IntArray
    lever: FloatArray


def quadrature_points(
    distribution: MassDistribution,
    test_mass: TestMass,
    tolerance: float,
    advance: Callable[[int], None] = lambda _: None,
) -> Iterator[QuadraturePoints]:
    """All sources of a model, in blocks of bounded size.

    The mass of an element is spread over its volume, area or length with the weight d of its density:
    ``m_q = m w_q |J_q| d_q / Σ w |J| d``. Order and subdivision follow from the size of the element against its
    distance from the test mass, see `tedm_cli.gravity.cells`.

    Parameters
    ----------
    distribution : the model's mass.
    test_mass : the body acted upon.
    tolerance : error of each element's field, relative to that field.
    advance : called with the number of elements done since the last call.

    Raises
    ------
    PhysicsError
        If an element or a point mass is inside or on the test mass or not finite, or a solid is tangled (its Jacobian
        changes sign); names it.
    """
    yield from point_sources(distribution, test_mass)
    for block in distribution.elements:
        for start in range(0, len(block.id), _BLOCK_ELEMENTS):
            part = slice(start, start + _BLOCK_ELEMENTS)
            yield from element_sources(distribution.position, block, part, test_mass, tolerance)
            advance(len(block.id[part]))


def point_sources(distribution: MassDistribution, test_mass: TestMass) -> Iterator[QuadraturePoints]:
    """The point masses alone, as `quadrature_points` yields them."""
    points: PointMasses = distribution.points
    for start in range(0, len(points.mass), _BLOCK_POINTS):
        part = np.arange(start, min(start + _BLOCK_POINTS, len(points.mass)))
        node, lever = points.node[part], points.offset[part]
        position = to_test_mass_frame(test_mass, distribution.position[node] + lever)
        inside = test_mass.body.first_inside(position)
        if inside is not None:
            raise PhysicsError(
                f"{points.name[part[inside]]} ({points.mass[part[inside]]:.6g} kg)"
                f" {test_mass.body.inside_fact(position[inside])}",
                where=f"test mass {test_mass.name!r}",
                hint="leave the test mass itself out of the source model, or correct its position and size",
            )
        yield QuadraturePoints(
            part, position[:, None], points.mass[part][:, None], np.ones((1, 1, 1)), node[:, None], lever[:, None]
        )


def element_sources(
    position: FloatArray, block: ElementBlock, part: slice, test_mass: TestMass, tolerance: float
) -> Iterator[QuadraturePoints]:
    """Some elements of a block, as `quadrature_points` yields them; `owner` counts from the block's first element."""
    nodes, lever = block.nodes[part], block.offset[part]
    local = to_test_mass_frame(test_mass, position[nodes] + lever)
    clearance = np.maximum(block.half_thickness[part], CLOSEST * test_mass.side_m.min())
    parts = [
        piece
        for cells in cut(
            block.shape,
            local,
            test_mass,
            tolerance,
            clearance=clearance,
            names=block.id[part],
            card=block.card,
            even=block.weight is None,
        )
        for piece in _bounded(cells)
    ]
    weights = [_weights(block, piece, local) for piece in parts]
    size, signed = np.zeros(len(nodes)), np.zeros(len(nodes))
    for cells, weight in zip(parts, weights, strict=True):
        size += np.bincount(cells.element, np.abs(weight).sum(axis=1), len(nodes))
        signed += np.bincount(cells.element, weight.sum(axis=1), len(nodes))
    relative = None if block.weight is None else block.weight[part]
    tangled = ~(np.abs(signed) > (1.0 - _TANGLED) * size)
    if tangled.any():
        raise PhysicsError(
            f"{block.card} {block.id[part][tangled][0]} is tangled or has no extent: its Jacobian changes sign or is 0",
            hint="number its nodes as Nastran asks, and give it a positive volume",
        )
    spread = [np.abs(weight) for weight in weights]
    if relative is not None:
        size = np.zeros(len(nodes))
        for n, cells in enumerate(parts):
            values, _ = points_of_cells(block.shape, _element_points(block, cells)[0], cells.element, local)
            spread[n] = spread[n] * (values @ relative[cells.element][..., None])[..., 0]
            size += np.bincount(cells.element, spread[n].sum(axis=1), len(nodes))
    density = block.mass[part] / size
    first = part.start
    for cells, weight in zip(parts, spread, strict=True):
        values, place = points_of_cells(block.shape, _element_points(block, cells)[0], cells.element, local)
        yield QuadraturePoints(
            cells.element + first,
            place,
            weight * density[cells.element, None],
            values,
            nodes[cells.element],
            lever[cells.element],
        )


def _bounded(cells: Cells) -> Iterator[Cells]:
    step = max(1, _BLOCK_POINTS // int(np.prod(np.array(cells.counts) + 1)))
    for start in range(0, len(cells.element), step):
        s = slice(start, start + step)
        yield Cells(cells.element[s], cells.low[s], cells.high[s], cells.counts, cells.whole)


def _element_points(block: ElementBlock, cells: Cells) -> tuple[FloatArray, FloatArray]:
    """Coordinates ξ [c or 1, q, d] of the Gauss points of cells, and their weights in ξ [c or 1, q]."""
    collapse = np.array(block.shape.collapse)
    # Where a cell spans the cube the rule carries the collapse in its weight; in parts the factor is written out, at
    # the price of a point.
    written = (collapse > 0) & ~np.array(cells.whole)
    counts = tuple(int(n) for n in np.array(cells.counts) + written)
    point, weight = gauss_rule(counts, tuple(int(a) for a in np.where(written, 0, collapse)))
    low, high = (cells.low[:1], cells.high[:1]) if all(cells.whole) else (cells.low, cells.high)
    t = low[:, None, :] + (high - low)[:, None, :] * point
    scale = (high - low).prod(axis=1)[:, None] * weight
    for axis in np.flatnonzero(written):
        scale = scale * (1.0 - t[..., axis]) ** collapse[axis]
    return block.shape.to_element(t), scale


def _weights(block: ElementBlock, cells: Cells, local: FloatArray) -> FloatArray:
    """Weight times (signed) measure of the Gauss points of cells, [c, q]."""
    # The compiled loops are loaded here: importing the compiler takes longer than all the rest of the room.
    from tedm_cli.gravity.gauss_points import put_measures

    xi, scale = _element_points(block, cells)
    powers, coefficients = polynomials(block.shape)
    measure = np.empty((len(cells.element), scale.shape[1]))
    put_measures(powers, coefficients[1:], xi, cells.element, local, measure)
    measure *= scale
    return measure
