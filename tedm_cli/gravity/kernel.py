"""Field of a homogeneous cuboid test mass for point sources: force, torque and their gradients.

All quantities are per unit ``G M m`` (test mass M, source m) in the frame of the cuboid, with R the position of the
source (Montemurro 2004, chapters 5 and 6, appendix C, corrected):

=============  ==========================================  ==================================================
force          ``F = (1/V) ∫ (R - r)/|R - r|³ dV``         attraction of the test mass towards the source
gamma_lin      ``-∂F/∂R``                                  change of F per displacement of the test mass
torque         ``T = R × F``                               about the centre of the test mass
omega_lin      ``-∂T/∂R = [F]x + [R]x gamma_lin``          change of T per displacement of the test mass
gamma_ang      ``-[F]x - gamma_lin [R]x = omega_linᵀ``     change of F per rotation of the test mass, fixed axes
omega_ang      ``[R]x gamma_ang``                          change of T per rotation of the test mass, fixed axes
=============  ==========================================  ==================================================
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tedm_cli.errors import PhysicsError
from tedm_cli.gravity.edge_form import edge_form
from tedm_cli.gravity.multipole import excess_field

Array = NDArray[np.float64]

# Distance of the source over half the body diagonal from which the expansion replaces the edge form, and the degree
# that keeps the truncation of the excess field below 1e-13 from there on, for cubes, slabs and rods alike.
_TIERS = ((1.7, 64), (2.1, 48), (2.8, 32), (4.0, 24), (8.0, 18), (20.0, 14), (60.0, 10))
_BLOCK_VALUES = 1 << 16
_TENSOR = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


@dataclass(frozen=True, eq=False)
class CuboidField:
    """Field of n point sources on a cuboid, per unit G M m, in its frame (read-only arrays)."""

    force: Array
    """[n, 3], 1/m²."""
    gamma_lin: Array
    """[n, 3, 3], 1/m³, symmetric, trace 0."""
    torque: Array
    """[n, 3], 1/m."""
    omega_lin: Array
    """[n, 3, 3], 1/m², row: torque component, column: displacement; trace 0."""
    gamma_ang: Array
    """[n, 3, 3], 1/m² per rad, row: force component, column: rotation."""
    omega_ang: Array
    """[n, 3, 3], 1/m per rad, row: torque component, column: rotation."""


def cuboid_field(points: ArrayLike, sides: ArrayLike) -> CuboidField:
    """Field of point sources of unit mass on a homogeneous cuboid.

    Close to the body the closed edge form is used, farther out its multipole expansion, since the closed form loses
    digits as the cube of the distance. There torque, omega_lin, gamma_ang and omega_ang come from the field less its
    monopole, which contributes nothing to them and would swamp them by rounding; close to the body the two are of one
    magnitude, or the monopole is the larger (above the middle of a slab), and nothing is gained by taking it away.

    Parameters
    ----------
    points : [n, 3], positions of the sources in the frame of the cuboid [m].
    sides : [3], full edge lengths of the cuboid [m].

    Returns
    -------
    CuboidField

    Raises
    ------
    PhysicsError
        If a source is not finite, or lies inside or on the cuboid; names the index and the distance.

    Examples
    --------
    A source 25 mm from the centre of a cube of 46 mm, 2 mm above the middle of its face, and one far away, where the
    cube is a point:

    >>> from tedm_cli.gravity.kernel import cuboid_field
    >>> near_and_far = cuboid_field([[0.025, 0.0, 0.0], [10.0, 0.0, 0.0]], [0.046, 0.046, 0.046])
    >>> print("%.3f %.6f" % tuple(near_and_far.force[:, 0]))
    1119.194 0.010000
    >>> bool(abs(near_and_far.gamma_lin.trace(axis1=1, axis2=2)).max() < 1e-9)
    True
    """
    points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    sides = np.asarray(sides, dtype=np.float64)
    index = first_inside(points, sides)
    if index is not None:
        raise PhysicsError(f"source {index} at {points[index].tolist()} m {inside_fact(points[index], sides)}")
    half_sides = sides / 2.0
    position = np.ascontiguousarray(points.T)
    distance = np.sqrt((position**2).sum(axis=0))
    ratio = distance / np.sqrt((half_sides**2).sum())

    # The part of the field that exerts a torque, and the rest: the point mass at the centre where they are separate.
    force: Array = np.empty_like(position)
    gamma: Array = np.empty((6, position.shape[1]))
    point_force: Array = np.zeros_like(position)
    point_gamma: Array = np.zeros_like(gamma)
    limits = (0.0, *(lower for lower, _ in _TIERS), np.inf)
    orders = (0, *(order for _, order in _TIERS))
    for lower, upper, order in zip(limits[:-1], limits[1:], orders, strict=True):
        members = np.flatnonzero((ratio >= lower) & (ratio < upper))
        step = _BLOCK_VALUES // (order + 3)
        for start in range(0, members.size, step):
            block = members[start : start + step]
            if order:
                force[:, block], gamma[:, block] = excess_field(position[:, block], half_sides, order)
                point_force[:, block], point_gamma[:, block] = _point_field(position[:, block], distance[block])
            else:
                force[:, block], gamma[:, block] = edge_form(position[:, block], half_sides)

    torque = np.asarray(np.cross(points, force.T))
    omega_lin = _cross_matrix(force) + _cross_columns(points, _symmetric(gamma))
    gamma_ang = omega_lin.swapaxes(1, 2)
    return CuboidField(
        force=_read_only((force + point_force).T),
        gamma_lin=_read_only(_symmetric(gamma + point_gamma)),
        torque=_read_only(torque),
        omega_lin=_read_only(omega_lin),
        gamma_ang=_read_only(gamma_ang),
        omega_ang=_read_only(_cross_columns(points, gamma_ang)),
    )


def first_inside(points: Array, sides: Array) -> int | None:
    """Index of the first of `points` ([n, 3], cuboid frame) that is not strictly outside the cuboid, or None."""
    outside = (np.abs(points) > np.asarray(sides) / 2.0).any(axis=1) & np.isfinite(points).all(axis=1)
    return None if outside.all() else int(np.argmin(outside))


def inside_fact(point: Array, sides: Array) -> str:
    """What is wrong with a source that `first_inside` found, to follow its name in a message."""
    if not np.isfinite(point).all():
        return "has no finite position"
    distance = float(np.linalg.norm(point))
    return f"lies inside or on the test mass, {distance:.6g} m from its centre (edge lengths {sides.tolist()} m)"


def _point_field(position: Array, distance: Array) -> tuple[Array, Array]:
    """Force [3, n] and gradient [6, n] of a point mass at the centre."""
    direction = position / distance
    gamma = np.array([3.0 * direction[i] * direction[j] - (i == j) for i, j in _TENSOR]) / distance**3
    return direction / distance**2, gamma


def _symmetric(components: Array) -> Array:
    """[n, 3, 3] from the six components xx, yy, zz, xy, xz, yz, [6, n]."""
    tensor = np.empty((components.shape[1], 3, 3))
    for row, (i, j) in enumerate(_TENSOR):
        tensor[:, i, j] = tensor[:, j, i] = components[row]
    return tensor


def _cross_matrix(vector: Array) -> Array:
    """``[v]x`` for vectors [3, n], such that ``[v]x w = v × w``; [n, 3, 3]."""
    x, y, z = vector
    zero = np.zeros_like(x)
    return np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)


def _cross_columns(points: Array, matrix: Array) -> Array:
    """``[R]x matrix`` for points [n, 3] and matrices [n, 3, 3]."""
    return np.asarray(np.cross(points[:, None, :], matrix.swapaxes(1, 2)).swapaxes(1, 2))


def _read_only(array: Array) -> Array:
    array.flags.writeable = False
    return array
