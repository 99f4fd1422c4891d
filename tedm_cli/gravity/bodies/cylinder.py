"""A circular cylinder, as a part of a body."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.gravity.bodies.rules import gauss

_DRAWN_SIDES = 64


@dataclass(frozen=True, eq=False)
class Cylinder:
    """Solid cylinder; a `Solid`.

    axis : [3], unit vector. on_axis_m : [3], a point of its axis. radius_m : radius.
    bottom_m, top_m : coordinates of the caps along the axis, from the origin; a cap in the plane of another solid's
    face has the number of that plane.
    """

    axis: FloatArray
    on_axis_m: FloatArray
    radius_m: float
    bottom_m: float
    top_m: float

    @cached_property
    def axes(self) -> FloatArray:
        """[3, 3], rows are unit vectors; the last is the axis."""
        least = np.eye(3)[int(np.abs(self.axis).argmin())]
        first = np.cross(self.axis, least)
        first /= np.linalg.norm(first)
        return np.stack([first, np.cross(self.axis, first), self.axis])

    @cached_property
    def volume_m3(self) -> float:
        return float(np.pi * self.radius_m**2 * (self.top_m - self.bottom_m))

    @cached_property
    def centre_m(self) -> FloatArray:
        return self.on_axis_m + self.axis * ((self.bottom_m + self.top_m) / 2.0 - self.on_axis_m @ self.axis)

    @cached_property
    def second_m5(self) -> FloatArray:
        along = (self.top_m - self.bottom_m) ** 2 / 12.0
        across = self.radius_m**2 / 4.0
        return self.volume_m3 * (across * np.eye(3) + (along - across) * np.outer(self.axis, self.axis))

    @cached_property
    def low_m(self) -> FloatArray:
        return -self.reach(-np.eye(3))

    @cached_property
    def high_m(self) -> FloatArray:
        return self.reach(np.eye(3))

    def moved(self, by: FloatArray) -> Cylinder:
        along = float(by @ self.axis)
        return Cylinder(self.axis, self.on_axis_m + by, self.radius_m, self.bottom_m + along, self.top_m + along)

    def near(self, points: FloatArray, field: FloatArray) -> None:
        from tedm_cli.gravity.bodies.cylinder_form import GAUSS, cylinder_form

        cylinder_form(points, self.axes, self.on_axis_m, self.radius_m, self.bottom_m, self.top_m, GAUSS, field)

    def off(self, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """How far points are beyond the lateral surface, the bottom and the top [n]; negative inside."""
        u, v, _ = ((points - self.on_axis_m) @ self.axes.T).T
        z = points @ self.axis
        return np.hypot(u, v) - self.radius_m, self.bottom_m - z, z - self.top_m

    def contains(self, points: FloatArray) -> BoolArray:
        return np.asarray(np.max(self.off(points), axis=0) <= 0.0)

    def distance(self, points: FloatArray) -> FloatArray:
        side, below, above = self.off(points)
        return np.asarray(np.hypot(np.maximum(side, 0.0), np.maximum(np.maximum(below, above), 0.0)))

    def depth(self, points: FloatArray) -> FloatArray:
        return np.asarray(-np.max(self.off(points), axis=0))

    def reach(self, directions: FloatArray) -> FloatArray:
        along = directions @ self.axis
        across = np.sqrt(np.maximum((directions**2).sum(axis=1) - along**2, 0.0))
        across[across < 1e-15] = 0.0
        foot = directions @ (self.on_axis_m - self.axis * (self.on_axis_m @ self.axis))
        return np.asarray(foot + np.maximum(along * self.bottom_m, along * self.top_m) + self.radius_m * across)

    def farthest(self, point: FloatArray) -> float:
        off = self.axes @ (point - self.on_axis_m)
        z = float(point @ self.axis)
        return float(
            np.hypot(np.hypot(off[0], off[1]) + self.radius_m, max(abs(z - self.bottom_m), abs(z - self.top_m)))
        )

    def surface_rule(self, order: int) -> tuple[FloatArray, FloatArray]:
        turns, n = order + 2, order // 2 + 1
        angle = 2.0 * np.pi * np.arange(turns) / turns
        round_ = np.stack([np.cos(angle), np.sin(angle)], axis=1) @ self.axes[:2]
        foot = self.on_axis_m - self.axis * (self.on_axis_m @ self.axis)
        t, w = gauss(n, 0)
        height = self.bottom_m + t * (self.top_m - self.bottom_m)
        side = foot + height[:, None, None] * self.axis + self.radius_m * round_[None]
        side_area = (w * (self.top_m - self.bottom_m))[:, None, None] * (round_ * self.radius_m * 2.0 * np.pi / turns)
        r, wr = gauss(order // 2 + 2, 0)
        disk = foot + self.radius_m * r[:, None, None] * round_[None]
        area = np.repeat(r * wr * self.radius_m**2 * 2.0 * np.pi / turns, turns)
        points = [side.reshape(-1, 3), *((disk + z * self.axis).reshape(-1, 3) for z in (self.bottom_m, self.top_m))]
        areas = [side_area.reshape(-1, 3), -area[:, None] * self.axis, area[:, None] * self.axis]
        return np.concatenate(points), np.concatenate(areas)

    def volume_rule(self, n: int) -> tuple[FloatArray, FloatArray]:
        turns = 2 * n
        angle = 2.0 * np.pi * (np.arange(turns) + 0.5) / turns
        (t, w), (s, ws) = gauss(n, 0), gauss(n, 0)
        radius = self.radius_m * np.sqrt(s)  # even powers of it are all that is left after the turn
        foot = self.on_axis_m - self.axis * (self.on_axis_m @ self.axis)
        flat = np.stack([np.cos(angle), np.sin(angle)], axis=1) @ self.axes[:2]
        height = self.bottom_m + t * (self.top_m - self.bottom_m)
        points = foot + height[:, None, None, None] * self.axis + radius[None, :, None, None] * flat[None, None]
        weight = w[:, None, None] * ws[None, :, None] * np.full(turns, 1.0 / turns)
        return points.reshape(-1, 3), weight.ravel()

    def surface(self) -> FloatArray:
        angle = 2.0 * np.pi * np.arange(_DRAWN_SIDES) / _DRAWN_SIDES
        foot = self.on_axis_m - self.axis * (self.on_axis_m @ self.axis)
        rim = foot + self.radius_m * np.stack([np.cos(angle), np.sin(angle)], axis=1) @ self.axes[:2]
        a, b = (rim + z * self.axis for z in (self.bottom_m, self.top_m))
        c, d = np.roll(a, -1, axis=0), np.roll(b, -1, axis=0)
        down, up = (np.broadcast_to(foot + z * self.axis, a.shape) for z in (self.bottom_m, self.top_m))
        faces = [(a, c, d), (a, d, b), (down, c, a), (up, b, d)]
        return np.concatenate([np.stack(f, axis=1) for f in faces])
