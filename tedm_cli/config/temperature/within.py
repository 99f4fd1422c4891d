"""Configuration of temperature gradients within thermal areas: which areas, along what, in which cases, how large."""

from __future__ import annotations

from fnmatch import fnmatchcase
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from tedm_cli.area_names import area_name_fact
from tedm_cli.config.base import GradientLevel, TemperatureLevel
from tedm_cli.config.temperature.spectrum import Names, SelectingTable
from tedm_cli.noise.areas import AXES
from tedm_cli.quantities import GRADIENT_ASD

Axis = Literal["x", "y", "z"]


class WithinTable(SelectingTable):
    """Temperature gradients within areas, along the axes of the basic frame: straight across, zero at the centroid.

    They take no unit loads, but `adjoint.h5`. The areas are those of mean temperatures that meet every key given, each
    by any of its values. Each is taken by itself, or with `name` all of them as one body. Each axis makes a gradient
    area, in K/m, whose name is that of the area or body with ` grad x` behind it; blocks select it as any other.
    """

    quantity = GRADIENT_ASD
    of_gradients = False
    other_table = "[[temperature.gradient]]"
    name: str | None = Field(
        default=None, description="Name of all these areas as one body. Left out, each area has gradients of its own."
    )
    axes: Annotated[list[Axis], Field(min_length=1, max_length=3)] | None = Field(
        default=None, description="Axes of the basic frame. Left out, those along which the area extends."
    )
    cases: Names | None = Field(
        default=None, description="Ids, or patterns of ids, of the cases that have them. Left out, all."
    )
    level_K_per_m: GradientLevel | None = Field(
        default=None, description='Level of "thesis" and "white", which need it or across_K.'
    )
    across_K: TemperatureLevel | None = Field(
        default=None, description="The same as a difference from one end of the area to the other, along each axis."
    )

    @model_validator(mode="before")
    @classmethod
    def _no_kelvin(cls, given: Any) -> Any:
        if isinstance(given, dict) and (found := sorted(set(given) & {"level_K", "outside_K", "inside_K"})):
            verb = "is" if len(found) == 1 else "are"
            raise ValueError(f"{', '.join(found)} {verb} of mean temperatures; give level_K_per_m or across_K")
        return given

    @field_validator("name")
    @classmethod
    def _is_a_name(cls, value: str | None) -> str | None:
        if value is not None and (fact := area_name_fact(gradient_name(value, "x"))):
            raise ValueError(fact)
        return value

    @field_validator("axes")
    @classmethod
    def _each_once(cls, value: list[Axis] | None) -> list[Axis] | None:
        if value is not None and len(set(value)) < len(value):
            raise ValueError("has an axis twice")
        return None if value is None else sorted(value, key=AXES.index)

    @model_validator(mode="after")
    def _selects_and_has_one_level(self) -> WithinTable:
        if self.groups is None and self.shield is None and self.areas is None:
            raise ValueError("selects nothing: give groups, shield or areas")
        if self.preset == "lpf_flight":
            raise ValueError("preset lpf_flight is in K/sqrt(Hz) and cannot be used for gradients")
        levels = [level for level in (self.level_K_per_m, self.across_K) if level is not None]
        if self.preset != "table" and len(levels) != 1:
            what = "both are given" if levels else "neither is given"
            raise ValueError(f"preset {self.preset} needs either level_K_per_m, in K/m/sqrt(Hz), or across_K: {what}")
        return self

    def is_in(self, case_id: str) -> bool:
        """Whether a case has these gradients."""
        return self.cases is None or any(fnmatchcase(case_id, pattern) for pattern in self.cases)


def gradient_name(of: str, axis: str) -> str:
    """Name of the gradient area along an axis of an area or a body."""
    return f"{of} grad {axis}"
