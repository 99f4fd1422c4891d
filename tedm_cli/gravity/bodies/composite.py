"""A body put together of solids, less pockets cut into it, about its own centre of mass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from tedm_cli.arrays import BoolArray, ComplexArray, FloatArray
from tedm_cli.errors import PhysicsError
from tedm_cli.gravity.bodies.body import Body, inertia_over_mass
from tedm_cli.gravity.bodies.box import Box
from tedm_cli.gravity.bodies.cylinder import Cylinder
from tedm_cli.gravity.bodies.solid import Solid
from tedm_cli.gravity.kernel import BodyField, field_of_body, force_gradient_of_body

# As the tiers of the cuboid in `tedm_cli.gravity.kernel`, from nearer on: a sum over many facets loses more digits of
# the torque.
_TIERS = ((1.5, 72), (1.7, 60), (2.1, 46), (2.8, 32), (4.0, 24), (8.0, 18), (20.0, 14), (60.0, 10))
_ORDER = _TIERS[0][1]
_ROUNDING = 1e-14
_OPEN = 1e3  # a pocket goes on beyond its opening to so many radii of the body


@dataclass(frozen=True)
class Pocket:
    """What is cut out of a body: a solid inside it, and where it opens to the outside.

    solid : box or cylinder, all of it inside the solids that it is cut out of.
    open_below, open_above : [3], whether it opens at its lower and its upper face along each axis; of a cylinder the
        last is that along its own axis, and the others are not looked at.
    name : for messages.
    """

    solid: Box | Cylinder
    open_below: tuple[bool, bool, bool] = (False, False, False)
    open_above: tuple[bool, bool, bool] = (False, False, False)
    name: str = "pocket"

    def moved(self, by: FloatArray) -> Pocket:
        return Pocket(self.solid.moved(by), self.open_below, self.open_above, self.name)

    def free(self, reach: float) -> Box | Cylinder:
        """Where the body is not: the pocket, gone on beyond its openings by `reach` (m)."""
        below, above = reach * np.array(self.open_below), reach * np.array(self.open_above)
        if isinstance(self.solid, Cylinder):
            s = self.solid
            return Cylinder(s.axis, s.on_axis_m, s.radius_m, s.bottom_m - below[2], s.top_m + above[2])
        return Box(self.solid.low_m - below, self.solid.high_m + above)


class Composite(Body):
    """Homogeneous body of one or more solids that do not overlap, less pockets that do not overlap.

    Its field is the sum of the closed forms of its solids less that of its pockets, each by its volume; far away one
    expansion about the centre of mass of the whole. A point in a pocket is outside the body. Solids and pockets are
    given in the frame of the geometry, whose origin is anywhere; `centre_m` is the centre of mass in it.

    Parameters
    ----------
    solids : at least one; whether they overlap is not looked at.
    pockets : checked by `tedm_cli.gravity.bodies.pockets.check_pockets`.
    words : as `Body.words`.

    Raises
    ------
    PhysicsError : no volume is left.
    """

    def __init__(self, solids: Sequence[Solid], pockets: Sequence[Pocket] = (), *, words: str = "") -> None:
        parts: list[tuple[float, Solid]] = [(1.0, s) for s in solids] + [(-1.0, p.solid) for p in pockets]
        gross = sum(s.volume_m3 for s in solids)
        volume = sum(sign * s.volume_m3 for sign, s in parts)
        if not volume > _ROUNDING * gross:
            raise PhysicsError(f"no volume is left: {gross:.6g} m^3, less {gross - volume:.6g} m^3 of pockets")
        centre = sum((sign * s.volume_m3 * s.centre_m for sign, s in parts), np.zeros(3)) / volume
        extent = float(max(np.ptp(np.stack([s.low_m, s.high_m]), axis=0).max() for s in solids))
        # a body symmetric about its origin has its centre there
        centre[np.abs(centre) < _ROUNDING * extent] = 0.0
        second = np.zeros((3, 3))
        for sign, s in parts:
            off = s.centre_m - centre
            second += sign * (s.second_m5 + s.volume_m3 * np.multiply.outer(off, off))
        gyration = inertia_over_mass(second / volume)
        gyration[np.abs(gyration) < _ROUNDING * np.trace(gyration)] = 0.0
        self.volume_m3, self.centre_m, self.gyration_m2 = float(volume), centre, (gyration + gyration.T) / 2.0
        self.solids = [s.moved(-centre) for s in solids]
        self.pockets = [p.moved(-centre) for p in pockets]
        self.low_m = np.min([s.low_m for s in self.solids], axis=0)
        self.high_m = np.max([s.high_m for s in self.solids], axis=0)
        self.radius_m = max(s.farthest(np.zeros(3)) for s in self.solids)
        self._free = [p.free(_OPEN * self.radius_m) for p in self.pockets]
        self._words = words
        self._weights: dict[int, FloatArray] = {}

    @property
    def _parts(self) -> list[tuple[float, Solid]]:
        return [(1.0, s) for s in self.solids] + [(-1.0, p.solid) for p in self.pockets]

    def field(self, points: ArrayLike, *, threads: int = 1) -> BodyField:
        position = self.require_outside(points)
        return field_of_body(position, self.radius_m, self._near, self._far, tiers=_TIERS, threads=threads)

    def force_gradient(self, points: ArrayLike, *, threads: int = 1) -> tuple[FloatArray, FloatArray]:
        position = self.require_outside(points)
        return force_gradient_of_body(position, self.radius_m, self._near, self._far, tiers=_TIERS, threads=threads)

    def _near(self, points: FloatArray, field: FloatArray) -> None:
        parts = self._parts
        if len(parts) == 1:
            parts[0][1].near(points, field)
            return
        field[:] = 0.0
        part = np.empty_like(field)
        for sign, solid in parts:
            solid.near(points, part)
            field += (sign * solid.volume_m3 / self.volume_m3) * part

    def _far(self, points: FloatArray, order: int, field: FloatArray) -> None:
        from tedm_cli.gravity.bodies.expansion import general_field, general_weights

        if order not in self._weights:
            self._weights[order] = general_weights(self._moments[: order + 1, : order + 1])
        general_field(points, self.radius_m, self._weights[order], field)

    @cached_property
    def _moments(self) -> ComplexArray:
        from tedm_cli.gravity.bodies.expansion import body_moments

        points, weights = [], []
        for sign, solid in self._parts:
            at, area = solid.surface_rule(_ORDER + 1)
            points.append(at)
            weights.append(sign * np.einsum("qi,qi->q", at, area))
        scaled = np.concatenate(points) / self.radius_m
        return body_moments(scaled, np.concatenate(weights) / (3.0 * self.volume_m3), _ORDER)

    def contains(self, points: FloatArray) -> BoolArray:
        inside = ((points >= self.low_m) & (points <= self.high_m)).all(axis=1)
        inside &= np.einsum("ni,ni->n", points, points) <= ((1.0 + _ROUNDING) * self.radius_m) ** 2
        near = np.flatnonzero(inside)
        some = points[near]
        within = np.zeros(near.size, dtype=bool)
        for solid in self.solids:
            within |= solid.contains(some)
        for free in self._free:
            within &= ~(free.depth(some) > 0.0)
        inside[near] = within
        return np.asarray(inside)

    def distance(self, points: FloatArray) -> FloatArray:
        least = np.min([s.distance(points) for s in self.solids], axis=0)
        for free in self._free:
            least = np.maximum(least, free.depth(points))
        return np.asarray(least)

    def sources(self, n: int) -> tuple[FloatArray, FloatArray]:
        points, parts = [], []
        for sign, solid in self._parts:
            at, part = solid.volume_rule(n)
            points.append(at)
            parts.append(sign * solid.volume_m3 / self.volume_m3 * part)
        return np.concatenate(points), np.concatenate(parts)

    def surface(self) -> FloatArray:
        return np.concatenate([s.surface() if sign > 0 else s.surface()[:, ::-1] for sign, s in self._parts])

    @property
    def words(self) -> str:
        return self._words or f"{' x '.join(f'{e:g}' for e in self.extent_m)} m"
