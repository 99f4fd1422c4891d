"""The symmetry plane of a structure: it divides its thermal areas into sides, and maps them to their mirror images."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray

_ROUNDING = 1e-12  # m along the normal, and of the normal itself


@dataclass(frozen=True, eq=False)
class SymmetryPlane:
    """A plane in the basic frame.

    Parameters
    ----------
    point_m : [3], any point of it.
    normal : [3], towards the side that is called +y; made a unit vector here.
    """

    point_m: FloatArray
    normal: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "point_m", np.array(self.point_m, dtype=np.float64))
        length = float(np.linalg.norm(self.normal))
        # What is a unit vector but for rounding stays as it is, so that the basic axes stay exact.
        scale = length if abs(length - 1.0) > _ROUNDING and length > 0.0 else 1.0
        object.__setattr__(self, "normal", np.array(self.normal, dtype=np.float64) / scale)

    def distance(self, position_m: FloatArray) -> FloatArray:
        """Distance of points [..., 3] (m, basic frame) from the plane [...], positive on the side of its normal."""
        return np.asarray((position_m - self.point_m) @ self.normal)

    def image(self, position_m: FloatArray) -> FloatArray:
        """Mirror images [..., 3] of points [..., 3], m, basic frame."""
        return np.asarray(position_m - 2.0 * self.distance(position_m)[..., None] * self.normal)

    def is_same(self, other: SymmetryPlane) -> bool:
        """Whether both are one plane with one normal; which of its points they are given by does not matter."""
        off = abs(float(self.distance(other.point_m)))
        return off <= _ROUNDING and float(np.abs(self.normal - other.normal).max()) <= _ROUNDING

    @property
    def words(self) -> str:
        """`y = 0`, or the plane by its point and normal."""
        for name, axis in zip("xyz", np.eye(3), strict=True):
            if np.abs(self.normal - axis).max() <= _ROUNDING:
                at = float(self.point_m @ axis)
                return f"{name} = {at:.6g} m" if abs(at) > _ROUNDING else f"{name} = 0"
        return f"the plane through {_shown(self.point_m)} m with the normal {_shown(self.normal)}"

    @property
    def key(self) -> str:
        """The same four numbers for the same plane: its normal, and its distance from the origin in m."""
        numbers = [*self.normal, self.point_m @ self.normal]
        return " ".join(f"{round(float(v), 12) + 0.0:.12g}" for v in numbers)


def _shown(vector: FloatArray) -> str:
    return "(" + ", ".join(f"{round(float(v), 9) + 0.0:.6g}" for v in vector) + ")"


BASIC_PLANE = SymmetryPlane(np.zeros(3), np.array([0.0, 1.0, 0.0]))
