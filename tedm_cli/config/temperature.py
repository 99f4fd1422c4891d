"""Configuration of the temperature noise: a preset or a table for all areas, and other spectra for some of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.config.base import Bounded, FileName, Frequency, Strict, TemperatureLevel
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
from tedm_cli.quantities import FILTER_ORDER, TEMPERATURE_ASD

Names = Annotated[list[Annotated[str, Field(min_length=1)]], Field(min_length=1)]

_FILTER = ("reference_hz", "order", "corner_hz")
_DEEPEST_DECADES = 100  # below the level under the corner; squares of what is deeper are no numbers any more
_LEVELS = ("outside_K", "inside_K", "level_K")


@dataclass(frozen=True, eq=False)
class SpectrumColumns:
    """Amplitude spectral densities [F, columns] in K/√Hz of a user's table, at frequency_hz [F]."""

    name: str
    columns: list[str]
    frequency_hz: FloatArray
    asd: FloatArray


class _SpectrumTable(Strict):
    """What a spectrum may be; keys that its preset does not use are refused."""

    preset: Literal["thesis", "white", "lpf_flight", "table"] = "thesis"
    reference_hz: Frequency = REFERENCE_HZ
    order: Annotated[float, Bounded(FILTER_ORDER)] = DEFAULT_ORDER
    corner_hz: Frequency = DEFAULT_CORNER_HZ
    table: FileName | None = None

    @model_validator(mode="after")
    def _no_idle_keys(self) -> _SpectrumTable:
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

    def filter_fact(self, level_K: float, low_hz: float, high_hz: float) -> str:
        """What makes the low-pass at this level implausible between two frequencies; empty where nothing does."""
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
        if level_K > 0.0 and (fact := TEMPERATURE_ASD.fact(level_K * 10.0**rise)):
            return f"{filter_words} from {level_K:g} K/sqrt(Hz) at {self.reference_hz:g} Hz; at {low_hz:g} Hz {fact}"
        return ""

    def spectrum(self, level_K: float) -> Spectrum:
        """The spectrum of a preset other than `table`."""
        if self.preset == "white":
            return WhiteSpectrum(level_K)
        if self.preset == "lpf_flight":
            return FlightSpectrum()
        return ShapedSpectrum(level_K, self.reference_hz, self.corner_hz, self.order)


class OverrideTable(_SpectrumTable):
    """Another spectrum for some areas: those that meet every key given, each by any of its values."""

    groups: Names | None = None
    shield: Annotated[list[Literal["inside", "outside"]], Field(min_length=1)] | None = None
    areas: Names | None = None
    level_K: TemperatureLevel | None = None

    @model_validator(mode="after")
    def _selects_and_has_a_level(self) -> OverrideTable:
        if self.groups is None and self.shield is None and self.areas is None:
            raise ValueError("selects nothing: give groups, shield or areas")
        if self.preset in ("thesis", "white") and self.level_K is None:
            raise ValueError(f"preset {self.preset} needs level_K, in K/sqrt(Hz)")
        return self

    def select(self, areas: AreaTable) -> BoolArray:
        """Mask [k] of the areas it is for."""
        mask = np.ones(len(areas), dtype=bool)
        if self.groups is not None:
            mask &= np.isin(areas.group, self.groups)
        if self.shield is not None:
            mask &= np.isin(areas.shield, self.shield)
        if self.areas is not None:
            mask &= np.array([any(fnmatchcase(n, p) for p in self.areas) for n in areas.name.tolist()])
        return mask

    def unknown(self, areas: AreaTable) -> list[tuple[str, str]]:
        """(key, fact) of every group or pattern that is not of the model."""
        groups = sorted(set(areas.group.tolist()))
        facts = [
            ("groups", f"no thermal area is of group {g!r}; groups: {', '.join(groups)}")
            for g in self.groups or ()
            if g not in groups
        ]
        facts += [
            ("areas", f"no thermal area has {p!r}")
            for p in self.areas or ()
            if not any(fnmatchcase(n, p) for n in areas.name.tolist())
        ]
        return facts


class TemperatureTable(_SpectrumTable):
    """Temperature noise of all areas; `outside_K` and `inside_K` are levels in K/√Hz either side of the thermal shield.

    `thesis` is low-pass shaped with these levels at `reference_hz`, `white` has them at every frequency, `lpf_flight`
    is an upper limit from flight and the same everywhere, `table` is read from a file. The order and corner of the
    published filter are not known: the defaults are an assumption and decide verdicts. Of overrides the last counts.
    """

    outside_K: TemperatureLevel = OUTSIDE_LEVEL_K
    inside_K: TemperatureLevel = INSIDE_LEVEL_K
    overrides: list[OverrideTable] = Field(alias="override", default_factory=list)

    def filter_problems(self, low_hz: float, high_hz: float) -> list[tuple[str, str]]:
        """(dotted path, fact) of the low-pass shapes that are implausible between two frequencies."""
        levels: list[tuple[str, _SpectrumTable, float]] = [
            ("temperature", self, level) for level in (self.outside_K, self.inside_K)
        ]
        levels += [(f"temperature.override[{i}]", o, o.level_K or 0.0) for i, o in enumerate(self.overrides)]
        facts = {at: fact for at, table, level in levels if (fact := table.filter_fact(level, low_hz, high_hz))}
        return [(f"{at}.order", fact) for at, fact in facts.items()]

    def table_names(self) -> list[str]:
        """Names of the files with spectra, each once."""
        return list(dict.fromkeys(t.table for t in (self, *self.overrides) if t.table is not None))

    def model(
        self, areas: AreaTable, tables: Mapping[str, SpectrumColumns] | None = None, *, where: str = "temperature"
    ) -> TemperatureModel:
        """Temperature model of the thermal areas; `tables` holds the contents of the files in `table_names`.

        `where`, the file of the configuration, is for messages.

        Raises
        ------
        ConfigError : an override of areas that are not there.
        InputError : a table that lacks an area or names an unknown one, or whose numbers are no spectrum.
        """
        problems = []
        source = np.full(len(areas), -1)
        for number, override in enumerate(self.overrides):
            problems += [(f"temperature.override[{number}].{key}", fact) for key, fact in override.unknown(areas)]
            mask = override.select(areas)
            if not mask.any() and not problems:
                problems.append((f"temperature.override[{number}]", "selects none of the thermal areas"))
            source[mask] = number
        if problems:
            raise ConfigError(problems, where=where)
        spectra: dict[int, Spectrum] = {}
        for number, chosen in enumerate((self, *self.overrides), start=-1):
            mine = source == number
            if chosen.table is not None and mine.any():
                spectra |= _tabulated((tables or {})[chosen.table], areas, mine)
                continue
            for area in np.flatnonzero(mine):
                level = self.outside_K if areas.shield[area] == "outside" else self.inside_K
                own = chosen.level_K if isinstance(chosen, OverrideTable) else level
                spectra[int(area)] = chosen.spectrum(level if own is None else own)
        return TemperatureModel.from_spectra([spectra[area] for area in range(len(areas))])


def _tabulated(table: SpectrumColumns, areas: AreaTable, mask: BoolArray) -> dict[int, Spectrum]:
    index = columns_of_areas(table.columns, areas, mask, where=table.name)
    found = {
        int(column): TabulatedSpectrum.of(
            table.frequency_hz, table.asd[:, column], f"{table.columns[column]} of {table.name}"
        )
        for column in np.unique(index[mask])
    }
    return {int(area): found[int(index[area])] for area in np.flatnonzero(mask)}
