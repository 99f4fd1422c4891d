"""Self-gravity of point sources on cuboid test masses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.gravity import field, kernel
from tedm_cli.gravity.constants import G_CODATA_2018
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.library.xarray_door import dataset, variable
from tedm_cli.stages.gravity.self_gravity import FIELD_UNITS

if TYPE_CHECKING:
    import xarray as xr

_XYZ = ["x", "y", "z"]
_TM_FRAME = "nominal frame of the test mass (origin at its centre, axes along its edges)"
_WORDS = {
    "acceleration": "acceleration of the test mass, force over mass",
    "angular_acceleration": "angular acceleration of the test mass, torque over moment of inertia",
    "gamma_lin": "acceleration by translation of the test mass",
    "omega_lin": "angular acceleration by translation of the test mass",
    "gamma_ang": "acceleration by rotation of the test mass",
    "omega_ang": "angular acceleration by rotation of the test mass",
}
_PER_UNIT = {
    "force": ("1/m^2", "force over G M m"),
    "gamma_lin": ("1/m^3", "change of the force by translation of the cuboid, over G M m"),
    "torque": ("1/m", "torque about the centre over G M m"),
    "omega_lin": ("1/m^2", "change of the torque by translation of the cuboid, over G M m"),
    "gamma_ang": ("1/(m^2 rad)", "change of the force by rotation of the cuboid, over G M m"),
    "omega_ang": ("1/(m rad)", "change of the torque by rotation of the cuboid, over G M m"),
}


def cuboid_field(points_m: ArrayLike, side_m: ArrayLike) -> xr.Dataset:
    """Field of point sources on a homogeneous cuboid by the exact kernel, per unit G M m.

    Its signs are those of "Method and conventions" in the documentation.

    Parameters
    ----------
    points_m : [n, 3], or [3] of one source: positions in the frame of the cuboid, m.
    side_m : [3], or one number of a cube: full edge lengths, m.

    Returns
    -------
    Dataset with dimensions `point`, `xyz` and, of derivatives, `xyz_column`: `force`, `gamma_lin`, `torque`,
    `omega_lin`, `gamma_ang`, `omega_ang`; `position` (point, xyz) are the sources. Frame of the cuboid. Times G, the
    mass of the cuboid and that of the source they are N, N/m, N m and so on.

    Raises
    ------
    InputError : arrays of another shape, or edges that are not positive.
    PhysicsError : a source is not finite, or inside or on the cuboid.

    Examples
    --------
    >>> import tedm
    >>> above = tedm.cuboid_field([0.025, 0.0, 0.0], 0.046)
    >>> print(f"{float(above.force.sel(point=0, xyz='x')):.3f} 1/m^2")
    1119.194 1/m^2
    """
    points = _points(points_m)
    sides = _numbers(side_m, "side_m")
    sides = np.full(3, float(sides)) if sides.ndim == 0 else sides
    if sides.shape != (3,) or not (np.isfinite(sides) & (sides > 0)).all():
        raise InputError(f"is {sides.tolist()}, wanted three positive lengths, or one", where="side_m")
    found = kernel.cuboid_field(points, sides)
    variables = {"position": variable(("point", "xyz"), points, "m", "position of the source", "frame of the cuboid")}
    for name, (units, words) in _PER_UNIT.items():
        values = np.array(getattr(found, name))
        dims = ("point", "xyz", "xyz_column")[: values.ndim]
        variables[name] = variable(dims, values, units, words, "frame of the cuboid")
    return dataset(variables, {"point": np.arange(len(points)), "xyz": _XYZ, "xyz_column": _XYZ}, {"side_m": sides})


def self_gravity(
    points_m: ArrayLike,
    masses_kg: ArrayLike,
    test_masses: TestMass | Sequence[TestMass],
    *,
    per_source: bool = False,
    G: float = G_CODATA_2018,
) -> xr.Dataset:
    """Field of point sources on test masses, as `tedm self-gravity` has it.

    Parameters
    ----------
    points_m : [n, 3], positions of the sources, m, basic frame.
    masses_kg : [n], kg.
    test_masses : one or several, such as `Project.test_masses`; `tedm.TestMass` makes one.
    per_source : with a dimension `point` first, what each source contributes.
    G : gravitational constant, m³ kg⁻¹ s⁻²; the one of `model.toml` is not known here.

    Returns
    -------
    Dataset with dimensions `test_mass`, `xyz` and, of stiffnesses, `xyz_column` (the motion): `acceleration`, m/s²;
    `angular_acceleration`, rad/s²; `gamma_lin`, 1/s²; `omega_lin`, 1/(m s²); `gamma_ang`, m/(s² rad); `omega_ang`,
    1/(s² rad). Each in the frame of its test mass.

    Raises
    ------
    InputError : arrays of another shape, or no test mass.
    PhysicsError : a source with mass is not finite, or inside or on a test mass; both are named.
    """
    points, masses = _points(points_m), _numbers(masses_kg, "masses_kg").reshape(-1)
    if masses.shape != (len(points),) or not np.isfinite(masses).all():
        raise InputError(f"are {masses.size} numbers, wanted {len(points)} finite ones", where="masses_kg")
    bodies = [test_masses] if isinstance(test_masses, TestMass) else list(test_masses)
    names = [tm.name for tm in bodies]
    if not bodies or len(set(names)) < len(names):
        raise InputError(f"{names or 'none'}, wanted test masses of different names", where="test_masses")
    summed = field.self_gravity_by_source if per_source else field.self_gravity
    fields = [summed(points, masses, tm, G=G) for tm in bodies]
    variables = {}
    for name, (units, _) in FIELD_UNITS.items():
        values = np.stack([getattr(one, name) for one in fields], axis=1 if per_source else 0)
        dims = ("point",) * per_source + ("test_mass", "xyz", "xyz_column")[: values.ndim - per_source]
        variables[name] = variable(dims, values, units, _WORDS[name], _TM_FRAME)
    coordinates: dict[str, object] = {"test_mass": names, "xyz": _XYZ, "xyz_column": _XYZ}
    if per_source:
        coordinates["point"] = np.arange(len(points))
    return dataset(variables, coordinates, {"G": G})


def _points(points_m: ArrayLike) -> FloatArray:
    points = _numbers(points_m, "points_m")
    if points.ndim == 1 and points.size:
        points = points[None]
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError(f"have shape {points.shape}, wanted [n, 3]", where="points_m")
    return points


def _numbers(values: ArrayLike, where: str) -> FloatArray:
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as exc:
        raise InputError(f"is no array of numbers ({exc})", where=where) from None
