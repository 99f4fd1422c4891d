"""The test mass: a homogeneous cuboid with its own frame."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import PhysicsError

_ORTHONORMALITY_TOLERANCE = 1e-12


@dataclass(frozen=True, kw_only=True, eq=False)
class TestMass:
    """Homogeneous cuboid test mass in its nominal position.

    Parameters
    ----------
    name : label used in row names and error messages.
    position_m : [3], centre of mass in the basic frame [m].
    side_m : [3], full edge lengths along the test mass axes [m].
    mass_kg : mass [kg].
    axes : [3, 3], rows are the unit vectors of the test mass axes in the basic frame (right-handed), so that
        ``x_tm = axes @ (x - position_m)``; the identity by default.

    Raises
    ------
    PhysicsError
        If a length or the mass is not positive and finite, or the axes are not a rotation.
    """

    # The name starts with "Test": keeps pytest from collecting it.
    __test__ = False

    name: str
    position_m: FloatArray
    side_m: FloatArray
    mass_kg: float
    axes: FloatArray = field(default_factory=lambda: np.eye(3))

    def __post_init__(self) -> None:
        for attribute, shape in (("position_m", (3,)), ("side_m", (3,)), ("axes", (3, 3))):
            array = np.array(getattr(self, attribute), dtype=np.float64)
            if array.shape != shape:
                raise ValueError(f"{attribute} of test mass {self.name!r} has shape {array.shape}, expected {shape}")
            if not np.isfinite(array).all():
                raise PhysicsError(f"{attribute} of test mass {self.name!r} is not finite: {array.tolist()}")
            array.flags.writeable = False
            object.__setattr__(self, attribute, array)
        if not (self.side_m > 0).all():
            raise PhysicsError(
                f"edge lengths of test mass {self.name!r} must be positive, got {self.side_m.tolist()} m"
            )
        if not 0 < self.mass_kg < np.inf:
            raise PhysicsError(f"mass of test mass {self.name!r} must be positive, got {self.mass_kg} kg")
        deviation = float(np.abs(self.axes @ self.axes.T - np.eye(3)).max())
        if deviation > _ORTHONORMALITY_TOLERANCE or np.linalg.det(self.axes) < 0:
            raise PhysicsError(
                f"axes of test mass {self.name!r} are not a right-handed orthonormal triad "
                f"(deviation from orthonormality {deviation:.1e}, determinant {np.linalg.det(self.axes):+.3f})"
            )

    @property
    def inertia_kg_m2(self) -> FloatArray:
        """Principal moments of inertia about the centre, [3], kg m²: ``M/12 (Ly² + Lz²)`` about x, and cyclic."""
        squares = self.side_m**2
        return np.asarray(self.mass_kg / 12.0 * (squares.sum() - squares))


def to_test_mass_frame(tm: TestMass, points: ArrayLike) -> FloatArray:
    """Coordinates of `points` ([..., 3], basic frame, m) in the frame of the test mass, [..., 3], m."""
    return np.asarray((np.asarray(points, dtype=np.float64) - tm.position_m) @ tm.axes.T)


def touch(first: TestMass, second: TestMass) -> bool:
    """Whether two test masses have a point in common, as far as rounding can tell."""
    return cuboid_gap(first.position_m, first.side_m, first.axes, second.position_m, second.side_m, second.axes) <= 0.0


def cuboid_gap(
    centre: ArrayLike, sides: ArrayLike, axes: ArrayLike, centre_2: ArrayLike, sides_2: ArrayLike, axes_2: ArrayLike
) -> float:
    """Widest gap between two cuboids in projection on an axis that could separate them [m]; positive when apart.

    Two convex polyhedra are apart if and only if they are so in projection on a face normal of one of them or on the
    cross product of an edge of each (Gottschalk, Lin and Manocha 1996). The gap is at most their distance.

    Parameters
    ----------
    centre, centre_2 : [3], m, one frame.
    sides, sides_2 : [3], full edge lengths [m].
    axes, axes_2 : [3, 3], rows are the unit vectors of the edges.
    """
    a, b = np.asarray(axes, dtype=np.float64), np.asarray(axes_2, dtype=np.float64)
    edges = np.cross(a[:, None, :], b[None, :, :]).reshape(9, 3)
    length = np.linalg.norm(edges, axis=1)
    crossed = length > 1e-9  # parallel edges give no direction
    directions = np.concatenate([a, b, edges[crossed] / length[crossed, None]])
    reach = (np.abs(directions @ a.T) @ np.asarray(sides) + np.abs(directions @ b.T) @ np.asarray(sides_2)) / 2.0
    return float((np.abs(directions @ (np.asarray(centre_2) - np.asarray(centre))) - reach).max())
