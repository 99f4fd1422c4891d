"""The cuboid and the sphere: bodies whose field has a form of its own."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.errors import PhysicsError
from tedm_cli.gravity import kernel
from tedm_cli.gravity.bodies.body import Body
from tedm_cli.gravity.bodies.rules import legendre_cube
from tedm_cli.gravity.bodies.solid import cuboid_triangles

_DRAWN = (24, 12)  # parts of a drawn sphere around and from pole to pole


class Cuboid(Body):
    """Homogeneous cuboid with full edge lengths `side_m` [3] along the axes of the test mass."""

    def __init__(self, side_m: ArrayLike) -> None:
        side = np.array(side_m, dtype=np.float64)
        if side.shape != (3,):
            raise ValueError(f"edge lengths of a cuboid have shape {side.shape}, expected (3,)")
        if not (np.isfinite(side).all() and (side > 0).all()):
            raise PhysicsError(f"edge lengths of a cuboid must be positive, got {side.tolist()} m")
        side.flags.writeable = False
        self.side_m = side
        self.volume_m3 = float(np.prod(side))
        self.centre_m = np.zeros(3)
        squares = side**2
        self.gyration_m2 = np.diag((squares.sum() - squares) / 12.0)
        self.radius_m = float(np.linalg.norm(side / 2.0))
        self.low_m, self.high_m = -side / 2.0, side / 2.0

    def inertia_kg_m2(self, mass_kg: float) -> FloatArray:
        squares = self.side_m**2
        return np.diag(mass_kg / 12.0 * (squares.sum() - squares))

    def field(self, points: ArrayLike, *, threads: int = 1) -> kernel.BodyField:
        return kernel.cuboid_field(points, self.side_m, threads=threads)

    def force_gradient(self, points: ArrayLike, *, threads: int = 1) -> tuple[FloatArray, FloatArray]:
        return kernel.cuboid_force_gradient(points, self.side_m, threads=threads)

    def contains(self, points: FloatArray) -> BoolArray:
        return np.asarray((np.abs(points) <= self.side_m / 2.0).all(axis=1))

    def first_inside(self, points: FloatArray) -> int | None:
        return kernel.first_inside(points, self.side_m)

    def distance(self, points: FloatArray) -> FloatArray:
        return np.asarray(np.linalg.norm(np.maximum(0.0, np.abs(points) - self.side_m / 2.0), axis=1))

    def sources(self, n: int) -> tuple[FloatArray, FloatArray]:
        unit, weights = legendre_cube(n)
        return unit * self.side_m / 2.0, weights

    def surface(self) -> FloatArray:
        return cuboid_triangles(self.low_m, self.high_m)

    @property
    def words(self) -> str:
        return f"edge lengths {self.side_m.tolist()} m"


class Sphere(Body):
    """Homogeneous sphere: from outside a point mass at its centre, without any torque."""

    def __init__(self, radius_m: float) -> None:
        if not 0.0 < radius_m < np.inf:
            raise PhysicsError(f"the radius of a sphere must be positive, got {radius_m} m")
        self.radius_m = radius_m
        self.volume_m3 = 4.0 / 3.0 * np.pi * radius_m**3
        self.centre_m = np.zeros(3)
        self.gyration_m2 = 0.4 * radius_m**2 * np.eye(3)
        self.low_m, self.high_m = np.full(3, -radius_m), np.full(3, radius_m)

    def field(self, points: ArrayLike, *, threads: int = 1) -> kernel.BodyField:
        return kernel.field_of_body(self.require_outside(points), 1e-300, _nothing, _no_excess, threads=threads)

    def force_gradient(self, points: ArrayLike, *, threads: int = 1) -> tuple[FloatArray, FloatArray]:
        position = self.require_outside(points)
        return kernel.force_gradient_of_body(position, 1e-300, _nothing, _no_excess, threads=threads)

    def contains(self, points: FloatArray) -> BoolArray:
        return np.asarray(np.linalg.norm(points, axis=1) <= self.radius_m)

    def distance(self, points: FloatArray) -> FloatArray:
        return np.asarray(np.maximum(np.linalg.norm(points, axis=1) - self.radius_m, 0.0))

    def sources(self, n: int) -> tuple[FloatArray, FloatArray]:
        return np.zeros((1, 3)), np.ones(1)

    def surface(self) -> FloatArray:
        around, down = _DRAWN
        angle = 2.0 * np.pi * np.arange(around + 1) / around
        polar = np.pi * np.arange(down + 1) / down
        ring = np.stack(
            [np.outer(np.sin(polar), np.cos(angle)), np.outer(np.sin(polar), np.sin(angle)),
             np.outer(np.cos(polar), np.ones_like(angle))], axis=-1,
        ) * self.radius_m  # fmt: skip
        a, b, c, d = ring[:-1, :-1], ring[1:, :-1], ring[1:, 1:], ring[:-1, 1:]
        upper, lower = np.stack([a, b, c], axis=-2)[:-1], np.stack([a, c, d], axis=-2)[1:]
        return np.concatenate([upper.reshape(-1, 3, 3), lower.reshape(-1, 3, 3)])

    @property
    def words(self) -> str:
        return f"radius {self.radius_m:g} m"


def _nothing(position: FloatArray, field: FloatArray) -> None:
    """Never asked: the sphere is a point from its surface on."""


def _no_excess(position: FloatArray, order: int, field: FloatArray) -> None:
    field[:] = 0.0
