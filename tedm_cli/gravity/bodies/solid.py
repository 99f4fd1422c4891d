"""A homogeneous solid in the frame of the body that it is part of, or that it is taken away from."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray


class Solid(Protocol):
    """What a body is put together of. Coordinates [m] are in the frame of the body, from an origin of its own.

    volume_m3 : volume.
    centre_m : [3], centre of mass.
    second_m5 : [3, 3], ``∫ (r - c)(r - c)ᵀ dV`` about the centre of mass c.
    low_m, high_m : [3], the cuboid that holds it.
    """

    @property
    def volume_m3(self) -> float: ...
    @property
    def centre_m(self) -> FloatArray: ...
    @property
    def second_m5(self) -> FloatArray: ...
    @property
    def low_m(self) -> FloatArray: ...
    @property
    def high_m(self) -> FloatArray: ...

    def moved(self, by: FloatArray) -> Solid:
        """The same solid moved by [3], m."""

    def near(self, points: FloatArray, field: FloatArray) -> None:
        """Write the mean of the attraction towards each point, and its gradient: closed form, [n, 9]."""

    def contains(self, points: FloatArray) -> BoolArray:
        """Whether each of finite points [n, 3] is inside or on the solid, [n]."""

    def distance(self, points: FloatArray) -> FloatArray:
        """Distance of points from the solid, 0 inside, [n]."""

    def depth(self, points: FloatArray) -> FloatArray:
        """Distance of points inside from the surface, at most 0 outside, [n]."""

    def reach(self, directions: FloatArray) -> FloatArray:
        """Largest coordinate of the solid along unit vectors [d, 3], [d]."""

    def farthest(self, point: FloatArray) -> float:
        """Radius about a point of a sphere that holds the solid [m]."""

    def surface_rule(self, order: int) -> tuple[FloatArray, FloatArray]:
        """Points [q, 3] on the surface and vectors n dA [q, 3] that integrate polynomials of degree `order` exactly."""

    def volume_rule(self, n: int) -> tuple[FloatArray, FloatArray]:
        """Points [q, 3] and parts [q] of the volume, adding up to 1, exact for polynomials of degree 2n - 1.

        Of a polyhedron parts may be negative and points outside it, but not outside its convex hull.
        """

    def surface(self) -> FloatArray:
        """[t, 3, 3], triangles for drawings, seen from outside counter-clockwise."""


def cuboid_triangles(low: FloatArray, high: FloatArray) -> FloatArray:
    """Twelve triangles [12, 3, 3] of a cuboid, counter-clockwise seen from outside."""
    corner, triangle = cuboid_mesh(low, high)
    return corner[triangle]


def cuboid_mesh(low: FloatArray, high: FloatArray) -> tuple[FloatArray, IntArray]:
    """Corners [8, 3] and triangles [12, 3] of a cuboid."""
    corner = np.array([[(low, high)[(i >> k) & 1][k] for k in range(3)] for i in range(8)])
    quads = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    return corner, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], dtype=np.int64)
