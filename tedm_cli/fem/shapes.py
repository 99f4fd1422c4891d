"""Shape functions of Nastran's solids, plates and line elements, and Gauss rules over parts of them.

All elements are seen as images of the unit cube: its coordinates t in [0, 1]^d are mapped to the element's own
coordinates ξ, and where the element has triangles the cube is collapsed (ξ₁ = t₁, ξ₂ = t₂ (1 - t₁), ...; Stroud,
Approximate Calculation of Multiple Integrals, 1971). A part of an element is then a box in t, whatever its shape. Every
shape function is of degree 2 at most in each t. Corner functions are the linear ones less half of the functions of the
midside nodes on their edges (Zienkiewicz & Taylor, The Finite Element Method, vol. 1, chapter 5).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray, IntArray

_HEX_CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
_BOTTOM_TO_TOP = {3: [(0, 1), (1, 2), (2, 0)], 4: [(0, 1), (1, 2), (2, 3), (3, 0)]}


def _prism_edges(n: int) -> tuple[tuple[int, int], ...]:
    """Edges of a prism on a polygon of n corners in Nastran's order of midside nodes: bottom, uprights, top."""
    ring = _BOTTOM_TO_TOP[n]
    return (*ring, *((i, i + n) for i in range(n)), *((a + n, b + n) for a, b in ring))


