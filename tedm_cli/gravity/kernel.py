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

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tedm_cli.arrays import FloatArray, IndexArray
from tedm_cli.errors import PhysicsError
from tedm_cli.gravity.moments import field_weights

# Distance of the source over half the body diagonal from which the expansion replaces the edge form, and the degree of
# the expansion from there on. For the torque and its gradients the truncation of the field without its monopole stays
# below 1e-13, for cubes, slabs and rods alike; for force and gradient, which have the monopole, below 1e-14.
_TORQUE_TIERS = ((1.7, 64), (2.1, 48), (2.8, 32), (4.0, 24), (8.0, 18), (20.0, 14), (60.0, 10))
_FORCE_TIERS = (
    *((2.4, 36), (3.0, 28), (3.5, 24), (4.5, 20), (6.5, 16)),
    *((9.0, 14), (12.0, 12), (18.0, 10), (35.0, 8)),
)
# Long enough that threads seldom meet at the interpreter.
_BLOCK_POINTS = 1 << 12

Tiers = tuple[tuple[float, int], ...]
Near = Callable[[FloatArray, FloatArray], None]
Far = Callable[[FloatArray, int, FloatArray], None]
_Part = Callable[[FloatArray, FloatArray, bool, IndexArray], None]


@dataclass(frozen=True, eq=False)
class BodyField:
    """Field of n point sources on a homogeneous body, per unit G M m, in its frame (read-only arrays)."""

    force: FloatArray
    """[n, 3], 1/m²."""
    gamma_lin: FloatArray
    """[n, 3, 3], 1/m³, symmetric, trace 0."""
    torque: FloatArray
    """[n, 3], 1/m."""
    omega_lin: FloatArray
    """[n, 3, 3], 1/m², row: torque component, column: displacement; trace 0."""
    gamma_ang: FloatArray
    """[n, 3, 3], 1/m² per rad, row: force component, column: rotation."""
    omega_ang: FloatArray
    """[n, 3, 3], 1/m per rad, row: torque component, column: rotation."""


