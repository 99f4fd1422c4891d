"""Configuration of the requirements: presets by name, or tables of the user's own."""

from __future__ import annotations

import difflib
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, ValidationInfo, field_validator, model_validator

from tedm_cli.config.base import FileName, Frequency, OneLine, Strict
from tedm_cli.config.correlation.case import Names
from tedm_cli.noise.requirement_presets import PRESETS
from tedm_cli.noise.requirements import AppliedRequirement, Requirement, tabulated
from tedm_cli.quantities import FREQUENCY, REQUIREMENT
from tedm_cli.tables.csv_table import read_table

COLUMNS = {"frequency_hz": FREQUENCY, "amplitude": REQUIREMENT}


class RequirementTable(Strict):
    """A requirement, a preset by its name or a table of your own, and the outputs that it judges."""

    table: FileName | None = Field(
        default=None,
        description="A CSV `frequency_hz,amplitude`, per √Hz, straight between its points in log-log. Without "
        "it `name` is that of a preset.",
    )
    name: str = Field(min_length=1, description="Name of a preset, or of the requirement that `table` holds.")
    outputs: Names = Field(
        description="Labels of the outputs that it judges; `TM1_a_x-TM2_a_x` is the difference of two."
    )
    applies_to: Literal["single", "differential"] = Field(
        default="single",
        description="Whether the limit is on one test mass or on a difference. A difference is judged by "
        '"differential" requirements alone.',
    )
    quantity: Literal["acceleration", "angular_acceleration", "displacement", "angle"] | None = Field(
        default=None, description="What `table` limits, which it needs."
    )
    band_hz: Annotated[list[Frequency], Field(min_length=2, max_length=2)] | None = Field(
        default=None, description="Lowest and highest frequency that are judged. Else all of the table."
    )
    source: str | None = Field(default=None, description="Where the table is from, for the report.")
    title: OneLine | None = Field(default=None, description="What the report calls it.")

    @field_validator("name")
    @classmethod
    def _known(cls, value: str, info: ValidationInfo) -> str:
        if info.data.get("table") is None and value not in PRESETS:
            near = difflib.get_close_matches(value, PRESETS, n=1)
            hint = f"did you mean {near[0]}?" if near else f"known: {', '.join(PRESETS)}; or give a table"
            raise ValueError(f"unknown requirement {value!r}; {hint}")
        return value

    @model_validator(mode="after")
    def _preset_or_table(self) -> Self:
        if self.table is None:
            given = [key for key in ("quantity", "band_hz", "source") if getattr(self, key) is not None]
            if given:
                raise ValueError(f"{', '.join(given)} of the preset {self.name} cannot be changed; give a table")
        elif self.name in PRESETS:
            raise ValueError(f"{self.name} is the name of a preset; give the table another")
        elif self.quantity is None:
            raise ValueError("a table needs its quantity: acceleration, angular_acceleration, displacement or angle")
        if self.band_hz is not None and self.band_hz[0] >= self.band_hz[1]:
            raise ValueError(f"band_hz {self.band_hz[0]:g} to {self.band_hz[1]:g} does not increase")
        return self

    def requirement(self) -> Requirement:
        """The requirement; raises `InputError` or `ConfigError` for its table."""
        if self.table is None:
            preset = PRESETS[self.name]
            return replace(preset, applies_to=self.applies_to, title=self.title or preset.title)
        rows = read_table(Path(self.table), COLUMNS)
        frequency_hz, amplitude = (np.array([row.number[c] for row in rows]) for c in COLUMNS)
        own = tabulated(
            self.name,
            str(self.quantity),
            frequency_hz,
            amplitude,
            band_hz=None if self.band_hz is None else (self.band_hz[0], self.band_hz[1]),
            applies_to=self.applies_to,
            source=self.source or f"table {Path(self.table).name}",
            where=self.table,
        )
        return replace(own, title=self.title or "")

    def applied(self) -> AppliedRequirement:
        """The requirement with the outputs it judges."""
        return AppliedRequirement(self.requirement(), tuple(self.outputs))
