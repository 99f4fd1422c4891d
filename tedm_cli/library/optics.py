"""The ray trace of an optical layout with its elements where one wants them."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from tedm_cli.arrays import FloatArray
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.contracts.spec import MOTIONS
from tedm_cli.errors import InputError, UsageError
from tedm_cli.library.project import Project
from tedm_cli.library.xarray_door import dataset, variable
from tedm_cli.optics import trace as tracing
from tedm_cli.optics.labels import laser_labels
from tedm_cli.optics.law import law_matrix
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.stages.common import known_name

if TYPE_CHECKING:
    import xarray as xr

_RAY = {"x": "m", "y": "m", "opl": "m", "z1": "rad", "z2": "rad"}

Motion = Mapping[str, Mapping[str, float] | ArrayLike]


def trace(
    layout: OpticalLayout | Project | str | PathLike[str], motion: Motion | xr.DataArray | None = None
) -> xr.Dataset:
    """Trace all beams of an optical layout, with elements displaced.

    Parameters
    ----------
    layout : of a `Project`, the project itself, or the path of a layout file (`optics.toml`).
    motion : by element, its motion: six numbers, or some of `ux uy uz` (m) and `rx ry rz` (rad) by name, along and
        about the axes of the layout, rotations about the element's reference point; finite, not linearised. Or a
        DataArray (element, motion) with names along both. Elements that are not named stay where they are.

    Returns
    -------
    Dataset of, along `path` (`PD1A meas`) and `ray`: `ray_output`, where the beam arrives on its photodiode: `x`,
    `y`, its optical path `opl` (m), its slopes `z1`, `z2` (rad); `ray_change` against the undisturbed layout. Along
    `laser_output` (`PD1A_OPD`, unit in `laser_output_unit`): `laser_change`, by the optics law, of what the
    photodiodes report.

    Raises
    ------
    InputError, ConfigError : the layout file is missing or wrong; a motion that is not six finite numbers; a layout
        without geometry, whose S_BW is imported.
    UsageError : an element or a motion that there is not; the nearest is named.
    PhysicsError : a beam misses an element; path, step and element are named.

    Examples
    --------
    >>> moved = tedm.trace(project, {"TM1": {"ux": 1e-6}})  # doctest: +SKIP
    >>> moved.laser_change.sel(laser_output="PD1A_OPD")  # doctest: +SKIP
    """
    known = _layout(layout)
    if not known.has_geometry:
        raise InputError("the layout has no geometry, its S_BW is imported: there is nothing to trace", where="layout")
    poses = tracing.nominal_poses(known)
    nominal = np.asarray(tracing.trace(known, poses), dtype=np.float64)
    output = np.asarray(tracing.trace(known, poses.moved(_motions(known, motion))), dtype=np.float64)
    change = output - nominal
    laser = laser_labels(known)
    units = {"ray_unit": (("ray",), list(_RAY.values())), "laser_output_unit": (("laser_output",), list(laser.units))}
    return dataset(
        {
            "ray_output": variable(("path", "ray"), output, "see ray_unit", "arrival of the beam on its photodiode"),
            "ray_change": variable(("path", "ray"), change, "see ray_unit", "its change by the motion"),
            "laser_change": variable(
                ("laser_output",),
                law_matrix(known) @ change.ravel(),
                "see laser_output_unit",
                "change of the optical path difference and the wave-front tilts that the photodiodes report",
            ),
        },
        {
            "path": [path.label for path in known.paths],
            "ray": list(_RAY),
            "laser_output": list(laser.names),
            **units,
        },
        {"title": known.title},
    )


def _layout(given: OpticalLayout | Project | str | PathLike[str]) -> OpticalLayout:
    if isinstance(given, OpticalLayout):
        return given
    return given.layout if isinstance(given, Project) else load_layout(Path(given), needs_grids=False)[1]


def _motions(layout: OpticalLayout, given: Motion | xr.DataArray | None) -> FloatArray:
    """Motions [n_elements, 6] of all elements."""
    motions = np.zeros((len(layout.elements), len(MOTIONS)))
    names = [element.name for element in layout.elements]
    for name, of_one in _by_element(given).items():
        row = motions[layout.index(known_name("optical element", name, names))]
        if isinstance(of_one, Mapping):
            for key, value in of_one.items():
                row[MOTIONS.index(known_name("motion", str(key), MOTIONS))] = _finite(value, name, ())
        else:
            row[:] = _finite(of_one, name, (len(MOTIONS),))
    return motions


def _by_element(given: Motion | xr.DataArray | None) -> Motion:
    if given is None or isinstance(given, Mapping):
        return given or {}
    if set(getattr(given, "dims", ())) != {"element", "motion"} or {"element", "motion"} - set(given.coords):
        raise UsageError("a motion is a mapping of elements, or a DataArray with names along element and motion")
    table = given.transpose("element", "motion")
    keys = [str(key) for key in table["motion"].values.tolist()]
    rows = zip(table["element"].values.tolist(), table.values.tolist(), strict=True)
    return {str(name): dict(zip(keys, row, strict=True)) for name, row in rows}


def _finite(value: object, name: str, shape: tuple[int, ...]) -> FloatArray:
    try:
        found = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"the motion of {name} is {value!r}, which are no numbers", where="motion") from None
    if found.shape != shape or not np.isfinite(found).all():
        wanted = f"{len(MOTIONS)} finite numbers" if shape else "a finite number"
        raise InputError(f"of the motion of {name}: {found.tolist()}, wanted {wanted}", where="motion")
    return found
