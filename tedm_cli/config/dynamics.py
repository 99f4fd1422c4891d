"""Configuration of the drag-free dynamics: spacecraft, stiffness, controller, noise, requirements."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, field_validator, model_validator

from tedm_cli import quantities as q
from tedm_cli.arrays import FloatArray
from tedm_cli.config.base import IDENTIFIER, Bounded, Direction, FileName, Place, Strict, load, named_by_project
from tedm_cli.config.requirements import RequirementTable
from tedm_cli.dynamics.bodies import DynamicTestMass, Spacecraft
from tedm_cli.dynamics.controller import LOOPS
from tedm_cli.dynamics.judging import THERMAL
from tedm_cli.dynamics.loops import INTEGRAL, LEAD, ROLL_OFF, Loop, LoopShape
from tedm_cli.dynamics.presets import (
    ACTUATION_STABILITY,
    TOTAL_STIFFNESS_S2,
    lpf_sources,
    lpf_spacecraft,
    thruster_sources,
)
from tedm_cli.dynamics.signals import DISTURBANCES, OUTPUTS, TEST_MASSES
from tedm_cli.dynamics.sources import NoiseSource, PowerLaw, SpectrumTable
from tedm_cli.dynamics.stiffness import electrostatic_to_total
from tedm_cli.errors import ConfigError
from tedm_cli.files.provenance import ConfigFile
from tedm_cli.noise.requirements import AppliedRequirement
from tedm_cli.tables.csv_table import read_table

Moment = Annotated[float, Bounded(q.INERTIA)]
Moments = Annotated[list[Moment], Field(min_length=3, max_length=3)]
Stiffness = Annotated[float, Bounded(q.STIFFNESS)]
Six = Annotated[list[Stiffness], Field(min_length=6, max_length=6)]
CornerRatio = Annotated[float, Bounded(q.CORNER_RATIO)]
Coefficient = Annotated[float, Bounded(q.TRANSFER_COEFFICIENT)]
_DISTURBED = ("w_ and an input (w_SC_Fx)", "n_ and a coordinate (n_TM1_x)", "s_ and an acceleration (s_TM1_a_x)")
_SPECTRUM = {"frequency_hz": q.FREQUENCY, "amplitude": q.NOISE_LEVEL}


class SpacecraftTable(Strict):
    """The spacecraft without its test masses; what is left out is LISA Pathfinder's, around the test masses.

    About the centre of mass, basic frame: `inertia_kg_m2`, three moments without products of inertia, or
    `inertia_matrix_kg_m2` [3, 3]. `centre_of_mass_m`: basic frame.
    """

    mass_kg: Annotated[float, Bounded(q.SPACECRAFT_MASS)] | None = None
    inertia_kg_m2: Moments | None = None
    inertia_matrix_kg_m2: Annotated[list[Moments], Field(min_length=3, max_length=3)] | None = None
    centre_of_mass_m: Place | None = None

    @model_validator(mode="after")
    def _one_inertia(self) -> SpacecraftTable:
        if self.inertia_kg_m2 is not None and self.inertia_matrix_kg_m2 is not None:
            raise ValueError("has both inertia_kg_m2 and inertia_matrix_kg_m2")
        return self

    def spacecraft(self, test_masses: list[DynamicTestMass]) -> Spacecraft:
        """The body; `PhysicsError` for an inertia that no body has."""
        preset = lpf_spacecraft(test_masses)
        inertia = preset.inertia_kg_m2
        if self.inertia_matrix_kg_m2 is not None:
            inertia = np.array(self.inertia_matrix_kg_m2)
        elif self.inertia_kg_m2 is not None:
            inertia = np.diag(self.inertia_kg_m2)
        return Spacecraft(
            preset.mass_kg if self.mass_kg is None else self.mass_kg,
            inertia,
            preset.centre_of_mass_m if self.centre_of_mass_m is None else np.array(self.centre_of_mass_m),
        )


class StiffnessTable(Strict):
    """Electrostatic stiffness per mass and moment, 1/s² along the diagonal, positive where it destabilises.

    `preset = "ltpda"` fills the gravity's up to the totals of LISA Pathfinder (x y z theta eta phi); "none" has none.
    `electrostatic` gives the six numbers of each test mass by name in place of the preset, `electrostatic_matrix` all
    [6, 6] of them.
    """

    preset: Literal["ltpda", "none"] = "ltpda"
    electrostatic: dict[str, Six] = Field(default_factory=dict)
    electrostatic_matrix: dict[str, Annotated[list[Six], Field(min_length=6, max_length=6)]] = Field(
        default_factory=dict
    )

    @model_validator(mode="after")
    def _both_test_masses(self) -> StiffnessTable:
        if self.electrostatic and self.electrostatic_matrix:
            raise ValueError("has both electrostatic and electrostatic_matrix")
        own = self.electrostatic or self.electrostatic_matrix
        if own and sorted(own) != sorted(TEST_MASSES):
            raise ValueError(f"electrostatics must have one entry for each of {', '.join(TEST_MASSES)}")
        return self

    def matrix(self, gravity: FloatArray) -> FloatArray:
        """[2, 6, 6] beside the `gravity` [2, 6, 6] of what moves with the spacecraft."""
        if self.electrostatic:
            return np.stack([np.diag(self.electrostatic[tm]) for tm in TEST_MASSES])
        if self.electrostatic_matrix:
            return np.array([self.electrostatic_matrix[tm] for tm in TEST_MASSES])
        return electrostatic_to_total(gravity) if self.preset == "ltpda" else np.zeros((2, 6, 6))

    def words(self) -> str:
        """Where the electrostatic stiffness is from."""
        if self.electrostatic or self.electrostatic_matrix:
            return "configured"
        shown = " ".join(f"{1e6 * k:g}" for k in TOTAL_STIFFNESS_S2)
        return f"up to LISA Pathfinder's totals, {shown} 1e-6/s^2 (LTPDA)" if self.preset == "ltpda" else "none"


class ReadOutTable(Strict):
    """Which redundant set of read-outs the controller hears."""

    set: Annotated[str, Field(pattern=IDENTIFIER)] | None = None


class ShapeTable(Strict):
    """Corner frequencies of the default loops, relative to their crossover."""

    integral: CornerRatio = INTEGRAL
    lead: CornerRatio = LEAD
    roll_off: CornerRatio = ROLL_OFF


class LoopTable(Strict):
    """One of the default loops with another crossover, delay or shape, or a transfer function of one's own.

    `numerator` and `denominator`: highest power of s first; acceleration demand per m or rad, 1/s².
    """

    name: str
    crossover_hz: Annotated[float, Bounded(q.CROSSOVER)] | None = None
    delay_s: Annotated[float, Bounded(q.CONTROL_DELAY)] | None = None
    shape: ShapeTable | None = None
    numerator: Annotated[list[Coefficient], Field(min_length=1, max_length=12)] | None = None
    denominator: Annotated[list[Coefficient], Field(min_length=1, max_length=12)] | None = None

    @field_validator("name")
    @classmethod
    def _known(cls, value: str) -> str:
        if value not in LOOPS:
            raise ValueError(f"no loop is called {value!r}; there are {', '.join(LOOPS)}")
        return value

    @model_validator(mode="after")
    def _both_or_none(self) -> LoopTable:
        if (self.numerator is None) != (self.denominator is None):
            raise ValueError("needs both numerator and denominator, or neither")
        if self.numerator is not None and (self.crossover_hz is not None or self.shape is not None):
            raise ValueError("has a transfer function: its crossover and shape follow from it")
        return self

    def loop(self, default: Loop, shape: LoopShape) -> Loop:
        """The loop; `PhysicsError` for an improper transfer function."""
        transfer = None if self.numerator is None else (tuple(self.numerator), tuple(self.denominator or ()))
        own = shape if self.shape is None else LoopShape(**self.shape.model_dump())
        crossover = default.crossover_hz if self.crossover_hz is None else self.crossover_hz
        return Loop(self.name, crossover, default.delay_s if self.delay_s is None else self.delay_s, own, transfer)


class ControllerTable(Strict):
    """The default controller, changed loop by loop, or one of one's own.

    `file`: A, B, C, D with `inputs` and `outputs` in MAT, NPZ or TOML, relative to this file.
    """

    file: FileName | None = None
    shape: ShapeTable = ShapeTable()
    loop: list[LoopTable] = Field(default_factory=list)

    @model_validator(mode="after")
    def _one_of_both(self) -> ControllerTable:
        if self.file is not None and (self.loop or self.shape != ShapeTable()):
            raise ValueError("has both a file and loops of the default controller")
        names = [loop.name for loop in self.loop]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"loop {twice[0]} is there twice")
        return self


class SpectrumFields(Strict):
    """PSD level² (1 + (corner/f)^slope), or the amplitudes of a CSV (`frequency_hz,amplitude`)."""

    level: Annotated[float, Bounded(q.NOISE_LEVEL)] | None = None
    corner_hz: Annotated[float, Bounded(q.CORNER)] = 0.0
    slope: Annotated[float, Bounded(q.SPECTRAL_SLOPE)] = 0.0
    table: FileName | None = None

    @model_validator(mode="after")
    def _one_spectrum(self) -> SpectrumFields:
        if (self.level is None) == (self.table is None):
            raise ValueError("needs either level or table")
        if self.table is not None and (self.corner_hz or self.slope):
            raise ValueError("has a table: corner_hz and slope belong to a level")
        return self

    def spectrum(self, folder: Path) -> PowerLaw | SpectrumTable:
        """The spectrum; raises `InputError` for its table."""
        if self.table is None:
            return PowerLaw(float(self.level or 0.0), self.corner_hz, self.slope)
        rows = read_table(folder / self.table, _SPECTRUM)
        frequency, amplitude = (tuple(row.number[c] for row in rows) for c in _SPECTRUM)
        return SpectrumTable(frequency, amplitude, str(folder / self.table))


class SourceTable(SpectrumFields):
    """A noise source of one's own, or, by the name of one of the preset, another spectrum for it.

    `gains`: what it adds to which disturbances, by name: `w_` inputs (N, N m), `n_` read-outs (m, rad), `s_`
    accelerations (m/s², rad/s²).
    """

    name: Annotated[str, Field(pattern=IDENTIFIER)]
    group: Annotated[str, Field(pattern=IDENTIFIER)] | None = None
    gains: dict[str, Annotated[float, Bounded(q.NOISE_GAIN)]] = Field(default_factory=dict)
    origin: str = "configured"

    @field_validator("gains")
    @classmethod
    def _known(cls, value: dict[str, float]) -> dict[str, float]:
        unknown = [name for name in value if name not in DISTURBANCES]
        if unknown:
            raise ValueError(f"{unknown[0]!r} is no disturbance: {', '.join(_DISTURBED)}")
        return value

    @model_validator(mode="after")
    def _not_the_temperatures(self) -> SourceTable:
        if (self.group or self.name) == THERMAL:
            raise ValueError(f"the group {THERMAL!r} is of the temperatures of a case; give it another name")
        return self


class ThrusterTable(SpectrumFields):
    """A thruster: where it is, along what it pushes the spacecraft (basic frame), and the noise of its force, N/√Hz."""

    position_m: Place
    direction: Direction

    @field_validator("direction")
    @classmethod
    def _not_zero(cls, value: list[float]) -> list[float]:
        if not any(value):
            raise ValueError("is zero")
        return value


class NoiseTable(Strict):
    """Noise sources: those of a preset less what is omitted, thrusters in place of its six, and own ones."""

    preset: Literal["lpf", "none"] = "lpf"
    omit: list[str] = Field(default_factory=list)
    actuation_stability: Annotated[float, Bounded(q.RELATIVE_NOISE)] = ACTUATION_STABILITY
    source: list[SourceTable] = Field(default_factory=list)
    thruster: list[ThrusterTable] = Field(default_factory=list)

    @model_validator(mode="after")
    def _each_once(self) -> NoiseTable:
        names = [source.name for source in self.source]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"source {twice[0]} is there twice")
        return self

    def sources(
        self, spacecraft: Spacecraft, test_masses: list[DynamicTestMass], at_rest: FloatArray, folder: Path, where: str
    ) -> list[NoiseSource]:
        """All sources; `at_rest` [12] as `lpf_sources` takes it. Raises `ConfigError` for names that are not known."""
        sources = {} if self.preset == "none" else {
            s.name: s for s in lpf_sources(test_masses, at_rest, self.actuation_stability)
        }  # fmt: skip
        problems = []
        if self.omit and not sources:
            problems.append(("noise.omit", 'there is nothing to leave out: the preset is "none"'))
        for k, wanted in enumerate(self.omit if sources else []):
            gone = [name for name, s in sources.items() if wanted in (name, s.group)]
            if not gone:
                groups = ", ".join(dict.fromkeys(s.group for s in sources.values()))
                problems.append(
                    (f"noise.omit[{k}]", f"{wanted!r} is no source or group of the preset; groups: {groups}")
                )
            for name in gone:
                del sources[name]
        if self.thruster:
            sources = {name: s for name, s in sources.items() if s.group != "thruster"}
            position, direction = (
                np.array([getattr(t, key) for t in self.thruster]) for key in ("position_m", "direction")
            )
            spectra = [t.spectrum(folder) for t in self.thruster]
            made = thruster_sources(position, direction, spectra, spacecraft.centre_of_mass_m)
            sources |= {s.name: s for s in made}
        for k, own in enumerate(self.source):
            before = sources.get(own.name)
            if before is None and not own.gains:
                problems.append((f"noise.source[{k}]", f"{own.name!r} is no source of the preset, and has no gains"))
                continue
            group = own.group or (before.group if before else own.name)
            gains = own.gains or (before.gains if before else {})
            sources[own.name] = NoiseSource(own.name, group, gains, own.spectrum(folder), own.origin)
        if problems:
            raise ConfigError(problems, where=where)
        return list(sources.values())


class TimeTable(Strict):
    """The realisation in time: samples per second, how many, and the seed of its random numbers."""

    rate_hz: Annotated[float, Bounded(q.CROSSOVER)] = 0.5
    samples: Annotated[int, Bounded(q.REALISED_SAMPLES)] = 2**20
    seed: Annotated[int, Bounded(q.SEED)] = 1


def _default_requirements() -> list[RequirementTable]:
    return [
        RequirementTable(name="lpf_acceleration", outputs=["delta_g"], applies_to="differential"),
        RequirementTable(name="lisa_acceleration", outputs=["TM1_a_x", "TM2_a_x"]),
        RequirementTable(name="lisa_acceleration_differential", outputs=["delta_g"], applies_to="differential"),
        RequirementTable(name="lpf_jitter", outputs=["TM1_x"]),
    ]


class DynamicsConfig(Strict):
    """One dynamics file; without it, the defaults: LISA Pathfinder's spacecraft around the project's test masses."""

    spacecraft: SpacecraftTable = SpacecraftTable()
    stiffness: StiffnessTable = StiffnessTable()
    read_out: ReadOutTable = ReadOutTable()
    controller: ControllerTable = ControllerTable()
    noise: NoiseTable = NoiseTable()
    time: TimeTable = TimeTable()
    requirements: list[RequirementTable] = Field(alias="requirement", default_factory=_default_requirements)

    def file_names(self) -> list[str]:
        """Files beside this one: the controller and the spectra of noise sources."""
        names = [self.controller.file, *(t.table for t in (*self.noise.source, *self.noise.thruster))]
        return list(dict.fromkeys(name for name in names if name is not None))

    def applied_requirements(self, outputs: Sequence[str] = OUTPUTS) -> list[AppliedRequirement]:
        """Requirements with the outputs of the closed loop that they judge; of the defaults those on `outputs`."""
        is_given = "requirements" in self.model_fields_set
        return [t.applied() for t in self.requirements if is_given or set(t.outputs) <= set(outputs)]


def load_dynamics(path: Path | None) -> tuple[ConfigFile | None, DynamicsConfig]:
    """Read a dynamics file, or the defaults where the project names none; `ConfigError` lists all problems.

    Tables of requirements are made relative to the current folder.
    """
    if path is None:
        return None, DynamicsConfig()
    file, config = load(DynamicsConfig, path, hint=named_by_project("dynamics"))
    if "requirements" not in config.model_fields_set:
        return file, config
    requirements = [
        r.model_copy(update={"table": str(path.parent / r.table)}) if r.table else r for r in config.requirements
    ]
    return file, config.model_copy(update={"requirements": requirements})
