"""simulate --problem: a self-contained problem of the dynamics in JSON, so that any tool can be compared."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from tedm_cli.arrays import FloatArray
from tedm_cli.config.base import Strict, validate
from tedm_cli.dynamics.bodies import DynamicTestMass, Spacecraft
from tedm_cli.dynamics.budget import ThermalInput, budget
from tedm_cli.dynamics.controller import LOOPS, Controller, ScalarLoops
from tedm_cli.dynamics.judging import by_group, groups_of
from tedm_cli.dynamics.loops import Loop, LoopShape, StateSpace
from tedm_cli.dynamics.own_controller import StateSpaceController
from tedm_cli.dynamics.plant import Plant
from tedm_cli.dynamics.signals import COORDINATES, STRAY
from tedm_cli.dynamics.sources import NoiseSource, PowerLaw, SpectrumTable
from tedm_cli.dynamics.stability import stability
from tedm_cli.errors import ConfigError, InputError, TedmError
from tedm_cli.noise.correlation_check import correlation_factor
from tedm_cli.noise.temperature import ShapedSpectrum

Vector = Annotated[list[float], Field(min_length=3, max_length=3)]
Matrix = list[list[float]]


class BodyTable(Strict):
    """The spacecraft without its test masses; basic frame."""

    mass_kg: float
    inertia_kg_m2: Annotated[list[Vector], Field(min_length=3, max_length=3)]
    centre_of_mass_m: Vector


class MassTable(Strict):
    """A test mass: principal moments, nominal centre and axes (rows), basic frame."""

    name: str
    mass_kg: float
    inertia_kg_m2: Vector
    position_m: Vector
    axes: Annotated[list[Vector], Field(min_length=3, max_length=3)]


class StiffnessTable(Strict):
    """`fixed` [2, 6, 6] of what moves with the spacecraft, `mutual` [12, 12] of the other test mass."""

    fixed: list[Matrix]
    mutual: Matrix
    rows: list[str] | None = None
    columns: list[str] | None = None


class SensitivityTable(Strict):
    """S and N per kelvin of the areas, with the names of their rows."""

    S: Matrix
    S_rows: list[str]
    N: Matrix
    N_rows: list[str]
    area: list[str]


class ShapeTable(Strict):
    """Corner frequencies of the default loops, relative to their crossover."""

    integral: float = 15.0
    lead: float = 3.5
    rolloff: float = 10.0


class LoopTable(Strict):
    """One default loop."""

    crossover_hz: Annotated[float, Field(gt=0.0)]
    delay_s: Annotated[float, Field(ge=0.0)]


class ControllerTable(Strict):
    """The default controller with its loops, or A, B, C, D (u = C x + D y) with the names of inputs and outputs."""

    kind: Literal["default", "state_space"] = "default"
    shape: ShapeTable = ShapeTable()
    loops: dict[str, LoopTable] = Field(default_factory=dict)
    A: Matrix = Field(default_factory=list)
    B: Matrix = Field(default_factory=list)
    C: Matrix = Field(default_factory=list)
    D: Matrix = Field(default_factory=list)
    inputs: list[str] = Field(default_factory=list)
    outputs: list[str] = Field(default_factory=list)
    delay_s: Annotated[float, Field(ge=0.0)] = 0.0
    dt_s: Annotated[float, Field(gt=0.0)] | None = None


class SpectrumFields(Strict):
    """level² (1 + (corner_hz/f)^slope); a table of amplitudes; or the low-pass of temperatures."""

    form: Literal["power", "table", "low_pass"]
    level: float = 1.0
    corner_hz: float = 0.0
    slope: float = 0.0
    reference_hz: float = 1e-3
    order: float = 2.0
    frequency_hz: list[float] = Field(default_factory=list)
    amplitude: list[float] = Field(default_factory=list)


class SourceTable(Strict):
    """An independent noise: `input` maps disturbances to gains."""

    name: str
    group: str
    input: dict[str, float]
    psd: SpectrumFields


class TemperatureTable(Strict):
    """Correlation R of the areas, and the spectrum of each by name."""

    R: Matrix
    area_spectrum: list[str]
    spectrum: dict[str, SpectrumFields]


class Problem(Strict):
    """A whole problem. Results that a file holds beside it are not read."""

    title: str = ""
    spacecraft: BodyTable
    test_mass: Annotated[list[MassTable], Field(min_length=2, max_length=2)]
    stiffness: StiffnessTable
    sensitivity: SensitivityTable | None = None
    controller: ControllerTable = ControllerTable()
    source: list[SourceTable] = Field(default_factory=list)
    temperature: TemperatureTable | None = None
    frequency_hz: Annotated[list[float], Field(min_length=1)]
    result: Any = None
    free_response: Any = None
    matrices: Any = None
    figure_6_2: Any = None


def solve_problem(path: Path) -> dict[str, Any]:
    """PSDs of all outputs, their parts by group, and the margins, as plain numbers.

    Raises
    ------
    InputError : no such file, not JSON, shapes that do not fit each other.
    ConfigError : keys or values that are not as `Problem` says.
    PhysicsError : bodies that cannot be, an unstable loop.
    """
    table = validate(Problem, _json(path), where=str(path))
    try:
        plant = _plant(table)
        controller = _controller(table.controller, plant)
        sources = [NoiseSource(s.name, s.group, s.input, _spectrum(s.psd, s.name)) for s in table.source]
        frequency = np.array(table.frequency_hz)
        found = budget(plant, controller, sources, _thermal(table, frequency), frequency)
        margins = stability(plant, controller)
    except TedmError as error:
        error.where = error.where or str(path)
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


def _json(path: Path) -> dict[str, Any]:
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as exc:
        raise InputError(f"cannot be read ({exc.strerror})", where=str(path)) from exc
    except (ValueError, RecursionError) as exc:
        raise InputError(f"is not JSON: {exc}", where=str(path)) from exc
    if not isinstance(data, dict):
        raise InputError("is no JSON object", where=str(path))
    return data


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
        return ScalarLoops(plant, loops)
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
