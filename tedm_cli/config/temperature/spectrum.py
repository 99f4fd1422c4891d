"""What a spectrum in the configuration may be, and which thermal areas it is for."""

from __future__ import annotations

from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.config.base import Bounded, FileName, Frequency, Strict
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.columns import columns_of_areas
from tedm_cli.noise.temperature import (
    DEFAULT_CORNER_HZ,
    DEFAULT_ORDER,
    REFERENCE_HZ,
    FlightSpectrum,
    ShapedSpectrum,
    Spectrum,
    TabulatedSpectrum,
    WhiteSpectrum,
)
from tedm_cli.quantities import FILTER_ORDER, TEMPERATURE_ASD, Quantity

Names = Annotated[list[Annotated[str, Field(min_length=1)]], Field(min_length=1)]

_FILTER = ("reference_hz", "order", "corner_hz")
_DEEPEST_DECADES = 100  # below the level under the corner; squares of what is deeper are no numbers any more
_LEVELS = ("outside_K", "inside_K", "level_K", "level_K_per_m", "across_K")


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


class SelectingTable(SpectrumChoice):
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


def tabulated(table: SpectrumColumns, areas: AreaTable, mask: BoolArray, gradient: bool) -> dict[int, Spectrum]:
    """Spectra of the areas of the mask [k], by row, from a table in the unit of gradients or of means."""
    index = columns_of_areas(table.columns, areas, mask, where=table.name, of=areas.gradient == gradient)
    found = {
        int(column): TabulatedSpectrum.of(
            table.frequency_hz, table.asd[:, column], f"{table.columns[column]} of {table.name}"
        )
        for column in np.unique(index[mask])
    }
    return {int(area): found[int(index[area])] for area in np.flatnonzero(mask)}
