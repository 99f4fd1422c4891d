"""Configuration of the temperature noise: a preset or a table for all areas, and other spectra for some of them.

Gradient areas have tables of their own, in K/m/√Hz, and are silent without.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.config.base import Bounded, FileName, Frequency, GradientLevel, Strict, TemperatureLevel
from tedm_cli.errors import ConfigError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.columns import columns_of_areas
from tedm_cli.noise.temperature import (
    DEFAULT_CORNER_HZ,
    DEFAULT_ORDER,
    INSIDE_LEVEL_K,
    OUTSIDE_LEVEL_K,
    REFERENCE_HZ,
    FlightSpectrum,
    ShapedSpectrum,
    Spectrum,
    TabulatedSpectrum,
    TemperatureModel,
    WhiteSpectrum,
)
from tedm_cli.quantities import FILTER_ORDER, GRADIENT_ASD, TEMPERATURE_ASD, Quantity

Names = Annotated[list[Annotated[str, Field(min_length=1)]], Field(min_length=1)]

_FILTER = ("reference_hz", "order", "corner_hz")
_DEEPEST_DECADES = 100  # below the level under the corner; squares of what is deeper are no numbers any more
_LEVELS = ("outside_K", "inside_K", "level_K", "level_K_per_m")


@dataclass(frozen=True, eq=False)
class SpectrumColumns:
    """Amplitude spectral densities [F, columns] of a user's table, at frequency_hz [F]; in K/√Hz or K/m/√Hz."""

    name: str
    columns: list[str]
    frequency_hz: FloatArray
    asd: FloatArray


class SpectrumChoice(Strict):
    """What a spectrum may be; keys that its preset does not use are refused."""

    quantity: ClassVar[Quantity] = TEMPERATURE_ASD
    preset: Literal["thesis", "white", "lpf_flight", "table"] = Field(
        default="thesis",
        description='"thesis" is low-pass shaped, "white" has its level at every frequency, "lpf_flight" is '
        'an upper limit from flight and the same everywhere, "table" is read from a file.',
    )
    reference_hz: Frequency = Field(default=REFERENCE_HZ, description='Frequency at which "thesis" has its level.')
    order: Annotated[float, Bounded(FILTER_ORDER)] = Field(
        default=DEFAULT_ORDER,
        description='Order of the low-pass of "thesis". The published one is not known: this is an '
        "assumption, and decides verdicts.",
    )
    corner_hz: Frequency = Field(
        default=DEFAULT_CORNER_HZ, description='Corner frequency of the low-pass of "thesis". It is an assumption, too.'
    )
    table: FileName | None = Field(
        default=None, description='File with amplitude spectral densities, CSV or HDF5, for "table".'
    )

    @model_validator(mode="after")
    def _no_idle_keys(self) -> SpectrumChoice:
        given, p = self.model_fields_set, self.preset
        facts = []
        if p != "thesis" and (idle := sorted(given & {*_FILTER})):
            facts.append(f"preset {p} has no low-pass filter, but {', '.join(idle)} given")
        if p in ("lpf_flight", "table") and (idle := sorted(given & {*_LEVELS})):
            facts.append(f"preset {p} has its own levels, but {', '.join(idle)} given")
        if (p == "table") != (self.table is not None):
            facts.append(
                "preset table needs table, the name of a CSV or HDF5 file"
                if p == "table"
                else f'table is given, but preset is {p}; set preset = "table"'
            )
        if facts:
            raise ValueError("; ".join(facts))
        return self

    def filter_fact(self, level: float, low_hz: float, high_hz: float, quantity: Quantity | None = None) -> str:
        """What makes the low-pass at this level implausible between two frequencies; empty where nothing does.

        `quantity` : of the level, where it is not that of the table.
        """
        of = quantity or self.quantity
        if self.preset != "thesis":
            return ""

        def decades(frequency_hz: float) -> float:  # by which the amplitude is below that far below the corner
            steepness = 2.0 * self.order * np.log(frequency_hz / self.corner_hz)
            return float(np.logaddexp(0.0, steepness) / 2.0 / np.log(10.0))

        filter_words = f"order {self.order:g} beyond {self.corner_hz:g} Hz"
        highest = max(high_hz, self.reference_hz)
        if (fall := decades(highest)) > _DEEPEST_DECADES:
            return f"{filter_words} falls by {fall:.0f} decades until {highest:g} Hz; at most {_DEEPEST_DECADES}"
        rise = decades(self.reference_hz) - decades(low_hz)
        if level > 0.0 and (fact := of.fact(level * 10.0**rise)):
            at = f"{level:g} {of.unit} at {self.reference_hz:g} Hz"
            return f"{filter_words} from {at}; at {low_hz:g} Hz {fact}"
        return ""

    def spectrum(self, level_K: float) -> Spectrum:
        """The spectrum of a preset other than `table`."""
        if self.preset == "white":
            return WhiteSpectrum(level_K)
        if self.preset == "lpf_flight":
            return FlightSpectrum()
        return ShapedSpectrum(level_K, self.reference_hz, self.corner_hz, self.order)


