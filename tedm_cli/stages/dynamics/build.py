"""build-dynamics: equations of motion, controller, poles and margins of the drag-free loop."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.config.project import Project
from tedm_cli.contracts import DYNAMICS as KIND
from tedm_cli.dynamics.closed_loop import loop_transfer
from tedm_cli.dynamics.controller import ScalarLoops
from tedm_cli.dynamics.in_time import thermal_columns
from tedm_cli.dynamics.own_controller import StateSpaceController
from tedm_cli.dynamics.signals import COORDINATES, DISTURBANCES, INPUTS, OUTPUTS, index, unit
from tedm_cli.dynamics.sources import columns
from tedm_cli.dynamics.stability import Stability, stability
from tedm_cli.dynamics.state_space import SYSTEM_INPUT_UNITS, SYSTEM_INPUTS, loop_system
from tedm_cli.errors import TedmError
from tedm_cli.files.build_folder import DYNAMICS_FILE, OPTICS_FILE, SENSITIVITY_FILE, provenance
from tedm_cli.files.store import Writer, create
from tedm_cli.stages.common import out_path
from tedm_cli.stages.dynamics.loop import Loop, project_loop
from tedm_cli.stages.dynamics.thermal import ThermalRows, own_effects, thermal_rows

_MIXED = "SI, by the units of rows and columns in /label"
_OF_SYSTEM = "SI, by the units of rows and columns in /system"
_OPEN_LOOP_HZ = (1e-6, 5.0)
_OPEN_LOOP_POINTS = 601


@dataclass(frozen=True, eq=False)
class DynamicsSummary:
    """The file, the loop it holds, and its stability."""

    path: Path
    loop: Loop
    stability: Stability


def build_dynamics(project: Project, output: Path | None) -> DynamicsSummary:
    """Assemble the loop, refuse it when it is unstable, write dynamics.h5."""
    loop = project_loop(project)
    try:
        found = stability(loop.plant, loop.controller)
    except TedmError as error:
        error.where = error.where or loop.where
        raise
    rows = thermal_rows(project, loop.config.read_out.set)
    out = out_path(project, DYNAMICS_FILE, output)
    inputs = [
        project.build_dir / SENSITIVITY_FILE,
        project.build_dir / OPTICS_FILE,
        *loop.tables,
        *own_effects(project),
    ]
    with create(out, KIND, provenance([loop.file] if loop.file else [], inputs)) as writer:
        _write_bodies(writer, loop)
        _write_controller(writer, loop)
        _write_stability(writer, loop, found)
        _write_noise(writer, loop)
        _write_thermal(writer, rows)
        _write_system(writer, loop)
    return DynamicsSummary(out, loop, found)


def _write_bodies(writer: Writer, loop: Loop) -> None:
    plant = loop.plant
    writer.write(KIND.LABEL_COORDINATE, list(COORDINATES))
    writer.write(KIND.LABEL_COORDINATE_UNIT, [unit(name) for name in COORDINATES])
    writer.write(KIND.LABEL_INPUT, list(INPUTS))
    writer.write(KIND.LABEL_INPUT_UNIT, [unit(name) for name in INPUTS])
    writer.write(KIND.LABEL_BODY_COORDINATE, ["SC_x", "SC_y", "SC_z", *COORDINATES])
    writer.write(KIND.LABEL_TM_MOTION, list(COORDINATES[3:]))
    writer.write(KIND.SPACECRAFT_MASS, plant.spacecraft.mass_kg)
    writer.write(KIND.SPACECRAFT_INERTIA, plant.spacecraft.inertia_kg_m2)
    writer.write(KIND.SPACECRAFT_CENTRE_OF_MASS, plant.spacecraft.centre_of_mass_m)
    writer.write(KIND.TEST_MASS_NAME, list(loop.names))
    for dataset, key in (
        (KIND.TEST_MASS_MASS, "mass_kg"),
        (KIND.TEST_MASS_INERTIA, "inertia_kg_m2"),
        (KIND.TEST_MASS_POSITION, "position_m"),
        (KIND.TEST_MASS_AXES, "axes"),
    ):
        writer.write(dataset, np.array([getattr(tm, key) for tm in plant.test_masses]))
    writer.write(KIND.STIFFNESS_SOURCE, list(loop.source_names))
    writer.write(KIND.STIFFNESS_BY_SOURCE, loop.by_source, units="1/s^2 and SI with m, rad")
    writer.write(KIND.STIFFNESS_MUTUAL, plant.mutual, units="1/s^2 and SI with m, rad")
    for dataset, matrix in zip((KIND.MATRIX_M, KIND.MATRIX_K, KIND.MATRIX_U), plant.eighteen(), strict=True):
        writer.write(dataset, matrix, units=_MIXED)
    writer.write(KIND.MATRIX_E, plant.E, units=_MIXED)
    writer.write(KIND.MATRIX_K_P, plant.K, units=_MIXED)
    writer.write(KIND.TEST_MASS_AT_REST, loop.at_rest, units="m/s^2 (a), rad/s^2 (omegadot)")


def _write_controller(writer: Writer, loop: Loop) -> None:
    controller = loop.controller
    system = controller.state_space()
    own = controller if isinstance(controller, StateSpaceController) else None
    writer.write(KIND.CONTROLLER_ORIGIN, loop.config.controller.file or "default loops of the science mode")
    writer.write(KIND.CONTROLLER_PERIOD, 0.0 if own is None or own.dt_s is None else own.dt_s)
    writer.write(KIND.CONTROLLER_DELAY, 0.0 if own is None or own.dt_s is None else own.delay_s)
    writer.write(KIND.CONTROLLER_A, system.a, units=_MIXED)
    writer.write(KIND.CONTROLLER_B, system.b, units=_MIXED)
    writer.write(KIND.CONTROLLER_C, -system.c, units=_MIXED)
    writer.write(KIND.CONTROLLER_D, -system.d, units=_MIXED)
    if isinstance(controller, ScalarLoops):
        writer.write(KIND.MATRIX_ACTUATION, controller.actuation, units=_MIXED)


def _write_stability(writer: Writer, loop: Loop, found: Stability) -> None:
    writer.write(KIND.LOOP_NAME, list(loop.controller.loops))
    for dataset, key in (
        (KIND.LOOP_CROSSOVER, "crossover_hz"),
        (KIND.LOOP_PHASE_MARGIN, "phase_deg"),
        (KIND.LOOP_GAIN_MARGIN, "gain_db"),
        (KIND.LOOP_GAIN_REDUCTION, "reduction_db"),
        (KIND.LOOP_PEAK_SENSITIVITY, "peak_sensitivity"),
    ):
        writer.write(dataset, [getattr(m, key) for m in found.margins])
    f = np.geomspace(*_OPEN_LOOP_HZ, _OPEN_LOOP_POINTS)
    if isinstance(loop.controller, StateSpaceController) and loop.controller.dt_s is not None:
        f = f[f <= 0.5 / loop.controller.dt_s]
    transfer = loop_transfer(loop.plant, loop.controller, f)
    open_loop = (transfer / (1.0 - transfer)).T
    writer.write(KIND.LOOP_FREQUENCY, f)
    writer.write(KIND.LOOP_OPEN_REAL, np.ascontiguousarray(open_loop.real))
    writer.write(KIND.LOOP_OPEN_IMAGINARY, np.ascontiguousarray(open_loop.imag))
    order = np.lexsort((found.poles.imag, found.poles.real))[::-1]
    writer.write(KIND.POLE_REAL, found.poles.real[order])
    writer.write(KIND.POLE_IMAGINARY, found.poles.imag[order])


def _write_noise(writer: Writer, loop: Loop) -> None:
    writer.write(KIND.LABEL_DISTURBANCE, list(DISTURBANCES))
    writer.write(KIND.LABEL_DISTURBANCE_UNIT, [unit(name) for name in DISTURBANCES])
    writer.write(KIND.NOISE_NAME, [s.name for s in loop.sources])
    writer.write(KIND.NOISE_GROUP, [s.group for s in loop.sources])
    writer.write(KIND.NOISE_SPECTRUM, [s.spectrum.words() for s in loop.sources])
    writer.write(KIND.NOISE_ORIGIN, [s.origin for s in loop.sources])
    writer.write(KIND.NOISE_GAIN, columns(loop.sources), units=_MIXED)


def _write_thermal(writer: Writer, rows: ThermalRows) -> None:
    writer.write(KIND.READ_OUT_SET, rows.set_name)
    writer.write(KIND.THERMAL_AREA, list(rows.areas.name))
    writer.write(KIND.THERMAL_UNIT, rows.areas.unit)
    writer.write(KIND.THERMAL_V, thermal_columns(rows.acceleration, rows.read_out), units=_MIXED)


def _write_system(writer: Writer, loop: Loop) -> None:
    """The closed loop as one system; a sampled controller has none that is continuous."""
    if isinstance(loop.controller, StateSpaceController) and loop.controller.dt_s is not None:
        return
    whole = loop_system(loop.plant, loop.controller)
    names, units = whole.states
    outputs = loop.plant.outputs
    rows = index(OUTPUTS, *outputs)
    writer.write(KIND.SYSTEM_STATE, names)
    writer.write(KIND.SYSTEM_STATE_UNIT, units)
    writer.write(KIND.SYSTEM_INPUT, list(SYSTEM_INPUTS))
    writer.write(KIND.SYSTEM_INPUT_UNIT, list(SYSTEM_INPUT_UNITS))
    writer.write(KIND.SYSTEM_OUTPUT, list(outputs))
    writer.write(KIND.SYSTEM_OUTPUT_UNIT, [unit(name) for name in outputs])
    for dataset, matrix in zip(
        (KIND.SYSTEM_A, KIND.SYSTEM_B, KIND.SYSTEM_C, KIND.SYSTEM_D),
        (whole.system.a, whole.system.b, whole.system.c[rows], whole.system.d[rows]),
        strict=True,
    ):
        writer.write(dataset, matrix, units=_OF_SYSTEM)
