"""The other test mass as a source: a homogeneous body replaced by quadrature points."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import PhysicsError
from tedm_cli.gravity.constants import G_CODATA_2018
from tedm_cli.gravity.field import SelfGravity, self_gravity
from tedm_cli.gravity.testmass import TestMass, touch

_POINTS_PER_AXIS = 8


def body_sources(tm: TestMass, n: int = _POINTS_PER_AXIS) -> tuple[FloatArray, FloatArray]:
    """Point masses equivalent to a test mass by product quadrature over its body.

    Parameters
    ----------
    tm : the test mass acting as a source.
    n : quadrature points per axis (of each solid and pocket, each tetrahedron of a polyhedron); moments up to degree
        2n - 1 in each coordinate are exact.

    Returns
    -------
    points : [q, 3], basic frame [m]; n³ of a cuboid, one of a sphere.
    masses : [q], kg, summing to the mass of `tm`; negative in pockets.
    """
    local, parts = tm.body.sources(n)
    return tm.position_m + local @ tm.axes, tm.mass_kg * parts


def field_of_other_test_mass(
    tm: TestMass, other: TestMass, G: float = G_CODATA_2018, *, n: int = _POINTS_PER_AXIS
) -> tuple[SelfGravity, float]:
    """Self-gravity of one test mass on another (Montemurro 2004, section 6.2).

    Parameters
    ----------
    tm : the test mass acted upon.
    other : the test mass acting as a source.
    G : gravitational constant [m³ kg⁻¹ s⁻²].
    n : quadrature points per axis over `other`.

    Returns
    -------
    gravity : SelfGravity, in the frame of `tm`.
    error : largest difference from the quadrature with ``n - 2`` points per axis, relative to the largest element of
        each quantity; the angular acceleration, which vanishes by symmetry for aligned test masses, is judged
        against the larger of itself and omega_ang (per radian). An upper bound where the quadrature converges.

    Raises
    ------
    PhysicsError
        If the test masses overlap or touch; names both.
    """
    if n < 3:
        raise ValueError(f"the error estimate needs at least 3 points per axis, got {n}")
    if touch(tm, other):
        raise PhysicsError(
            f"test masses {tm.name!r} and {other.name!r} overlap or touch: their centres are "
            f"{np.linalg.norm(other.position_m - tm.position_m):.6g} m apart",
            hint="correct position_m, size or axes of one of them",
        )
    fine, coarse = (self_gravity(*body_sources(other, order), tm, G=G) for order in (n, n - 2))
    differences = quantity_differences(fine, coarse).values()
    error = max((difference / scale for difference, scale in differences if difference > 0.0), default=0.0)
    return fine, error


def quantity_differences(fine: SelfGravity, coarse: SelfGravity) -> dict[str, tuple[float, float]]:
    """Largest difference between two quadratures, and the magnitude to judge it against, of each quantity by name.

    The magnitude is the largest element; that of the angular acceleration, which vanishes by symmetry for aligned
    bodies, is the larger of its own and that of omega_ang (per radian).
    """
    differences = {}
    for quantity in fields(SelfGravity):
        value = getattr(fine, quantity.name)
        scale = float(np.abs(value).max())
        if quantity.name == "angular_acceleration":
            scale = max(scale, float(np.abs(fine.omega_ang).max()))
        differences[quantity.name] = (float(np.abs(value - getattr(coarse, quantity.name)).max()), scale)
    return differences