class _SelectingTable(SpectrumChoice):
    """A spectrum for areas of one kind, means or gradients: those that meet every key given, each by any value."""

    of_gradients: ClassVar[bool]
    other_table: ClassVar[str]
    groups: Names | None = Field(default=None, description="Areas of these groups.")
    shield: Annotated[list[Literal["inside", "outside"]], Field(min_length=1)] | None = Field(
        default=None, description="Areas on these sides of the thermal shield."
    )
    areas: Names | None = Field(default=None, description="Areas whose names match these patterns.")

    def select(self, areas: AreaTable) -> BoolArray:
        """Mask [k] of the areas it is for."""
        mask = np.equal(areas.gradient, self.of_gradients)
        if self.groups is not None:
            mask &= np.isin(areas.group, self.groups)
        if self.shield is not None:
            mask &= np.isin(areas.shield, self.shield)
        if self.areas is not None:
            mask &= np.array([any(fnmatchcase(n, p) for p in self.areas) for n in areas.name.tolist()])
        return mask

    def unknown(self, areas: AreaTable) -> list[tuple[str, str]]:
        """(key, fact) of every group or pattern that is not of the model, or has no area of the table's kind."""
        groups = sorted(set(areas.group.tolist()))
        mine = areas.gradient == self.of_gradients
        wanted, other = ("gradient", "mean") if self.of_gradients else ("mean", "gradient")
        elsewhere = f"has {other} areas alone, no {wanted} area; their spectra are given in {self.other_table}"
        facts = []
        for g in self.groups or ():
            if g not in groups:
                facts.append(("groups", f"no thermal area is of group {g!r}; groups: {', '.join(groups)}"))
            elif not mine[areas.group == g].any():
                facts.append(("groups", f"group {g!r} {elsewhere}"))
        for p in self.areas or ():
            hit = np.array([fnmatchcase(n, p) for n in areas.name.tolist()])
            if not hit.any():
                facts.append(("areas", f"no thermal area has {p!r}"))
            elif not mine[hit].any():
                facts.append(("areas", f"{p!r} {elsewhere}"))
        return facts


class OverrideTable(_SelectingTable):
    """Another spectrum for the areas of mean temperatures that meet every key given, each by any of its values."""

    of_gradients = False
    other_table = "[[temperature.gradient]], in K/m/sqrt(Hz)"
    level_K: TemperatureLevel | None = Field(default=None, description='Level of "thesis" and "white", which need it.')

    @model_validator(mode="before")
    @classmethod
    def _no_gradient(cls, given: Any) -> Any:
        if isinstance(given, dict) and "level_K_per_m" in given:
            raise ValueError("level_K_per_m is of gradients; they are given in [[temperature.gradient]]")
        return given

    @model_validator(mode="after")
    def _selects_and_has_a_level(self) -> OverrideTable:
        if self.groups is None and self.shield is None and self.areas is None:
            raise ValueError("selects nothing: give groups, shield or areas")
        if self.preset in ("thesis", "white") and self.level_K is None:
            raise ValueError(f"preset {self.preset} needs level_K, in K/sqrt(Hz)")
        return self


class GradientTable(_SelectingTable):
    """The spectrum of gradient areas, of all of them where no key selects."""

    quantity = GRADIENT_ASD
    of_gradients = True
    other_table = "[temperature] and [[temperature.override]], in K/sqrt(Hz)"
    level_K_per_m: GradientLevel | None = Field(
        default=None, description='Level of "thesis" and "white", which need it: none is published.'
    )

    @model_validator(mode="before")
    @classmethod
    def _no_kelvin(cls, given: Any) -> Any:
        if isinstance(given, dict) and (found := sorted(set(given) & {"level_K", "outside_K", "inside_K"})):
            verb = "is" if len(found) == 1 else "are"
            raise ValueError(
                f"{', '.join(found)} {verb} in K/sqrt(Hz), the unit of mean temperatures; give level_K_per_m"
            )
        return given

    @model_validator(mode="after")
    def _has_a_level(self) -> GradientTable:
        if self.preset == "lpf_flight":
            raise ValueError("preset lpf_flight is in K/sqrt(Hz) and cannot be used for gradients")
        if self.preset != "table" and self.level_K_per_m is None:
            raise ValueError(f"preset {self.preset} needs level_K_per_m, in K/m/sqrt(Hz)")
        return self


