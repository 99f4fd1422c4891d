"""build-dynamics: equations of motion, controller, poles and margins of the drag-free loop."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.config.project import Project
from tedm_cli.contracts import DYNAMICS as KIND
from tedm_cli.dynamics.closed_loop import loop_transfer
from tedm_cli.dynamics.controller import ScalarLoops
from tedm_cli.dynamics.own_controller import StateSpaceController
from tedm_cli.dynamics.signals import COORDINATES, DISTURBANCES, INPUTS, unit
from tedm_cli.dynamics.sources import columns
from tedm_cli.dynamics.stability import Stability, stability
from tedm_cli.errors import TedmError
from tedm_cli.files.build_folder import DYNAMICS, OPTICS, SENSITIVITY, provenance
from tedm_cli.files.store import Writer, create
from tedm_cli.stages.common import out_path
from tedm_cli.stages.dynamics.loop import Loop, project_loop
from tedm_cli.stages.dynamics.thermal import read_out_set

_MIXED = "SI, by the units of rows and columns in /label"
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
    heard = read_out_set(project, loop.config.read_out.set)
    out = out_path(project, DYNAMICS, output)
    inputs = [project.build_dir / SENSITIVITY, project.build_dir / OPTICS, *loop.tables]
    with create(out, KIND, provenance([loop.file] if loop.file else [], inputs)) as writer:
        _write_bodies(writer, loop)
        _write_controller(writer, loop)
        _write_stability(writer, loop, found)
        _write_noise(writer, loop)
        writer.write("/read_out/set", heard)
    return DynamicsSummary(out, loop, found)


def _write_bodies(writer: Writer, loop: Loop) -> None:
    plant = loop.plant
    writer.write("/label/coordinate", list(COORDINATES))
    writer.write("/label/coordinate_unit", [unit(name) for name in COORDINATES])
    writer.write("/label/input", list(INPUTS))
    writer.write("/label/input_unit", [unit(name) for name in INPUTS])
    writer.write("/label/body_coordinate", ["SC_x", "SC_y", "SC_z", *COORDINATES])
    writer.write("/label/tm_motion", list(COORDINATES[3:]))
    writer.write("/spacecraft/mass", plant.spacecraft.mass_kg)
    writer.write("/spacecraft/inertia", plant.spacecraft.inertia_kg_m2)
    writer.write("/spacecraft/centre_of_mass", plant.spacecraft.centre_of_mass_m)
    writer.write("/test_mass/name", list(loop.names))
    for name in ("mass", "inertia", "position", "axes"):
        key = {"mass": "mass_kg", "inertia": "inertia_kg_m2", "position": "position_m", "axes": "axes"}[name]
        writer.write(f"/test_mass/{name}", np.array([getattr(tm, key) for tm in plant.test_masses]))
    writer.write("/stiffness/source", list(loop.source_names))
    writer.write("/stiffness/by_source", loop.by_source, units="1/s^2 and SI with m, rad")
    writer.write("/stiffness/mutual", plant.mutual, units="1/s^2 and SI with m, rad")
    for name, matrix in zip("MKU", plant.eighteen(), strict=True):
        writer.write(f"/{name}", matrix, units=_MIXED)
    writer.write("/E", plant.E, units=_MIXED)
    writer.write("/K_p", plant.K, units=_MIXED)
    writer.write("/at_rest", loop.at_rest, units="m/s^2 (a), rad/s^2 (omegadot)")


def _write_controller(writer: Writer, loop: Loop) -> None:
    controller = loop.controller
    system = controller.state_space()
    own = controller if isinstance(controller, StateSpaceController) else None
    writer.write("/controller/origin", loop.config.controller.file or "default loops of the science mode")
    writer.write("/controller/period", 0.0 if own is None or own.dt_s is None else own.dt_s)
    writer.write("/controller/delay", 0.0 if own is None or own.dt_s is None else own.delay_s)
    for name, matrix in (("A", system.a), ("B", system.b), ("C", -system.c), ("D", -system.d)):
        writer.write(f"/controller/{name}", matrix, units=_MIXED)
    if isinstance(controller, ScalarLoops):
        writer.write("/actuation", controller.actuation, units=_MIXED)


def _write_stability(writer: Writer, loop: Loop, found: Stability) -> None:
    writer.write("/loop/name", list(loop.controller.loops))
    for name, key in (
        ("crossover", "crossover_hz"),
        ("phase_margin", "phase_deg"),
        ("gain_margin", "gain_db"),
        ("gain_reduction", "reduction_db"),
        ("peak_sensitivity", "peak_sensitivity"),
    ):
        writer.write(f"/loop/{name}", [getattr(m, key) for m in found.margins])
    f = np.geomspace(*_OPEN_LOOP_HZ, _OPEN_LOOP_POINTS)
    if isinstance(loop.controller, StateSpaceController) and loop.controller.dt_s is not None:
        f = f[f <= 0.5 / loop.controller.dt_s]
    transfer = loop_transfer(loop.plant, loop.controller, f)
    open_loop = (transfer / (1.0 - transfer)).T
    writer.write("/loop/frequency", f)
    writer.write("/loop/open_real", np.ascontiguousarray(open_loop.real))
    writer.write("/loop/open_imaginary", np.ascontiguousarray(open_loop.imag))
    order = np.lexsort((found.poles.imag, found.poles.real))[::-1]
    writer.write("/pole/real", found.poles.real[order])
    writer.write("/pole/imaginary", found.poles.imag[order])


def _write_noise(writer: Writer, loop: Loop) -> None:
    writer.write("/label/disturbance", list(DISTURBANCES))
    writer.write("/label/disturbance_unit", [unit(name) for name in DISTURBANCES])
    writer.write("/noise/name", [s.name for s in loop.sources])
    writer.write("/noise/group", [s.group for s in loop.sources])
    writer.write("/noise/spectrum", [s.spectrum.words() for s in loop.sources])
    writer.write("/noise/origin", [s.origin for s in loop.sources])
    writer.write("/noise/gain", columns(loop.sources), units=_MIXED)