@dataclass(frozen=True)
class Shape:
    """An isoparametric element.

    family : line, triangle, quadrilateral, tetrahedron, pentahedron or hexahedron.
    dimension : 1, 2 or 3.
    corners : number of corner nodes, first in Nastran's order.
    edges : the two corners of each midside node, in Nastran's order; empty for linear elements.
    collapse : exponents of the factors (1 - t_i) in the Jacobian of the cube's collapse, per coordinate.
    """

    family: str
    dimension: int
    corners: int
    edges: tuple[tuple[int, int], ...]
    collapse: tuple[int, ...]

    @property
    def nodes(self) -> int:
        return self.corners + len(self.edges)

    def reference_nodes(self) -> FloatArray:
        """Coordinates ξ of the nodes, [nodes, dimension]."""
        if self.family in ("line", "quadrilateral", "hexahedron"):
            corners = _HEX_CORNERS[: self.corners, : self.dimension].astype(float)
        elif self.family == "pentahedron":
            corners = np.array([(x, y, z) for z in (0.0, 1.0) for x, y in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))])
        else:
            corners = np.concatenate([np.zeros((1, self.dimension)), np.eye(self.dimension)])
        return np.concatenate([corners, *(corners[list(edge)].mean(axis=0, keepdims=True) for edge in self.edges)])

    def to_element(self, t: FloatArray) -> FloatArray:
        """Coordinates ξ of points t of the unit cube; both [..., dimension], ξ in [0, 1]."""
        if not any(self.collapse):
            return t
        xi = np.array(t)
        xi[..., 1] = t[..., 1] * (1.0 - t[..., 0])
        if self.family == "tetrahedron":
            xi[..., 2] = t[..., 2] * (1.0 - t[..., 0]) * (1.0 - t[..., 1])
        return xi

    def functions(self, xi: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Shape functions [..., nodes] and their derivatives [..., nodes, dimension] at points ξ [..., dimension]."""
        linear, slope = _linear(self, xi)
        if not self.edges:
            return linear, slope
        middle, middle_slope = _midside(self, xi, linear, slope)
        ends = np.zeros((len(self.edges), self.corners))
        for row, edge in enumerate(self.edges):
            ends[row, list(edge)] = 0.5
        corner = linear - middle @ ends
        corner_slope = slope - np.einsum("...md,mc->...cd", middle_slope, ends)
        return np.concatenate([corner, middle], axis=-1), np.concatenate([corner_slope, middle_slope], axis=-2)


def _linear(shape: Shape, xi: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The linear functions of the corners, and their derivatives."""
    if shape.family in ("line", "quadrilateral", "hexahedron"):
        corners = _HEX_CORNERS[: shape.corners, : shape.dimension]
        # a factor t or 1 - t per corner and coordinate
        factor = np.where(corners == 1, xi[..., None, :], 1.0 - xi[..., None, :])
        sign = 2.0 * corners - 1.0
        slope = np.empty_like(factor)
        for axis in range(shape.dimension):
            others = [a for a in range(shape.dimension) if a != axis]
            slope[..., axis] = sign[:, axis] * factor[..., others].prod(axis=-1)
        return factor.prod(axis=-1), slope
    flat = 3 if shape.family == "tetrahedron" else 2
    area = np.concatenate([1.0 - xi[..., :flat].sum(axis=-1, keepdims=True), xi[..., :flat]], axis=-1)
    gradient = np.concatenate([-np.ones((1, flat)), np.eye(flat)])
    if shape.family != "pentahedron":
        return area, np.broadcast_to(gradient, (*area.shape, flat)).copy()
    height = xi[..., 2:]
    slope = np.zeros((*area.shape[:-1], 6, 3))
    slope[..., :3, :2] = (1.0 - height)[..., None] * gradient
    slope[..., 3:, :2] = height[..., None] * gradient
    slope[..., :3, 2], slope[..., 3:, 2] = -area, area
    return np.concatenate([area * (1.0 - height), area * height], axis=-1), slope


def _midside(shape: Shape, xi: FloatArray, linear: FloatArray, slope: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Functions of the midside nodes, 4 a b with a, b linear along the edge, times the linear fall-off across it."""
    values = np.empty((*xi.shape[:-1], len(shape.edges)))
    slopes = np.empty((*values.shape, shape.dimension))
    for row, (a, b) in enumerate(shape.edges):
        upright = shape.family == "pentahedron" and abs(a - b) == 3
        if shape.family in ("triangle", "tetrahedron"):
            first, first_slope, second, second_slope = (
                linear[..., a],
                slope[..., a, :],
                linear[..., b],
                slope[..., b, :],
            )
        else:
            # The sum of both ends' functions falls off linearly across the edge and is constant along it ...
            first, first_slope = linear[..., a] + linear[..., b], slope[..., a, :] + slope[..., b, :]
            axis = 2 if upright else int(np.flatnonzero(_HEX_CORNERS[a] != _HEX_CORNERS[b])[0])
            along = xi[..., axis]
            # ... and what is left is 4 t (1 - t) along it.
            second = along * (1.0 - along)
            second_slope = np.zeros_like(first_slope)
            second_slope[..., axis] = 1.0 - 2.0 * along
        if shape.family == "pentahedron" and not upright:
            # in the triangles the product of two area coordinates, at the edge's height
            level = xi[..., 2] if a >= 3 else 1.0 - xi[..., 2]
            area, gradient = _linear(_TRIANGLE, xi[..., :2])
            first, second = area[..., a % 3] * level, area[..., b % 3]
            first_slope = np.empty((*first.shape, 3))
            first_slope[..., :2] = level[..., None] * gradient[..., a % 3, :]
            first_slope[..., 2] = area[..., a % 3] * (1.0 if a >= 3 else -1.0)
            second_slope = np.zeros_like(first_slope)
            second_slope[..., :2] = gradient[..., b % 3, :]
        values[..., row] = 4.0 * first * second
        slopes[..., row, :] = 4.0 * (first_slope * second[..., None] + first[..., None] * second_slope)
    return values, slopes


_TRIANGLE = Shape("triangle", 2, 3, (), (1, 0))
_LINE = Shape("line", 1, 2, (), (0,))
_RING = {3: tuple(_BOTTOM_TO_TOP[3]), 4: tuple(_BOTTOM_TO_TOP[4])}
_TETRA_EDGES = (*_RING[3], (0, 3), (1, 3), (2, 3))
_SOLID = {
    "CTETRA": (Shape("tetrahedron", 3, 4, (), (2, 1, 0)), Shape("tetrahedron", 3, 4, _TETRA_EDGES, (2, 1, 0))),
    "CPENTA": (Shape("pentahedron", 3, 6, (), (1, 0, 0)), Shape("pentahedron", 3, 6, _prism_edges(3), (1, 0, 0))),
    "CHEXA": (Shape("hexahedron", 3, 8, (), (0, 0, 0)), Shape("hexahedron", 3, 8, _prism_edges(4), (0, 0, 0))),
}
_TRIANGLES = (_TRIANGLE, Shape("triangle", 2, 3, _RING[3], (1, 0)))
_QUADRILATERALS = (Shape("quadrilateral", 2, 4, (), (0, 0)), Shape("quadrilateral", 2, 4, _RING[4], (0, 0)))
CARDS: dict[str, tuple[Shape, ...]] = {
    **_SOLID,
    **dict.fromkeys(("CTRIA3", "CTRIA6", "CTRIAR"), _TRIANGLES),
    **dict.fromkeys(("CQUAD4", "CQUAD8", "CQUADR", "CSHEAR"), _QUADRILATERALS),
    **dict.fromkeys(("CBAR", "CBEAM", "CROD", "CONROD", "CTUBE"), (_LINE,)),
}
"""Nastran card name to its linear and, where there is one, its quadratic shape."""

PYRAMID_AS_BRICK = [0, 1, 2, 3, 4, 4, 4, 4]
"""A pyramid's corners as a brick whose top has shrunk to the apex: the same volume, exactly."""


def shape_of(card: str, nodes: int) -> Shape | None:
    """The shape of a Nastran card with so many nodes, or None where there is none."""
    return next((shape for shape in CARDS.get(card, ()) if shape.nodes == nodes), None)


def corner_count(card: str) -> int | None:
    """Number of corners of a card's shape, or None where the card has none."""
    return CARDS[card][0].corners if card in CARDS else None


@lru_cache(maxsize=32)
def polynomials(shape: Shape) -> tuple[IntArray, FloatArray]:
    """The shape functions written out in powers of ξ, as compiled loops take them; `Shape.functions` is what they are.

    Returns
    -------
    powers [k, d] of the monomials, the constant first, and coefficients [1 + d, k, n] of the functions and of their
    derivatives along each ξ.
    """
    powers = np.array(list(np.ndindex((3,) * shape.dimension)), dtype=np.int64)
    values, _ = shape.functions(powers / 2.0)
    monomials = ((powers / 2.0)[:, None, :] ** powers).prod(axis=-1)
    # The coefficients are integers, so that rounding leaves no error.
    functions = np.round(np.linalg.solve(monomials, values))
    row = {tuple(power): k for k, power in enumerate(powers.tolist())}
    coefficients = np.zeros((1 + shape.dimension, *functions.shape))
    coefficients[0] = functions
    for axis in range(shape.dimension):
        for k, power in enumerate(powers.tolist()):
            if power[axis]:
                lower = [p - (i == axis) for i, p in enumerate(power)]
                coefficients[1 + axis, row[tuple(lower)]] = power[axis] * functions[k]
    used = coefficients.any(axis=(0, 2))
    powers, coefficients = powers[used], np.ascontiguousarray(coefficients[:, used])
    powers.flags.writeable = coefficients.flags.writeable = False
    return powers, coefficients


@lru_cache(maxsize=256)
def gauss_rule(counts: tuple[int, ...], exponents: tuple[int, ...]) -> tuple[FloatArray, FloatArray]:
    """Product rule over the unit cube with the weight ``Π (1 - t_i)^exponents_i``.

    Parameters
    ----------
    counts : points per coordinate; n points integrate polynomials of degree 2n - 1 in that coordinate exactly.
    exponents : of the weight, per coordinate; 0 is Gauss-Legendre, others are Gauss-Jacobi.

    Returns
    -------
    points [q, d], weights [q].
    """
    axes = []
    for n, a in zip(counts, exponents, strict=True):
        node, weight = scipy.special.roots_jacobi(n, a, 0.0)
        axes.append(((node + 1.0) / 2.0, weight / 2.0 ** (a + 1)))
    points = np.stack(np.meshgrid(*(x for x, _ in axes), indexing="ij"), axis=-1).reshape(-1, len(counts))
    weights = np.ones(1)
    for _, w in axes:
        weights = np.multiply.outer(weights, w).ravel()
    points.flags.writeable = weights.flags.writeable = False
    return points, weights


def measure(jacobian: FloatArray) -> FloatArray:
    """Volume (signed), area or length per unit of ξ; jacobian [..., d, 3] = ∂x/∂ξ."""
    dimension = jacobian.shape[-2]
    if dimension == 1:
        return np.asarray(np.sqrt((jacobian[..., 0, :] ** 2).sum(axis=-1)))
    (a, b, c), (d, e, f) = (np.moveaxis(jacobian[..., i, :], -1, 0) for i in (0, 1))
    normal = (b * f - c * e, c * d - a * f, a * e - b * d)
    if dimension == 2:
        return np.asarray(np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2))
    return np.asarray(sum(n * jacobian[..., 2, i] for i, n in enumerate(normal)))
