"""Configuration of the thermal areas: which grids they are made of, and their attributes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field, field_validator, model_validator

from tedm_cli.area_names import area_name_fact
from tedm_cli.config.base import ID_RANGE, Bounded, Direction, Id, LengthOrZero, Place, Strict
from tedm_cli.quantities import ANGLE_DEG, COORDINATE, FRAME_ID


def _area_name(value: str) -> str:
    if fact := area_name_fact(value):
        raise ValueError(fact)
    return value


def _increasing(value: list[float]) -> list[float]:
    if not value[0] < value[1]:  # not a number compares as false
        raise ValueError(f"must be [low, high], found {value}")
    return value


def _range(value: str | int) -> tuple[int, int]:
    if isinstance(value, int):
        return value, value
    low, high = value.split(":")
    return int(low), int(high)


def ranges_increase(value: Ids | None) -> Ids | None:
    """The ids, where every range of them is 'low:high'."""
    for low, high in id_ranges(value):
        if low > high:
            raise ValueError(f"'{low}:{high}' must be 'low:high'")
    return value


End = Annotated[float, Field(allow_inf_nan=True), Bounded(COORDINATE, or_infinite=True)]
Interval = Annotated[list[End], Field(min_length=2, max_length=2)]
Angles = Annotated[list[Annotated[float, Bounded(ANGLE_DEG)]], Field(min_length=2, max_length=2)]
IdOrRange = Id | Annotated[str, Field(pattern=ID_RANGE)]
Ids = IdOrRange | Annotated[list[IdOrRange], Field(min_length=1)]


def id_ranges(ids: Ids | None) -> list[tuple[int, int]]:
    """`[3, "4:9"]` as [(3, 3), (4, 9)]."""
    if ids is None:
        return []
    return [_range(i) for i in (ids if isinstance(ids, list) else [ids])]


class BoxTable(Strict):
    """Closed ranges of coordinates in a coordinate system of the deck (0: the basic frame); one left out is open.

    x_m, y_m, z_m in rectangular systems; r_m, theta_deg, z_m in cylindrical ones; r_m, theta_deg (from the z axis),
    phi_deg in spherical ones. `inf` and `-inf` are open ends of lengths. Angles are in degrees and modulo 360.
    """

    frame: Annotated[int, Bounded(FRAME_ID)] = 0
    x_m: Interval | None = None
    y_m: Interval | None = None
    z_m: Interval | None = None
    r_m: Interval | None = None
    theta_deg: Angles | None = None
    phi_deg: Angles | None = None

    _order = field_validator("x_m", "y_m", "z_m", "r_m", "theta_deg", "phi_deg")(_increasing)

    @model_validator(mode="after")
    def _bounded(self) -> BoxTable:
        if not self.ranges():
            raise ValueError("bounds nothing: give a range, as in y_m = [0.0, inf]")
        return self

    def ranges(self) -> dict[str, list[float]]:
        """The ranges given, by key."""
        keys = ("x_m", "y_m", "z_m", "r_m", "theta_deg", "phi_deg")
        return {key: getattr(self, key) for key in keys if getattr(self, key) is not None}


class SelectionTable(Strict):
    """Grids that meet every criterion given. Ids are `7`, `"4:9"` or a list of these; any box of a list will do.

    `property`, `material` and `element` choose elements, and their grids; `set` the members of SET1, SET3 or a SET of
    the case control.
    """

    set: Ids | None = None
    property: Ids | None = None
    material: Ids | None = None
    element: Ids | None = None
    box: BoxTable | Annotated[list[BoxTable], Field(min_length=1)] | None = None

    _order = field_validator("set", "property", "material", "element")(ranges_increase)

    def boxes(self) -> Sequence[BoxTable]:
        """The boxes, as a list."""
        return self.box if isinstance(self.box, list) else [self.box] if self.box is not None else []

    def selects(self) -> bool:
        """Whether any criterion is given."""
        return any(v is not None for v in (self.set, self.property, self.material, self.element, self.box))

    @model_validator(mode="after")
    def _not_empty(self) -> SelectionTable:
        self._require_criteria()
        return self

    def _require_criteria(self) -> None:
        if not self.selects():
            raise ValueError("selects nothing: give set, property, material, element or box")


class DefinitionTable(SelectionTable):
    """One thermal area: grids that meet the criteria, and those of each selection in `also`; or all that is left."""

    name: Annotated[str, AfterValidator(_area_name)]
    also: list[SelectionTable] = Field(default_factory=list)
    remainder: bool = False

    def selections(self) -> list[SelectionTable]:
        """The area is the union of these."""
        return [self, *self.also]

    def _require_criteria(self) -> None:
        if self.remainder and (self.selects() or self.also):
            raise ValueError("remainder = true takes all that is left, but other criteria are given too")
        if not (self.remainder or self.selects()):
            raise ValueError("selects nothing: give set, property, material, element, box or remainder = true")


class AreaRule(Strict):
    """Attributes of the thermal areas whose name matches; the first rule that matches an area holds."""

    match: str
    group: str
    shield: Literal["inside", "outside"]
    side: Literal["+y", "-y", "mid"] | None = None


class SymmetryPlaneTable(Strict):
    """A plane of the basic frame; its normal, of any length, points to the side that is called +y."""

    point_m: Place
    normal: Direction

    @field_validator("normal")
    @classmethod
    def _not_zero(cls, value: list[float]) -> list[float]:
        if np.linalg.norm(value) < 1e-6:
            raise ValueError("is no direction: its length is zero")
        return value


class AreasTable(Strict):
    """Definitions of the areas, and rules for their attributes.

    A grid belongs to the first definition that it meets; with `strict` no grid may meet two. `symmetry_plane`: what
    sides and mirror pairs refer to; left out, it is the x-z plane of the optical layout's frame, or basic y = 0 without
    a layout. `mid_half_width_m`: an area whose centroid is closer than this to it is on neither side.
    """

    symmetry_plane: SymmetryPlaneTable | None = None
    mid_half_width_m: LengthOrZero = 1e-3
    rule: Annotated[list[AreaRule], Field(min_length=1)]
    strict: bool = False
    define: list[DefinitionTable] = Field(default_factory=list)

    @field_validator("define")
    @classmethod
    def _one_each(cls, value: list[DefinitionTable]) -> list[DefinitionTable]:
        first: dict[str, str] = {}
        for definition in value:
            # Nastran does not tell upper from lower case in labels.
            if (name := first.setdefault(definition.name.upper(), definition.name)) is not definition.name:
                raise ValueError(f"area {definition.name!r} is defined twice (as {name!r}); unite them by `also`")
        if any(d.remainder for d in value[:-1]):
            raise ValueError("remainder = true must be the last definition: nothing is left for those after it")
        return value

    def has_boxes(self) -> bool:
        """Whether the positions of grids matter."""
        return any(s.boxes() for d in self.define for s in d.selections())
