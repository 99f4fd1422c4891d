"""The test mass: a homogeneous body with its own frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import PhysicsError
from tedm_cli.gravity.bodies.body import Body
from tedm_cli.gravity.bodies.cuboid import Cuboid
from tedm_cli.inertia import divided_by_inertia

_ORTHONORMALITY_TOLERANCE = 1e-12


class TestMass:
    """Homogeneous test mass in its nominal position.

    Its frame has its origin at the centre of mass of the body, wherever the geometry that describes it has its own.

    Parameters
    ----------
    name : label used in row names and error messages.
    position_m : [3], centre of mass in the basic frame [m].
    mass_kg : mass [kg].
    side_m : [3], full edge lengths along the test mass axes of a test mass that is a cuboid [m]; or
    body : its shape, in the frame of the test mass.
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
    mass_kg: float
    body: Body
    axes: FloatArray

    def __init__(
        self,
        *,
        name: str,
        position_m: ArrayLike,
        mass_kg: float,
        side_m: ArrayLike | None = None,
        body: Body | None = None,
        axes: ArrayLike | None = None,
    ) -> None:
        self.name, self.mass_kg = name, mass_kg
        self.position_m = self._array("position_m", position_m, (3,))
        self.axes = self._array("axes", np.eye(3) if axes is None else axes, (3, 3))
        if not 0 < mass_kg < np.inf:
            raise PhysicsError(f"mass of test mass {name!r} must be positive, got {mass_kg} kg")
        deviation = float(np.abs(self.axes @ self.axes.T - np.eye(3)).max())
        if deviation > _ORTHONORMALITY_TOLERANCE or np.linalg.det(self.axes) < 0:
            raise PhysicsError(
                f"axes of test mass {name!r} are not a right-handed orthonormal triad "
                f"(deviation from orthonormality {deviation:.1e}, determinant {np.linalg.det(self.axes):+.3f})"
            )
        if body is not None and side_m is None:
            self.body = body
        elif side_m is not None and body is None:
            self.body = Cuboid(self._array("side_m", side_m, (3,)))
        else:
            raise ValueError(f"test mass {name!r} needs either side_m or body")

    def _array(self, attribute: str, values: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
        array = np.array(values, dtype=np.float64)
        if array.shape != shape:
            raise ValueError(f"{attribute} of test mass {self.name!r} has shape {array.shape}, expected {shape}")
        if not np.isfinite(array).all():
            raise PhysicsError(f"{attribute} of test mass {self.name!r} is not finite: {array.tolist()}")
        if attribute == "side_m" and not (array > 0).all():
            raise PhysicsError(f"edge lengths of test mass {self.name!r} must be positive, got {array.tolist()} m")
        array.flags.writeable = False
        return array

    @property
    def side_m(self) -> FloatArray:
        """[3], full edge lengths along its axes of the cuboid that holds it [m], about `box_centre_m`."""
        return self.body.extent_m

    @property
    def box_centre_m(self) -> FloatArray:
        """[3], centre of the cuboid that holds it, in the basic frame [m]; of a cuboid its own."""
        return np.asarray(self.position_m + (self.body.low_m + self.body.high_m) / 2.0 @ self.axes)

    def surface(self) -> FloatArray:
        """[t, 3, 3], corners of triangles that draw it, in the basic frame [m]."""
        return np.asarray(self.position_m + self.body.surface() @ self.axes)

    @property
    def inertia_kg_m2(self) -> FloatArray:
        """Tensor of inertia about the centre of mass along its axes, [3, 3], kg m²."""
        return self.body.inertia_kg_m2(self.mass_kg)

    def per_inertia(self, torque: FloatArray, axis: int = -1) -> FloatArray:
        """``(I/M)⁻¹ T``: angular acceleration times mass by torque, whose components run along `axis`; unit 1/m²."""
        return divided_by_inertia(self.inertia_kg_m2 / self.mass_kg, torque, axis)


def to_test_mass_frame(tm: TestMass, points: ArrayLike) -> FloatArray:
    """Coordinates of `points` ([..., 3], basic frame, m) in the frame of the test mass, [..., 3], m."""
    return np.asarray((np.asarray(points, dtype=np.float64) - tm.position_m) @ tm.axes.T)


def touch(first: TestMass, second: TestMass) -> bool:
    """Whether the cuboids that hold two test masses have a point in common, as far as rounding can tell."""
    gap = cuboid_gap(first.box_centre_m, first.side_m, first.axes, second.box_centre_m, second.side_m, second.axes)
    return gap <= 0.0


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
