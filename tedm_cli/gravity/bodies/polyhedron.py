"""A polyhedron bounded by triangles, as a part of a body."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.gravity.bodies.facets import Facets, facets_of
from tedm_cli.gravity.bodies.rules import tetrahedron_rule, triangle_rule

_ON_THE_SURFACE = 1e-12  # distance over the extent
_INSIDE = 1.0  # solid angle: 4π inside, 0 outside


@dataclass(frozen=True, eq=False)
class Polyhedron:
    """Solid bounded by a closed surface (see `mesh_check.checked_mesh`); a `Solid`.

    corner_m : [v, 3]; triangle : [t, 3], rows of corners, counter-clockwise seen from outside.
    """

    corner_m: FloatArray
    triangle: IntArray

    @cached_property
    def _moments(self) -> tuple[float, FloatArray, FloatArray]:
        origin = (self.low_m + self.high_m) / 2.0
        a, b, c = np.moveaxis(self.surface() - origin, 1, 0)
        six = np.einsum("ti,ti->t", a, np.cross(b, c))
        volume = float(six.sum()) / 6.0
        total = a + b + c
        first = six @ total / 24.0
        second = sum(np.einsum("t,ti,tj->ij", six, r, r) for r in (total, a, b, c)) / 120.0
        centre = first / volume
        return volume, origin + centre, np.asarray(second - volume * np.multiply.outer(centre, centre))

    @property
    def volume_m3(self) -> float:
        return self._moments[0]

    @property
    def centre_m(self) -> FloatArray:
        return self._moments[1]

    @property
    def second_m5(self) -> FloatArray:
        return self._moments[2]

    @cached_property
    def low_m(self) -> FloatArray:
        return np.asarray(self.corner_m.min(axis=0))

    @cached_property
    def high_m(self) -> FloatArray:
        return np.asarray(self.corner_m.max(axis=0))

    @cached_property
    def facets(self) -> Facets:
        return facets_of(self.corner_m, self.triangle)

    def moved(self, by: FloatArray) -> Polyhedron:
        return Polyhedron(self.corner_m + by, self.triangle)

    def near(self, points: FloatArray, field: FloatArray) -> None:
        from tedm_cli.gravity.bodies.polyhedron_form import polyhedron_form

        f = self.facets
        arguments = (f.corner, f.edge, f.along, f.anchor, f.normal, f.first, f.side, f.outward)
        polyhedron_form(points, *arguments, self.volume_m3, field)

    def contains(self, points: FloatArray) -> BoolArray:
        from tedm_cli.gravity.bodies.polyhedron_form import enclosed_angle

        margin = _ON_THE_SURFACE * float(np.ptp(self.corner_m, axis=0).max())
        inside = ((points >= self.low_m - margin) & (points <= self.high_m + margin)).all(axis=1)
        rows = np.flatnonzero(inside)
        angle = np.empty(rows.size)
        enclosed_angle(np.ascontiguousarray(points[rows]), self.surface(), angle)
        inside[rows] = (np.abs(angle) > _INSIDE) | (self._from_surface(points[rows]) <= margin)
        return np.asarray(inside)

    def distance(self, points: FloatArray) -> FloatArray:
        return np.asarray(np.where(self.contains(points), 0.0, self._from_surface(points)))

    def depth(self, points: FloatArray) -> FloatArray:
        return np.asarray(np.where(self.contains(points), self._from_surface(points), 0.0))

    def _from_surface(self, points: FloatArray) -> FloatArray:
        from tedm_cli.gravity.bodies.polyhedron_form import distance_to_surface

        distance = np.empty(len(points))
        distance_to_surface(np.ascontiguousarray(points), self.surface(), distance)
        return distance

    def reach(self, directions: FloatArray) -> FloatArray:
        return np.asarray((directions @ self.corner_m.T).max(axis=1))

    def farthest(self, point: FloatArray) -> float:
        return float(np.linalg.norm(self.corner_m - point, axis=1).max())

    def surface_rule(self, order: int) -> tuple[FloatArray, FloatArray]:
        return triangle_rule(self.surface(), order, self.farthest(self.centre_m))

    def volume_rule(self, n: int) -> tuple[FloatArray, FloatArray]:
        points, volumes = tetrahedron_rule(self.centre_m, self.surface(), n)
        return points, volumes / self.volume_m3

    def surface(self) -> FloatArray:
        return np.ascontiguousarray(self.corner_m[self.triangle])


def chamfered_cuboid(sides: FloatArray, chamfer: float) -> Polyhedron:
    """Cuboid [3] (m) about the origin, all twelve edges cut at 45°, each cut `chamfer` (m) along both faces."""
    half = np.asarray(sides) / 2.0
    corners = []
    for signs in np.ndindex(2, 2, 2):
        sign = 2.0 * np.array(signs) - 1.0
        # where each face ends, and where the three cuts of a corner meet
        corners += [sign * np.where(np.arange(3) == k, half, half - chamfer) for k in range(3)]
        corners.append(sign * (half - chamfer / 2.0))
    return convex_hull(np.array(corners))


def convex_hull(corner: FloatArray) -> Polyhedron:
    """The convex body of these corners [n, 3] (m), its triangles counter-clockwise seen from outside."""
    hull = scipy.spatial.ConvexHull(corner)
    triangle = hull.simplices.astype(np.int64)
    a, b, c = np.moveaxis(corner[triangle], 1, 0)
    turned = np.einsum("ti,ti->t", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    triangle[turned] = triangle[turned][:, ::-1]
    return Polyhedron(corner, triangle)