class TemperatureTable(SpectrumChoice):
    """Temperature noise of all areas. Keys that the preset does not use are refused."""

    outside_K: TemperatureLevel = Field(
        default=OUTSIDE_LEVEL_K, description="Level of areas outside the thermal shield."
    )
    inside_K: TemperatureLevel = Field(default=INSIDE_LEVEL_K, description="Level of areas inside the thermal shield.")
    overrides: list[OverrideTable] = Field(
        alias="override",
        default_factory=list,
        description="Other spectra for some areas of mean temperatures. The last one that selects an area counts.",
    )
    gradients: list[GradientTable] = Field(
        alias="gradient",
        default_factory=list,
        description="Spectra of gradient areas, which are silent without. The last one that selects an area counts.",
    )

    def filter_problems(self, low_hz: float, high_hz: float) -> list[tuple[str, str]]:
        """(dotted path, fact) of the low-pass shapes that are implausible between two frequencies."""
        levels: list[tuple[str, SpectrumChoice, float]] = [
            ("temperature", self, level) for level in (self.outside_K, self.inside_K)
        ]
        levels += [(f"temperature.override[{i}]", o, o.level_K or 0.0) for i, o in enumerate(self.overrides)]
        levels += [(f"temperature.gradient[{i}]", g, g.level_K_per_m or 0.0) for i, g in enumerate(self.gradients)]
        facts = {at: fact for at, table, level in levels if (fact := table.filter_fact(level, low_hz, high_hz))}
        return [(f"{at}.order", fact) for at, fact in facts.items()]

    def table_names(self) -> list[str]:
        """Names of the files with spectra, each once."""
        return list(self.table_quantities())

    def table_quantities(self) -> dict[str, Quantity]:
        """Quantity of each of these files, by name."""
        tables: list[SpectrumChoice] = [self, *self.overrides, *self.gradients]
        return {t.table: t.quantity for t in tables if t.table is not None}

    @model_validator(mode="after")
    def _one_kind_in_a_file(self) -> TemperatureTable:
        kelvin = {t.table for t in (self, *self.overrides) if t.table is not None}
        if both := sorted(kelvin & {t.table for t in self.gradients if t.table is not None}):
            raise ValueError(f"{both[0]} is given for temperatures and for gradients: a file is in one unit")
        return self

    def model(
        self, areas: AreaTable, tables: Mapping[str, SpectrumColumns] | None = None, *, where: str = "temperature"
    ) -> TemperatureModel:
        """Temperature model of the thermal areas; `tables` holds the contents of the files in `table_names`.

        `where`, the file of the configuration, is for messages.

        Raises
        ------
        ConfigError : a table of areas that are not there, or of the other kind.
        InputError : a table that lacks an area or names an unknown one, or whose numbers are no spectrum.
        """
        problems = []
        # The last table that selects an area counts: 0 is this one, of all means; gradients begin with none.
        source = np.where(areas.gradient, -1, 0)
        chosen: list[TemperatureTable | OverrideTable | GradientTable] = [self, *self.overrides, *self.gradients]
        if self.gradients and not areas.gradient.any():
            fact = "the model has no gradient area that it could be the spectrum of"
            raise ConfigError([("temperature.gradient[0]", fact)], where=where)
        paths = [f"override[{i}]" for i in range(len(self.overrides))]
        paths += [f"gradient[{i}]" for i in range(len(self.gradients))]
        for number, (path, table) in enumerate(zip(paths, (*self.overrides, *self.gradients), strict=True), start=1):
            problems += [(f"temperature.{path}.{key}", fact) for key, fact in table.unknown(areas)]
            mask = table.select(areas)
            if not mask.any() and not problems:
                problems.append((f"temperature.{path}", "selects none of the thermal areas"))
            source[mask] = number
        if problems:
            raise ConfigError(problems, where=where)
        spectra: dict[int, Spectrum] = {}
        for number, of in enumerate(chosen):
            mine = source == number
            if of.table is not None and mine.any():
                spectra |= _tabulated((tables or {})[of.table], areas, mine, isinstance(of, GradientTable))
                continue
            for area in np.flatnonzero(mine).tolist():
                spectra[area] = of.spectrum(self._level(of, areas, area))
        return TemperatureModel.from_spectra([spectra.get(area) for area in range(len(areas))], areas.gradient)

    def _level(self, of: TemperatureTable | OverrideTable | GradientTable, areas: AreaTable, area: int) -> float:
        """The level of an area by the table that counts; of a preset without levels it does not matter."""
        of_shield = self.outside_K if areas.shield[area] == "outside" else self.inside_K
        if isinstance(of, TemperatureTable):
            return of_shield
        own = of.level_K_per_m if isinstance(of, GradientTable) else of.level_K
        return of_shield if own is None else own


def _tabulated(table: SpectrumColumns, areas: AreaTable, mask: BoolArray, gradient: bool) -> dict[int, Spectrum]:
    index = columns_of_areas(table.columns, areas, mask, where=table.name, of=areas.gradient == gradient)
    found = {
        int(column): TabulatedSpectrum.of(
            table.frequency_hz, table.asd[:, column], f"{table.columns[column]} of {table.name}"
        )
        for column in np.unique(index[mask])
    }
    return {int(area): found[int(index[area])] for area in np.flatnonzero(mask)}
