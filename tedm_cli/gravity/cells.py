"""Elements cut into cells that are small against their distance from a test mass, each with its own Gauss order.

Along a segment of half length h whose points are at least g away from the test mass the field is analytic inside the
Bernstein ellipse that reaches no nearer than g, whose sum of semi-axes is ρ h with ``ρ = g/h + √(1 + (g/h)²)``. Gauss
quadrature with p points then converges as ρ^-2p (Trefethen, Approximation Theory and Approximation Practice, 2013,
theorem 19.3), one power slower for each degree of the shape functions it is multiplied with, and, where the element is
distorted, a factor 1 + κ ρ slower for each degree of its Jacobian, κ being the departure of the element from an affine
one. Each direction of each cell gets the smallest p that meets the tolerance by this estimate; where that takes more
than a few points the cell is halved instead, so that cells are small where the test mass is close and nowhere else.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.errors import PhysicsError
from tedm_cli.fem.shapes import Shape, polynomials
from tedm_cli.gravity.bodies.body import Body
from tedm_cli.gravity.bodies.cuboid import Cuboid
from tedm_cli.gravity.testmass import TestMass

MOST_POINTS = 5
CLOSEST = 1e-3
"""An element closer to a test mass than this fraction of its shortest edge touches it."""
# Factor of the estimate: measured, such that the error of force, torque, their gradients and the nodal operator stays
# below the tolerance (see the tests).
_SAFETY = 3.0


@dataclass(frozen=True, eq=False)
class Cells:
    """Cells of elements of one shape that share their Gauss order.

    element : [c], index into the block; low, high : [c, d], their box in the unit cube; counts : points per direction;
    whole : per direction whether the cells span the cube.
    """

    element: IntArray
    low: FloatArray
    high: FloatArray
    counts: tuple[int, ...]
    whole: tuple[bool, ...]


def cut(
    shape: Shape,
    nodes: FloatArray,
    test_mass: TestMass,
    tolerance: float,
    *,
    clearance: FloatArray,
    names: IntArray,
    card: str,
    even: bool = True,
) -> Iterator[Cells]:
    """Cut elements for a relative quadrature error of `tolerance` in their field on a test mass.

    Parameters
    ----------
    shape : of the elements.
    nodes : [E, n, 3], their nodes in the frame of the test mass, m.
    tolerance : wanted error of each element's contribution, relative to that contribution.
    clearance : [E], distance from the test mass below which an element counts as touching it, m.
    names : [E], element ids; card : their Nastran card, for messages.
    even : whether the density is the same all over each element, or one more factor of the degree of its shape.

    Raises
    ------
    PhysicsError
        If an element reaches into the test mass, touches it, or passes through it between its nodes.
    """
    body = test_mass.body
    element = np.arange(len(nodes))
    departure = _departure(shape, nodes)
    low, high = np.zeros((len(nodes), shape.dimension)), np.ones((len(nodes), shape.dimension))
    while element.size:
        net, points = _control_net(shape, nodes, element, low, high)
        lengths, gap, closest = _extent(net, points, shape.dimension, body)
        _require_outside(points, closest, clearance[element], names[element], card, test_mass)
        gap = _gap(net, lengths, gap, body)
        kappa = departure[element] * (high - low).max(axis=1)
        wanted = _points_wanted(shape, lengths, gap, kappa, tolerance, even)
        longest = lengths.max(axis=1)
        halve = (wanted > MOST_POINTS) & (lengths > 0.6 * longest[:, None])
        halve[(wanted > MOST_POINTS).any(axis=1) & ~halve.any(axis=1)] = True
        again = halve.any(axis=1)
        stuck = again & (longest < clearance[element])
        if stuck.any():
            _touches(int(names[element[stuck][0]]), card, test_mass)
        done = np.flatnonzero(~again)
        yield from _grouped(shape, element[done], low[done], high[done], wanted[done])
        element, low, high = _halved(element[again], low[again], high[again], halve[again])


def size_and_gap(shape: Shape, nodes: FloatArray, test_mass: TestMass) -> tuple[FloatArray, FloatArray]:
    """Longest extent [E] of elements, and a lower bound [E] of their distance from a test mass, m.

    nodes : [E, n, 3], in the frame of the test mass.
    """
    whole = np.zeros((len(nodes), shape.dimension))
    net, points = _control_net(shape, nodes, np.arange(len(nodes)), whole, whole + 1.0)
    lengths, gap, _ = _extent(net, points, shape.dimension, test_mass.body)
    return lengths.max(axis=1), _gap(net, lengths, gap, test_mass.body)


def _extent(
    net: FloatArray, points: FloatArray, dimension: int, body: Body
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Lengths [c, d] of cells; distances [c] of them and of their closest points from the cuboid about a body."""
    # The compiled loops are loaded here: importing the compiler takes longer than all the rest of the room.
    from tedm_cli.gravity.cutting import put_extent

    lengths, gap, closest = np.empty((len(net), dimension)), np.empty(len(net)), np.empty(len(net))
    put_extent(net, points, body.low_m, body.high_m, lengths, gap, closest)
    return lengths, gap, closest


def _gap(net: FloatArray, lengths: FloatArray, gap: FloatArray, body: Body) -> FloatArray:
    """Distance of the boxes about control nets [c, k, 3] from the test mass, [c]: at most theirs.

    `gap` [c] is that from the cuboid that holds it. Where a box is closer than long to the cuboid that holds another
    body, the sphere about it is held against the body itself: what stands in a pocket is in that cuboid.
    """
    if not isinstance(body, Cuboid):
        close = np.flatnonzero(gap < lengths.max(axis=1))
        low, high = net[close].min(axis=1), net[close].max(axis=1)
        half_diagonal = np.linalg.norm(high - low, axis=1) / 2.0
        gap[close] = np.maximum(gap[close], body.distance((low + high) / 2.0) - half_diagonal)
    return gap


