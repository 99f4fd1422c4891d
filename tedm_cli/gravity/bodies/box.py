"""A cuboid with edges along the axes of the body, as a part of it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.gravity.bodies.rules import cube_rule, triangle_rule
from tedm_cli.gravity.bodies.solid import cuboid_triangles


@dataclass(frozen=True, eq=False)
class Box:
    """Cuboid between the coordinates `low_m` and `high_m` [3]; a `Solid`.

    Two boxes of a body with a face in one plane share the number of that plane: a point in it then sees both alike.
    """

    low_m: FloatArray
    high_m: FloatArray

    @cached_property
    def volume_m3(self) -> float:
        return float(np.prod(self.high_m - self.low_m))

    @cached_property
    def centre_m(self) -> FloatArray:
        return (self.low_m + self.high_m) / 2.0

    @cached_property
    def second_m5(self) -> FloatArray:
        return np.diag(self.volume_m3 * (self.high_m - self.low_m) ** 2 / 12.0)

    def moved(self, by: FloatArray) -> Box:
        return Box(self.low_m + by, self.high_m + by)

    def near(self, points: FloatArray, field: FloatArray) -> None:
        from tedm_cli.gravity.edge_form import edge_form

        edge_form(points, self.low_m, self.high_m, field)

    def contains(self, points: FloatArray) -> BoolArray:
        return np.asarray(((points >= self.low_m) & (points <= self.high_m)).all(axis=1))

    def distance(self, points: FloatArray) -> FloatArray:
        out = np.maximum(np.maximum(self.low_m - points, points - self.high_m), 0.0)
        return np.asarray(np.linalg.norm(out, axis=1))

    def depth(self, points: FloatArray) -> FloatArray:
        return np.asarray(np.minimum(points - self.low_m, self.high_m - points).min(axis=1))

    def reach(self, directions: FloatArray) -> FloatArray:
        return np.asarray(np.maximum(directions * self.low_m, directions * self.high_m).sum(axis=1))

    def farthest(self, point: FloatArray) -> float:
        return float(np.linalg.norm(np.maximum(np.abs(self.low_m - point), np.abs(self.high_m - point))))

    def surface_rule(self, order: int) -> tuple[FloatArray, FloatArray]:
        return triangle_rule(self.surface(), order, self.farthest(self.centre_m))

    def volume_rule(self, n: int) -> tuple[FloatArray, FloatArray]:
        unit, weight = cube_rule(n)
        return self.low_m + unit * (self.high_m - self.low_m), weight

    def surface(self) -> FloatArray:
        return cuboid_triangles(self.low_m, self.high_m)
