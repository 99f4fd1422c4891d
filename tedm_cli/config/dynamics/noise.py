"""Configuration of the noise of the drag-free loop: sources of a preset, of one's own, thrusters."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, field_validator, model_validator

from tedm_cli import quantities as q
from tedm_cli.arrays import FloatArray
from tedm_cli.config.base import IDENTIFIER, Bounded, Direction, FileName, Place, Strict
from tedm_cli.dynamics.bodies import DynamicTestMass, Spacecraft
from tedm_cli.dynamics.judging import THERMAL
from tedm_cli.dynamics.presets import ACTUATION_STABILITY, lpf_sources, thruster_sources
from tedm_cli.dynamics.signals import DISTURBANCES
from tedm_cli.dynamics.sources import NoiseSource, PowerLaw, SpectrumTable
from tedm_cli.errors import ConfigError
from tedm_cli.tables.csv_table import read_table

_DISTURBED = ("w_ and an input (w_SC_Fx)", "n_ and a coordinate (n_TM1_x)", "s_ and an acceleration (s_TM1_a_x)")
_SPECTRUM = {"frequency_hz": q.FREQUENCY, "amplitude": q.NOISE_LEVEL}


class SpectrumFields(Strict):
    """PSD level² (1 + (corner/f)^slope), or the amplitudes of a CSV (`frequency_hz,amplitude`)."""

    level: Annotated[float, Bounded(q.NOISE_LEVEL)] | None = Field(
        default=None,
        description="Amplitude spectral density far above the corner, in the SI unit of what it disturbs. "
        "Either this or `table`.",
    )
    corner_hz: Annotated[float, Bounded(q.CORNER)] = Field(
        default=0.0, description="Corner f_c of the PSD level² (1 + (f_c/f)^slope)."
    )
    slope: Annotated[float, Bounded(q.SPECTRAL_SLOPE)] = Field(
        default=0.0, description="Power by which the PSD rises below the corner."
    )
    table: FileName | None = Field(default=None, description="A CSV `frequency_hz,amplitude` in place of `level`.")

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
    """A noise source of one's own, or, by the name of one of the preset, another spectrum for it."""

    name: Annotated[str, Field(pattern=IDENTIFIER)] = Field(
        description="Name of the source; by that of one of the preset it has another spectrum."
    )
    group: Annotated[str, Field(pattern=IDENTIFIER)] | None = Field(
        default=None,
        description="Group that it counts to in budgets. Else that of the source of the preset, or its own name.",
    )
    gains: dict[str, Annotated[float, Bounded(q.NOISE_GAIN)]] = Field(
        default_factory=dict,
        description="What it adds to which disturbances, by name: `w_` and an input (N, N m), `n_` and a "
        "read-out (m, rad), `s_` and an acceleration (m/s², rad/s²). A source that is not in the "
        "preset needs them.",
    )
    origin: str = Field(default="configured", description="Where its numbers are from, as `tedm show` lists it.")

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
    """A thruster, and the noise of its force, N/√Hz."""

    position_m: Place = Field(description="Where the thruster is, basic frame.")
    direction: Direction = Field(description="Along what it pushes the spacecraft, basic frame and any length.")

    @field_validator("direction")
    @classmethod
    def _not_zero(cls, value: list[float]) -> list[float]:
        if not any(value):
            raise ValueError("is zero")
        return value


class NoiseTable(Strict):
    """Noise sources: those of a preset less what is omitted, thrusters in place of its six, and own ones."""

    preset: Literal["lpf", "none"] = Field(
        default="lpf", description='"lpf" has all noise sources of LISA Pathfinder, "none" has none.'
    )
    omit: list[str] = Field(default_factory=list, description="Sources or groups of the preset that are not there.")
    actuation_stability: Annotated[float, Bounded(q.RELATIVE_NOISE)] = Field(
        default=ACTUATION_STABILITY,
        description="Relative amplitude noise of the actuation of the preset, per √Hz. It is an assumption.",
    )
    source: list[SourceTable] = Field(
        default_factory=list, description="Other spectra for sources of the preset, and sources of your own."
    )
    thruster: list[ThrusterTable] = Field(
        default_factory=list, description="Thrusters in place of the six of the preset."
    )

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
