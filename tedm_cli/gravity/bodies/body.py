"""The shape of a test mass: what gravity asks of it, whatever it is."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import ArrayLike

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.errors import PhysicsError
from tedm_cli.gravity.kernel import BodyField, as_points


class Body(ABC):
    """A homogeneous body; coordinates [m] are about its centre of mass.

    volume_m3 : volume.
    centre_m : [3], its centre of mass in the frame that its geometry was given in.
    gyration_m2 : [3, 3], tensor of inertia about the centre of mass over the mass, ``∫ (r² 1 - r rᵀ) dV / V``.
    radius_m : of a sphere about the centre of mass that holds it.
    low_m, high_m : [3], the cuboid that holds it.
    """

    volume_m3: float
    centre_m: FloatArray
    gyration_m2: FloatArray
    radius_m: float
    low_m: FloatArray
    high_m: FloatArray

    @abstractmethod
    def field(self, points: ArrayLike, *, threads: int = 1) -> BodyField:
        """The six quantities of point sources at `points` [n, 3], per unit G M m (`tedm_cli.gravity.kernel`).

        Raises
        ------
        PhysicsError : a source is not finite, or inside or on the body; names its index.
        """

    @abstractmethod
    def force_gradient(self, points: ArrayLike, *, threads: int = 1) -> tuple[FloatArray, FloatArray]:
        """Force [n, 3] and gamma_lin [n, 3, 3] alone, at a lower cost."""

    @abstractmethod
    def contains(self, points: FloatArray) -> BoolArray:
        """Whether each of finite points [n, 3] is inside or on the body, [n]."""

    def first_inside(self, points: FloatArray) -> int | None:
        """Index of the first of `points` [n, 3] that is not finite or not strictly outside the body, or None."""
        inside = ~np.isfinite(points).all(axis=1)
        finite = np.flatnonzero(~inside)
        inside[finite] = self.contains(points[finite])
        return int(np.argmax(inside)) if inside.any() else None

    @abstractmethod
    def distance(self, points: FloatArray) -> FloatArray:
        """Lower bound of the distance of points [n, 3] from the body, 0 inside it, [n]; exact of convex bodies."""

    @abstractmethod
    def sources(self, n: int) -> tuple[FloatArray, FloatArray]:
        """Points [q, 3] and parts [q] of the mass that stand for the body as a source, for n points per axis."""

    @abstractmethod
    def surface(self) -> FloatArray:
        """[t, 3, 3], triangles for drawings."""

    @property
    @abstractmethod
    def words(self) -> str:
        """What the body is, in a few words with its sizes, for messages."""

    @property
    def extent_m(self) -> FloatArray:
        """[3], edge lengths of the cuboid that holds it; of a cuboid its own."""
        return self.high_m - self.low_m

    def inertia_kg_m2(self, mass_kg: float) -> FloatArray:
        """Tensor of inertia about the centre of mass, [3, 3], for a mass [kg]."""
        return mass_kg * self.gyration_m2

    def inside_fact(self, point: FloatArray) -> str:
        """What is wrong with a source that `first_inside` found, to follow its name in a message."""
        if not np.isfinite(point).all():
            return "has no finite position"
        return f"lies inside or on the test mass, {np.linalg.norm(point):.6g} m from its centre ({self.words})"

    def require_outside(self, points: ArrayLike) -> FloatArray:
        """`points` as [n, 3], or `PhysicsError` for the first that is not strictly outside."""
        position = as_points(points)
        index = self.first_inside(position)
        if index is not None:
            fact = self.inside_fact(position[index])
            raise PhysicsError(f"source {index} at {position[index].tolist()} m {fact}")
        return position


def inertia_over_mass(second: FloatArray) -> FloatArray:
    """``∫ (r² 1 - r rᵀ)`` from ``∫ r rᵀ``, both [3, 3]."""
    return np.asarray(np.trace(second) * np.eye(3) - second)
