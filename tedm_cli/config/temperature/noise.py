"""Configuration of the temperature noise: a preset or a table for all areas, and other spectra for some of them.

Gradient areas have tables of their own, in K/m/√Hz, and are silent without. Gradients within areas, which are no areas
of the model, are in `temperature_within`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from pydantic import Field, model_validator

from tedm_cli.config.base import GradientLevel, TemperatureLevel
from tedm_cli.config.temperature.spectrum import SelectingTable, SpectrumChoice, SpectrumColumns, tabulated
from tedm_cli.config.temperature.within import WithinTable
from tedm_cli.errors import ConfigError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.temperature import INSIDE_LEVEL_K, OUTSIDE_LEVEL_K, Spectrum, TemperatureModel
from tedm_cli.quantities import GRADIENT_ASD, Quantity


class OverrideTable(SelectingTable):
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


class GradientTable(SelectingTable):
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
    within: list[WithinTable] = Field(
        default_factory=list, description="Gradients within areas, which the model needs no unit loads for."
    )

    def low_passes(self) -> list[tuple[float, float]]:
        """(order, corner in Hz) of each low-pass that areas of mean temperatures may have."""
        tables: list[SpectrumChoice] = [self, *self.overrides]
        return list(dict.fromkeys((t.order, t.corner_hz) for t in tables if t.preset == "thesis"))

    def filter_problems(self, low_hz: float, high_hz: float) -> list[tuple[str, str]]:
        """(dotted path, fact) of the low-pass shapes that are implausible between two frequencies."""
        levels: list[tuple[str, SpectrumChoice, float]] = [
            ("temperature", self, level) for level in (self.outside_K, self.inside_K)
        ]
        levels += [(f"temperature.override[{i}]", o, o.level_K or 0.0) for i, o in enumerate(self.overrides)]
        levels += [(f"temperature.gradient[{i}]", g, g.level_K_per_m or 0.0) for i, g in enumerate(self.gradients)]
        levels += [(f"temperature.within[{i}]", w, w.level_K_per_m or 0.0) for i, w in enumerate(self.within)]
        facts = {at: fact for at, table, level in levels if (fact := table.filter_fact(level, low_hz, high_hz))}
        return [(f"{at}.order", fact) for at, fact in facts.items()]

    def table_names(self) -> list[str]:
        """Names of the files with spectra, each once."""
        return list(self.table_quantities())

    def table_quantities(self) -> dict[str, Quantity]:
        """Quantity of each of these files, by name."""
        tables: list[SpectrumChoice] = [self, *self.overrides, *self.gradients, *self.within]
        return {t.table: t.quantity for t in tables if t.table is not None}

    @model_validator(mode="after")
    def _one_kind_in_a_file(self) -> TemperatureTable:
        kelvin = {t.table for t in (self, *self.overrides) if t.table is not None}
        if both := sorted(kelvin & {t.table for t in (*self.gradients, *self.within) if t.table is not None}):
            raise ValueError(f"{both[0]} is given for temperatures and for gradients: a file is in one unit")
        return self

    def model(
        self, areas: AreaTable, tables: Mapping[str, SpectrumColumns] | None = None, *, where: str = "temperature"
    ) -> TemperatureModel:
        """Temperature model of the model's thermal areas; `tables` holds the contents of the files in `table_names`.

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
                spectra |= tabulated((tables or {})[of.table], areas, mine, isinstance(of, GradientTable))
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
