"""Configuration of loads other than temperature: motions of supports, gravity and moisture that are released, modes."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from tedm_cli.config.base import IDENTIFIER, Bounded, Place, Strict, load, named_by_project
from tedm_cli.config.model.areas import BoxTable, Ids, ranges_increase
from tedm_cli.files.provenance import ConfigFile
from tedm_cli.quantities import FIELD_OF_GRAVITY, MODES, MOISTURE, SWELLING

Name = Annotated[str, Field(pattern=IDENTIFIER)]
Motion = Literal["ux", "uy", "uz", "rx", "ry", "rz"]
Field3 = Annotated[list[Annotated[float, Bounded(FIELD_OF_GRAVITY)]], Field(min_length=3, max_length=3)]
INTERFACE = "INTERFACE"
"""Name of all supports together, which no foot may have."""


class FootTable(Strict):
    """A foot: supports that move as one rigid body, found by `grid`, `set` or `box`; or a foot of `each_support`."""

    name: Name = Field(description="Name of the foot; its loads are `NAME_ux` and so on.")
    grid: Ids | None = Field(default=None, description="The grid that the deck holds there, or several of them.")
    set: Ids | None = Field(default=None, description="Sets of the deck; the foot is what the deck holds of them.")
    box: BoxTable | None = Field(default=None, description="The foot is what the deck holds inside the box.")
    each_support: Literal[True] | None = Field(
        default=None,
        description="Every grid that the deck holds, and that no other foot has, is a foot of its own: `NAME_7` is "
        "grid 7. So one file serves decks that are held elsewhere.",
    )
    about_m: Place | None = Field(
        default=None,
        description="The point that moves by the translation, and about which the foot turns, basic frame. "
        "Else the mean position of its grids.",
    )
    motions: Annotated[list[Motion], Field(min_length=1)] | None = Field(
        default=None,
        description="Which motions are loads, along and about the axes of the basic frame. Else all that the supports "
        "of the foot hold.",
    )

    _order = field_validator("grid", "set")(ranges_increase)

    @model_validator(mode="after")
    def _one_way(self) -> FootTable:
        if sum(v is not None for v in (self.grid, self.set, self.box, self.each_support)) != 1:
            raise ValueError("needs one of grid, set, box and each_support")
        if self.each_support and self.about_m is not None:
            raise ValueError("each support turns about itself: there is no about_m with each_support")
        return self


class GravityReleaseTable(Strict):
    """From the ground, where the structure was aligned, to free fall."""

    name: Name = Field(description="Name of the load.")
    ground_m_s2: Field3 = Field(
        description="Acceleration of free fall on the ground, basic frame: [0.0, 0.0, -9.80665] where z points up. The "
        "load is that it is gone. The structure has to be held on the ground as the deck holds it."
    )

    @model_validator(mode="after")
    def _some(self) -> GravityReleaseTable:
        if not any(self.ground_m_s2):
            raise ValueError("has no field of gravity to release: all of ground_m_s2 is zero")
        return self


class SwellingTable(Strict):
    """What of a load of moisture is in some materials."""

    material: Ids = Field(description="Ids of materials of the deck.")
    expansion_per_percent: Annotated[float, Bounded(SWELLING)] = Field(
        description="Strain per per cent of moisture by mass, the same in all directions."
    )
    change_percent: Annotated[float, Bounded(MOISTURE)] = Field(
        description="Change of the moisture content, in per cent by mass; drying is negative."
    )

    _order = field_validator("material")(ranges_increase)


class MoistureReleaseTable(Strict):
    """From the moist air, where the structure was aligned, to vacuum."""

    name: Name = Field(description="Name of the load.")
    swelling: Annotated[list[SwellingTable], Field(min_length=1)] = Field(description="What becomes of each material.")


class ModesTable(Strict):
    """Natural frequencies of the structure as the deck holds it."""

    number: Annotated[int, Bounded(MODES)] = Field(
        default=6, description="How many of the lowest frequencies are found; 0: none."
    )


class LoadsConfig(Strict):
    """Loads other than temperature, and natural frequencies."""

    foot: list[FootTable] = Field(default_factory=list, description="Supports whose motion is a load.")
    gravity_release: list[GravityReleaseTable] = Field(
        default_factory=list, description="Gravity on the ground that is gone in flight."
    )
    moisture_release: list[MoistureReleaseTable] = Field(
        default_factory=list, description="Moisture of the materials that is gone in vacuum."
    )
    modes: ModesTable = Field(default=ModesTable(), description="Natural frequencies.")

    @model_validator(mode="after")
    def _names_differ(self) -> LoadsConfig:
        given = [t.name for t in self.foot] + [t.name for t in self.gravity_release]
        names = Counter(name.upper() for name in (*given, *(t.name for t in self.moisture_release)))
        twice = [name for name, number in names.items() if number > 1]
        if twice:
            raise ValueError(f"two loads have the same name: {', '.join(twice)}")
        if INTERFACE in names:
            raise ValueError(f"{INTERFACE} is the name of all supports together: give the load another")
        return self


def load_loads(path: Path) -> tuple[ConfigFile, LoadsConfig]:
    """Read a file of loads; `ConfigError` lists its problems."""
    return load(LoadsConfig, path, hint=named_by_project("loads"))