def _points_wanted(
    shape: Shape, lengths: FloatArray, gap: FloatArray, kappa: FloatArray, tolerance: float, even: bool
) -> IntArray:
    """Gauss points per direction, [c, d]; MOST_POINTS + 1 where it takes more.

    lengths : [c, d], m; gap : [c], distance from the test mass, m; kappa : [c], departure from an affine cell.
    """
    from tedm_cli.gravity.cutting import put_wanted

    degree, jacobian_degree = (2, 4) if shape.edges else (1, 2)
    wanted = np.empty(lengths.shape, dtype=np.int64)
    needed = float(np.log(_SAFETY / tolerance))
    put_wanted(lengths, gap, kappa, degree if even else 2 * degree, jacobian_degree, needed, MOST_POINTS, wanted)
    return wanted


def _departure(shape: Shape, nodes: FloatArray) -> FloatArray:
    """Largest departure of each element's nodes from its best affine image, relative to its extent, [E]."""
    from tedm_cli.gravity.cutting import put_departure

    reference = shape.reference_nodes()
    basis = reference - reference.mean(axis=0)
    departure = np.empty(len(nodes))
    put_departure(basis, np.ascontiguousarray(np.linalg.pinv(basis)), np.ascontiguousarray(nodes), departure)
    return departure


def _control_net(
    shape: Shape, nodes: FloatArray, element: IntArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Bézier control points [c, k^d, 3] of each cell, whose hull holds it, and points [c, k^d, 3] of the cell."""
    k = 3 if shape.edges else 2
    lattice = np.stack(np.meshgrid(*([np.linspace(0.0, 1.0, k)] * shape.dimension), indexing="ij"), axis=-1)
    lattice = lattice.reshape(-1, shape.dimension)
    whole = bool((low == 0.0).all() and (high == 1.0).all())
    t = lattice[None] if whole else low[:, None, :] + (high - low)[:, None, :] * lattice
    _, points = points_of_cells(shape, shape.to_element(t), element, nodes)
    if k == 2:
        return points, points
    net = points.reshape(-1, *(k,) * shape.dimension, 3).copy()
    for axis in range(1, shape.dimension + 1):
        first, middle, last = np.moveaxis(net, axis, 0)
        middle[...] = 2.0 * middle - (first + last) / 2.0
    return net.reshape(points.shape), points


def points_of_cells(
    shape: Shape, xi: FloatArray, element: IntArray, nodes: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Shape functions [c or 1, q, n] and positions [c, q, 3] of points of cells of elements.

    xi : [c or 1, q, d], in their elements' coordinates; element : [c], rows of `nodes` [E, n, 3], m.
    """
    from tedm_cli.gravity.gauss_points import put_points

    powers, coefficients = polynomials(shape)
    values = np.empty((*xi.shape[:2], shape.nodes))
    position = np.empty((len(element), xi.shape[1], 3))
    put_points(powers, coefficients[0], xi, element, nodes, values, position)
    return values, position


def _require_outside(
    points: FloatArray, closest: FloatArray, clearance: FloatArray, names: IntArray, card: str, test_mass: TestMass
) -> None:
    body = test_mass.body
    bad = ~(closest > clearance)
    if not isinstance(body, Cuboid):
        within = np.flatnonzero(bad & (closest >= 0.0))
        distance = body.distance(points[within].reshape(-1, 3)).reshape(len(within), points.shape[1])
        bad[within] = (distance <= clearance[within, None]).any(axis=1)
    if bad.any():
        first = int(np.argmax(bad))
        if closest[first] < 0.0:
            raise PhysicsError(f"{card} {names[first]} has a node without a finite position")
        _touches(int(names[first]), card, test_mass)


def _touches(name: int, card: str, test_mass: TestMass) -> None:
    plate = card.startswith(("CQUAD", "CTRIA", "CSHEAR"))
    raise PhysicsError(
        f"{card} {name} reaches into or touches the test mass ({test_mass.body.words})",
        where=f"test mass {test_mass.name!r}",
        hint="leave the test mass itself out of the source model, or correct its position and size"
        + (", or the thickness of the plate" if plate else ""),
    )


def _grouped(shape: Shape, element: IntArray, low: FloatArray, high: FloatArray, wanted: IntArray) -> Iterator[Cells]:
    """Cells with the same points per direction and, where the cube collapses, the same kind of rule."""
    spans = (low == 0.0) & (high == 1.0)
    key = np.concatenate([wanted, spans], axis=1)
    # one number per kind: rows of numbers take far longer to sort
    code = key @ (MOST_POINTS + 2) ** np.arange(key.shape[1])[::-1]
    _, first, inverse = np.unique(code, return_index=True, return_inverse=True)
    for number, kind in enumerate(key[first]):
        rows = np.flatnonzero(inverse == number)
        counts = tuple(int(n) for n in kind[: shape.dimension])
        whole = tuple(bool(n) for n in kind[shape.dimension :])
        yield Cells(element[rows], low[rows], high[rows], counts, whole)


def _halved(
    element: IntArray, low: FloatArray, high: FloatArray, halve: BoolArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    for axis in range(low.shape[1]):
        split = halve[:, axis]
        middle = (low[split, axis] + high[split, axis]) / 2.0
        upper_low, lower_high = low[split].copy(), high.copy()
        upper_low[:, axis] = middle
        lower_high[split, axis] = middle
        element = np.concatenate([element, element[split]])
        low, high = np.concatenate([low, upper_low]), np.concatenate([lower_high, high[split]])
        halve = np.concatenate([halve, halve[split]])
    return element, low, high
