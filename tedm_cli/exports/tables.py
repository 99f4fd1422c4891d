"""The matrices of each kind of file, small enough to be looked at; displacements of all grids stay where they are."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping

from tedm_cli.contracts import DISTORTION, OPTICS, SENSITIVITY, FileKind
from tedm_cli.files.store import Reader
from tedm_cli.matrix_files.named import NamedMatrix
from tedm_cli.results.areas import per_area, read_areas
from tedm_cli.results.gravity.field import read_linearised
from tedm_cli.results.gravity.self_gravity import read_self_gravity
from tedm_cli.results.optics import read_bench_motion

_MOTIONS = {"ux": "m", "uy": "m", "uz": "m", "rx": "rad", "ry": "rad", "rz": "rad"}
_MOTIONS_ARE = 'frame = "layout"\ntest_mass_axes = "frame"\nrotations = "small_angle"\n'
_OUTPUTS = 'slopes = "angle"\nbeams = { meas = "meas", ref = "ref" }\n'


def optics_matrices(file: Reader) -> list[NamedMatrix]:
    """S_BW, P, O_ideal, D, and N of every set; S_BW and P can be imported again."""
    rays, ray_units = file.strings(OPTICS.LABEL_RAY_OUTPUT), file.strings(OPTICS.LABEL_RAY_OUTPUT_UNIT)
    laser, laser_units = file.strings(OPTICS.LABEL_LASER_OUTPUT), file.strings(OPTICS.LABEL_LASER_OUTPUT_UNIT)
    read, read_units = file.strings(OPTICS.LABEL_READ_OUT), file.strings(OPTICS.LABEL_READ_OUT_UNIT)
    motions, masses = file.strings(OPTICS.LABEL_ELEMENT_DOF), file.strings(OPTICS.LABEL_TEST_MASS_DOF)
    table = read_areas(file)
    areas, per = table.name.tolist(), per_area(table)
    points = "\n".join(
        f"{json.dumps(name)} = {json.dumps(point.tolist())}"
        for name, point in zip(file.strings(OPTICS.ELEMENT_NAME), file.array(OPTICS.ELEMENT_PIVOT), strict=True)
    )
    return [
        NamedMatrix(
            "S_BW",
            file.array(OPTICS.S_BW),
            rays,
            motions,
            ray_units,
            _units(motions),
            f"photodiode outputs by element motion, layout frame, about the grids ({file.string(OPTICS.ORIGIN_S_BW)})",
            f"{_MOTIONS_ARE}{_OUTPUTS}\n[reference_points]\n{points}\n",
        ),
        NamedMatrix(
            "P",
            file.array(OPTICS.P),
            laser,
            rays,
            laser_units,
            ray_units,
            f"optics law: laser read-out by photodiode outputs ({file.string(OPTICS.ORIGIN_P)})",
            _OUTPUTS,
        ),
        NamedMatrix(
            "O_ideal",
            file.array(OPTICS.O_IDEAL),
            laser,
            masses,
            laser_units,
            _units(masses),
            "laser read-out by test mass motion, frames of the test masses",
        ),
        NamedMatrix(
            "D",
            file.array(OPTICS.D),
            laser,
            areas,
            laser_units,
            table.unit,
            f"laser read-out {per}",
        ),
        *(
            NamedMatrix(
                f"N_{_identifier(name)}",
                file.array(OPTICS.N.of(name)),
                read,
                areas,
                read_units,
                table.unit,
                f"read-out {per}, photodiodes of set {name}",
            )
            for name in file.strings(OPTICS.SET_NAME)
        ),
    ]


def sensitivity_matrices(file: Reader) -> list[NamedMatrix]:
    """S_SG, and the linearised equations of motion."""
    table, gravity, motion = read_areas(file), read_self_gravity(file), read_linearised(file)
    return [
        NamedMatrix(
            "S_SG",
            gravity.S,
            gravity.label,
            table.name.tolist(),
            [unit.removesuffix("/K") for unit in gravity.unit],
            table.unit,
            f"self-gravity on the test masses {per_area(table)}, frames of the test masses",
        ),
        NamedMatrix(
            "stiffness",
            motion.value,
            motion.output,
            motion.motion,
            motion.output_unit,
            motion.motion_unit,
            "force over mass and torque over inertia by motion of the test masses, in their frames",
        ),
    ]


def distortion_matrices(file: Reader) -> list[NamedMatrix]:
    """D_opt: the optical elements' part of the distortion matrix; nothing, where there are none."""
    table = read_areas(file)
    bench = read_bench_motion(file)
    if not bench.element:
        return []
    labels = [f"{name}_{motion}" for name in bench.element for motion in _MOTIONS]
    return [
        NamedMatrix(
            "D_opt",
            bench.motion.reshape(len(table), -1).T,
            labels,
            table.name.tolist(),
            _units(labels),
            table.unit,
            f"motion of the grids of the optical elements {per_area(table)}, basic frame",
        )
    ]


#: Kind of file to what of it goes out.
TABLES: Mapping[str, tuple[FileKind, Callable[[Reader], list[NamedMatrix]]]] = {
    "optics": (OPTICS, optics_matrices),
    "sensitivity": (SENSITIVITY, sensitivity_matrices),
    "distortion": (DISTORTION, distortion_matrices),
}


def _units(labels: list[str]) -> list[str]:
    return [_MOTIONS[label.rpartition("_")[2]] for label in labels]


def _identifier(name: str) -> str:
    """A name that MATLAB takes."""
    return re.sub(r"\W", "_", name)