def cuboid_field(points: ArrayLike, sides: ArrayLike, *, threads: int = 1) -> BodyField:
    """Field of point sources of unit mass on a homogeneous cuboid.

    Close to the body the closed edge form is used, farther out its multipole expansion, since the closed form loses
    digits as the cube of the distance. There torque, omega_lin, gamma_ang and omega_ang come from the field less its
    monopole, which contributes nothing to them and would swamp them by rounding; close to the body the two are of one
    magnitude, or the monopole is the larger (above the middle of a slab), and nothing is gained by taking it away.

    Parameters
    ----------
    points : [n, 3], positions of the sources in the frame of the cuboid [m].
    sides : [3], full edge lengths of the cuboid [m].
    threads : number of threads. The results do not depend on it, to the bit. One by default: a model of 1e5 sources
        takes a tenth of a second, and Make runs stages, and pytest tests, side by side.

    Returns
    -------
    BodyField

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
    require_outside(points := as_points(points), sides := np.asarray(sides, dtype=np.float64))
    return field_of_body(points, *_cuboid(sides), threads=threads)


def cuboid_force_gradient(points: ArrayLike, sides: ArrayLike, *, threads: int = 1) -> tuple[FloatArray, FloatArray]:
    """Force and gamma_lin alone, at a lower cost than `cuboid_field`; parameters and errors as there.

    Returns
    -------
    force : [n, 3], 1/m².
    gamma_lin : [n, 3, 3], 1/m³, symmetric, trace 0.
    """
    require_outside(points := as_points(points), sides := np.asarray(sides, dtype=np.float64))
    return force_gradient_of_body(points, *_cuboid(sides), threads=threads)


def as_points(points: ArrayLike) -> FloatArray:
    """[n, 3], as the kernels take them."""
    return np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3)


def _cuboid(sides: FloatArray) -> tuple[float, Near, Far]:
    half_sides = sides / 2.0
    scale = float(np.sqrt((half_sides**2).sum()))

    def near(position: FloatArray, field: FloatArray) -> None:
        # The compiled kernels are loaded here: importing the compiler takes longer than all the rest of the room.
        from tedm_cli.gravity.edge_form import edge_form

        edge_form(position, -half_sides, half_sides, field)

    def far(position: FloatArray, order: int, field: FloatArray) -> None:
        from tedm_cli.gravity.multipole import excess_field

        excess_field(position, scale, field_weights(*half_sides.tolist(), order), field)

    return scale, near, far


def field_of_body(
    points: FloatArray, radius: float, near: Near, far: Far, *, tiers: Tiers = _TORQUE_TIERS, threads: int = 1
) -> BodyField:
    """The six quantities of a homogeneous body, from its closed form nearby and its expansion farther out.

    Parameters
    ----------
    points : [n, 3], outside the body, about its centre of mass [m].
    radius : of a sphere about the centre of mass that holds the body [m].
    near : (points [k, 3], field [k, 9]); writes force along x, y, z and gradient xx, yy, zz, xy, xz, yz.
    far : (points [k, 3], degree, field [k, 9]); the same less those of a point mass, by an expansion up to a degree.
    tiers : distances over the radius from which the expansion to a degree is used, and the degrees.
    threads : as of `cuboid_field`.
    """
    from tedm_cli.gravity.assembly import put_force_gradient, put_torque

    n = points.shape[0]
    force, torque = np.empty((n, 3)), np.empty((n, 3))
    gamma_lin, omega_lin, omega_ang = np.empty((n, 3, 3)), np.empty((n, 3, 3)), np.empty((n, 3, 3))

    def put(position: FloatArray, field: FloatArray, separate: bool, rows: IndexArray) -> None:
        put_force_gradient(position, field, separate, rows, force, gamma_lin)
        put_torque(position, field, rows, torque, omega_lin, omega_ang)

    _evaluate(points, radius, near, far, tiers, put, threads)
    for array in (force, gamma_lin, torque, omega_lin, omega_ang):
        array.flags.writeable = False
    return BodyField(force, gamma_lin, torque, omega_lin, omega_lin.swapaxes(1, 2), omega_ang)


def force_gradient_of_body(
    points: FloatArray, radius: float, near: Near, far: Far, *, tiers: Tiers = _FORCE_TIERS, threads: int = 1
) -> tuple[FloatArray, FloatArray]:
    """Force [n, 3] and gamma_lin [n, 3, 3] alone; parameters as of `field_of_body`."""
    from tedm_cli.gravity.assembly import put_force_gradient

    force, gamma_lin = np.empty_like(points), np.empty((points.shape[0], 3, 3))

    def put(position: FloatArray, field: FloatArray, separate: bool, rows: IndexArray) -> None:
        put_force_gradient(position, field, separate, rows, force, gamma_lin)

    _evaluate(points, radius, near, far, tiers, put, threads)
    return force, gamma_lin


def _evaluate(points: FloatArray, radius: float, near: Near, far: Far, tiers: Tiers, put: _Part, threads: int) -> None:
    """Pass blocks of points, and their field as far as it exerts a torque, to `put`.

    Blocks are cut alike for any number of threads, and every point is computed by itself.
    """
    ratio = np.sqrt(np.einsum("ni,ni->n", points, points)) / radius
    tier = np.zeros(ratio.size, dtype=np.uint8)
    for lower, _ in tiers:
        tier += ratio >= lower
    members = np.split(
        np.argsort(tier, kind="stable"), np.cumsum(np.bincount(tier, minlength=len(tiers)))[: len(tiers)]
    )

    def work(block: tuple[int, IndexArray]) -> None:
        order, rows = block
        position = np.take(points, rows, axis=0)
        field = np.empty((rows.size, 9))
        if order:
            far(position, order, field)
        else:
            near(position, field)
        put(position, field, order > 0, rows)

    orders = (0, *(order for _, order in tiers))
    blocks = [
        (order, rows[start : start + _BLOCK_POINTS])
        for order, rows in zip(orders, members, strict=True)
        for start in range(0, rows.size, _BLOCK_POINTS)
    ]
    if threads == 1:
        for block in blocks:
            work(block)
        return
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(work, blocks))


def require_outside(points: FloatArray, sides: FloatArray) -> None:
    """`PhysicsError` for the first of `points` that is inside or on the cuboid; names its index and the distance."""
    index = first_inside(points, sides)
    if index is not None:
        raise PhysicsError(f"source {index} at {points[index].tolist()} m {inside_fact(points[index], sides)}")


def first_inside(points: FloatArray, sides: FloatArray) -> int | None:
    """Index of the first of `points` ([n, 3], cuboid frame) that is not strictly outside the cuboid, or None."""
    x, y, z = np.abs(points).T
    hx, hy, hz = np.asarray(sides) / 2.0
    outside = ((x > hx) | (y > hy) | (z > hz)) & np.isfinite(x) & np.isfinite(y) & np.isfinite(z)
    return None if outside.all() else int(np.argmin(outside))


def inside_fact(point: FloatArray, sides: FloatArray) -> str:
    """What is wrong with a source that `first_inside` found, to follow its name in a message."""
    if not np.isfinite(point).all():
        return "has no finite position"
    distance = float(np.linalg.norm(point))
    return f"lies inside or on the test mass, {distance:.6g} m from its centre (edge lengths {sides.tolist()} m)"
