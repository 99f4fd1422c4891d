"""simulate --problem: a self-contained problem of the dynamics in JSON, so that any tool can be compared."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.dynamics.problem import ControllerTable, Problem, SpectrumFields, load_problem
from tedm_cli.dynamics.bodies import DynamicTestMass, Spacecraft
from tedm_cli.dynamics.budget import budget
from tedm_cli.dynamics.controller import LOOPS, Controller, default_controller
from tedm_cli.dynamics.judging import by_group, groups_of
from tedm_cli.dynamics.loops import Loop, LoopShape, StateSpace
from tedm_cli.dynamics.own_controller import StateSpaceController
from tedm_cli.dynamics.plant import Plant
from tedm_cli.dynamics.signals import COORDINATES, STRAY
from tedm_cli.dynamics.sources import NoiseSource, PowerLaw, SpectrumTable
from tedm_cli.dynamics.stability import stability
from tedm_cli.dynamics.thermal_input import ThermalInput
from tedm_cli.errors import ConfigError, InputError, TedmError
from tedm_cli.noise.correlation_check import correlation_factor
from tedm_cli.noise.temperature import ShapedSpectrum


def solve_problem(path: Path) -> dict[str, Any]:
    """PSDs of all outputs, their parts by group, and the margins, as plain numbers.

    Raises
    ------
    InputError : no such file, not JSON, shapes that do not fit each other.
    ConfigError : keys or values that are not as `Problem` says.
    PhysicsError : bodies that cannot be, an unstable loop.
    """
    table = load_problem(path)
    try:
        plant = _plant(table)
        controller = _controller(table.controller, plant)
        sources = [NoiseSource(s.name, s.group, s.input, _spectrum(s.psd, s.name)) for s in table.source]
        frequency = np.array(table.frequency_hz)
        found = budget(plant, controller, sources, _thermal(table, frequency), frequency)
        margins = stability(plant, controller)
    except TedmError as error:
        error.where = f"{path}: {error.where}" if error.where else str(path)
        raise
    groups = by_group(found, sources)
    return {
        "output": list(found.labels),
        "frequency_hz": frequency.tolist(),
        "psd_total": found.total.tolist(),
        "psd": {group: groups[:, :, g].tolist() for g, group in enumerate(groups_of(sources))},
        "stability": {
            "largest_real_part": margins.largest_real_part,
            "states": len(margins.poles),
            "margins": {
                m.loop: {
                    "phase_margin_deg": _finite(m.phase_deg),
                    "gain_margin_dB": _finite(m.gain_db),
                    "gain_reduction_dB": _finite(m.reduction_db),
                    "peak_S": m.peak_sensitivity,
                }
                for m in margins.margins
            },
        },
    }


def _refused(problems: list[tuple[str, str]]) -> ConfigError:
    """The problems of a file that whoever reads it names."""
    return ConfigError(problems, where="")


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _array(value: Any, shape: tuple[int, ...], name: str) -> FloatArray:
    try:
        array = np.array(value, dtype=np.float64)
    except ValueError as exc:
        raise InputError(f"{name} has rows of different lengths") from exc
    if array.shape != shape:
        raise InputError(f"{name} is {' x '.join(map(str, array.shape))}; wanted {' x '.join(map(str, shape))}")
    return array


def _plant(table: Problem) -> Plant:
    sc = table.spacecraft
    spacecraft = Spacecraft(sc.mass_kg, np.array(sc.inertia_kg_m2), np.array(sc.centre_of_mass_m))
    test_masses = [
        DynamicTestMass(t.name, t.mass_kg, np.array(t.inertia_kg_m2), np.array(t.position_m), np.array(t.axes))
        for t in table.test_mass
    ]
    rows, columns = table.stiffness.rows or list(STRAY), table.stiffness.columns or list(COORDINATES[3:])
    if sorted(rows) != sorted(STRAY) or sorted(columns) != sorted(COORDINATES[3:]):
        raise _refused([("stiffness.rows", "must be TM1_a_x to TM2_omegadot_z; columns TM1_x to TM2_phi")])
    mutual = _array(table.stiffness.mutual, (12, 12), "stiffness.mutual")
    order = np.ix_([rows.index(n) for n in STRAY], [columns.index(n) for n in COORDINATES[3:]])
    return Plant(spacecraft, test_masses, _array(table.stiffness.fixed, (2, 6, 6), "stiffness.fixed"), mutual[order])


def _controller(table: ControllerTable, plant: Plant) -> Controller:
    if table.kind == "default":
        unknown = [name for name in table.loops if name not in LOOPS]
        missing = [name for name in LOOPS if name not in table.loops]
        if unknown or missing:
            fact = f"unknown loop {unknown[0]!r}" if unknown else f"no loop {missing[0]!r}"
            raise _refused([("controller.loops", f"{fact}; wanted are {', '.join(LOOPS)}")])
        shape = LoopShape(table.shape.integral, table.shape.lead, table.shape.rolloff)
        loops = [Loop(name, table.loops[name].crossover_hz, table.loops[name].delay_s, shape) for name in LOOPS]
        return default_controller(plant, loops)
    n, m, p = len(table.A), len(table.inputs), len(table.outputs)
    shapes = {"A": (n, n), "B": (n, m), "C": (p, n), "D": (p, m)}
    parts = [_array(getattr(table, k) or np.zeros(shape), shape, f"controller.{k}") for k, shape in shapes.items()]
    return StateSpaceController(
        StateSpace(*parts), tuple(table.inputs), tuple(table.outputs), table.delay_s, table.dt_s
    )


def _spectrum(table: SpectrumFields, name: str) -> PowerLaw | SpectrumTable:
    if table.form == "table":
        return SpectrumTable(tuple(table.frequency_hz), tuple(table.amplitude), name)
    if table.form == "low_pass":
        raise _refused([(f"source {name}", "low_pass is a spectrum of temperatures; wanted power or table")])
    return PowerLaw(table.level, table.corner_hz, table.slope)


def _thermal(table: Problem, frequency_hz: FloatArray) -> ThermalInput | None:
    s, t = table.sensitivity, table.temperature
    if s is None or t is None:
        return None
    k = len(s.area)
    acceleration, read_out = np.zeros((len(STRAY), k)), np.zeros((len(COORDINATES), k))
    for target, names, labels, values, what in (
        (acceleration, STRAY, s.S_rows, s.S, "S"),
        (read_out, COORDINATES, s.N_rows, s.N, "N"),
    ):
        rows = _array(values, (len(labels), k), f"sensitivity.{what}")
        for label, row in zip(labels, rows, strict=True):
            if label not in names:
                raise _refused([(f"sensitivity.{what}_rows", f"unknown row {label!r}")])
            target[names.index(label)] = row
    if len(t.area_spectrum) != k or any(name not in t.spectrum for name in t.area_spectrum):
        raise _refused([("temperature.area_spectrum", f"wanted {k} names of {', '.join(t.spectrum)}")])
    amplitude = np.stack([_amplitude(t.spectrum[name], name, frequency_hz) for name in t.area_spectrum])
    return ThermalInput(acceleration, read_out, correlation_factor(_array(t.R, (k, k), "temperature.R")), amplitude)


def _amplitude(table: SpectrumFields, name: str, frequency_hz: FloatArray) -> FloatArray:
    if table.form == "low_pass":
        return ShapedSpectrum(table.level, table.reference_hz, table.corner_hz, table.order).amplitude(frequency_hz)
    return np.sqrt(_spectrum(table, name).psd(frequency_hz))
