"""The three bodies of a drag-free satellite: mass, inertia, places and frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import PhysicsError
from tedm_cli.inertia import divided_by_inertia
from tedm_cli.parallel_axes import PARALLEL_RAD, apart_rad

_SYMMETRY = 1e-12  # of the inertia, relative
_ORTHONORMALITY = 1e-12


@dataclass(frozen=True, eq=False)
class Spacecraft:
    """The spacecraft without its test masses.

    Parameters
    ----------
    mass_kg : m_B.
    inertia_kg_m2 : I_B [3, 3] about its centre of mass, basic frame.
    centre_of_mass_m : [3], basic frame.

    Raises
    ------
    PhysicsError : a mass that is not positive, or an inertia that no body has: asymmetric, indefinite, or with one
        principal moment larger than the sum of the others.
    """

    mass_kg: float
    inertia_kg_m2: FloatArray
    centre_of_mass_m: FloatArray

    def __post_init__(self) -> None:
        if not 0.0 < self.mass_kg < np.inf:
            raise PhysicsError(f"the mass of the spacecraft must be positive, got {self.mass_kg:g} kg")
        check_inertia(self.inertia_kg_m2)


@dataclass(frozen=True, eq=False)
class DynamicTestMass:
    """A test mass as a rigid body: mass, centre of mass [3] and axes [3, 3] (rows), basic frame.

    `inertia_kg_m2`: [3, 3] about the centre of mass, along the axes; or principal moments [3], which become that. The
    axes are those of its housing as well: H_i, in which its motion is measured.
    """

    name: str
    mass_kg: float
    inertia_kg_m2: FloatArray
    position_m: FloatArray
    axes: FloatArray

    def __post_init__(self) -> None:
        if not 0.0 < self.mass_kg < np.inf:
            raise PhysicsError(f"the mass of {self.name} must be positive, got {self.mass_kg:g} kg")
        inertia = np.asarray(self.inertia_kg_m2, dtype=np.float64)
        object.__setattr__(self, "inertia_kg_m2", np.diag(inertia) if inertia.ndim == 1 else inertia)
        check_inertia(self.inertia_kg_m2, f"the inertia of {self.name}")
        if np.abs(self.axes @ self.axes.T - np.eye(3)).max() > _ORTHONORMALITY or np.linalg.det(self.axes) < 0.0:
            raise PhysicsError(f"the axes of {self.name} are not a right-handed orthonormal triad")

    @property
    def to_basic(self) -> FloatArray:
        """C_i = T_BH [3, 3]: components in the test mass's frame to components in the basic frame."""
        return self.axes.T

    @property
    def generalised_mass(self) -> FloatArray:
        """J_i [6, 6]: the mass for three translations, the inertia for the rotations."""
        return _blocks(self.mass_kg * np.eye(3), self.inertia_kg_m2)

    @property
    def inverse_mass(self) -> FloatArray:
        """J_i⁻¹ [6, 6]."""
        return _blocks(np.eye(3) / self.mass_kg, divided_by_inertia(self.inertia_kg_m2, np.eye(3), 0))


def _blocks(first: FloatArray, second: FloatArray) -> FloatArray:
    return np.block([[first, np.zeros((3, 3))], [np.zeros((3, 3)), second]])


def check_inertia(inertia: FloatArray, whose: str = "the inertia of the spacecraft") -> None:
    """`PhysicsError` for an inertia [3, 3] (kg m²) that no rigid body has."""
    if not np.isfinite(inertia).all():
        raise PhysicsError(f"{whose} is not finite")
    size = float(np.abs(inertia).max())
    worst = float(np.abs(inertia - inertia.T).max())
    if worst > _SYMMETRY * size:
        raise PhysicsError(
            f"{whose} is not symmetric: entries differ by {worst:g} kg m^2",
            hint="products of inertia stand twice, with the same sign",
        )
    moments = np.linalg.eigvalsh(inertia)
    if moments[0] <= 0.0:
        raise PhysicsError(f"{whose} has a principal moment of {moments[0]:g} kg m^2; all must be positive")
    if moments[2] > (moments[0] + moments[1]) * (1.0 + 1e-9):
        raise PhysicsError(
            f"{whose} has principal moments {', '.join(f'{m:g}' for m in moments)} kg m^2: the largest exceeds the sum"
            " of the others, which no body has"
        )


def cross_matrix(vector: FloatArray) -> FloatArray:
    """``[v]x`` with ``[v]x w = v × w``."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def x_axes_apart_rad(axes: FloatArray) -> float:
    """Angle between the x axes of two test masses with `axes` [2, 3, 3] (rows), from 0 to π."""
    return apart_rad(axes[0, 0], axes[1, 0])


def x_axes_are_parallel(axes: FloatArray) -> bool:
    """Whether both test masses are measured along one direction, so that a difference along x means something."""
    return x_axes_apart_rad(axes) <= PARALLEL_RAD


def angle_words(axes: FloatArray) -> str:
    """The angle between the x axes, to be printed."""
    return f"{np.degrees(x_axes_apart_rad(axes)):.4g}°"
