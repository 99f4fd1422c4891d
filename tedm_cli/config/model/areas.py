"""Configuration of the thermal areas: which grids or elements they are made of, what load is on them, attributes."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, field_validator, model_validator

from tedm_cli.area_names import area_name_fact
from tedm_cli.config.base import ID_RANGE, Bounded, Direction, Form, Id, LengthOrZero, Place, Strict
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


def _not_zero(value: list[float] | None) -> list[float] | None:
    if value is not None and np.linalg.norm(value) < 1e-6:
        raise ValueError("is no direction: its length is zero")
    return value


End = Annotated[float, Field(allow_inf_nan=True), Bounded(COORDINATE, or_infinite=True)]
Interval = Annotated[list[End], Field(min_length=2, max_length=2)]
Angles = Annotated[list[Annotated[float, Bounded(ANGLE_DEG)]], Field(min_length=2, max_length=2)]
AreaName = Annotated[str, AfterValidator(_area_name), Form("name of an area")]
IdOrRange = Id | Annotated[str, Field(pattern=ID_RANGE)]


def _like_ids(value: Any) -> Any:
    """What may be ids; what has none of their forms is refused in one sentence instead of one for each form."""
    is_range = isinstance(value, str) and re.search(ID_RANGE, value)
    if is_range or isinstance(value, int) or (isinstance(value, list) and value):
        return value
    raise ValueError(f"must be an id, a range of ids such as '1:99', or a list of these (found {value!r:.60})")


Ids = Annotated[
    IdOrRange | Annotated[list[IdOrRange], Field(min_length=1)],
    BeforeValidator(_like_ids),
    Form('id, "low:high", or list of these'),
]


def id_ranges(ids: Ids | None) -> list[tuple[int, int]]:
    """`[3, "4:9"]` as [(3, 3), (4, 9)]."""
    if ids is None:
        return []
    return [_range(i) for i in (ids if isinstance(ids, list) else [ids])]


class BoxTable(Strict):
    """Closed ranges of coordinates in a coordinate system of the deck. One that is left out is open."""

    frame: Annotated[int, Bounded(FRAME_ID)] = Field(
        default=0, description="Id of a coordinate system of the deck; 0 is the basic frame."
    )
    x_m: Interval | None = Field(
        default=None, description="Range of x in a rectangular system. `inf` and `-inf` are open ends."
    )
    y_m: Interval | None = Field(default=None, description="Range of y in a rectangular system.")
    z_m: Interval | None = Field(default=None, description="Range of z in a rectangular or cylindrical system.")
    r_m: Interval | None = Field(default=None, description="Range of the radius in a cylindrical or spherical system.")
    theta_deg: Angles | None = Field(
        default=None,
        description="Range of the azimuth in a cylindrical system, or of the angle from the z axis in a "
        "spherical one. Angles are modulo 360.",
    )
    phi_deg: Angles | None = Field(default=None, description="Range of the azimuth in a spherical system.")

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
    """What meets every criterion given. Ids are `7`, `"4:9"` or a list of these."""

    set: Ids | None = Field(
        default=None,
        description="Members of these sets: SET1, SET3, or a SET of the case control. An element is in a set of grids "
        "if all of its grids are.",
    )
    property: Ids | None = Field(default=None, description="Elements with these properties, and their grids.")
    material: Ids | None = Field(
        default=None, description="Elements with these materials, in any layer of a laminate, and their grids."
    )
    element: Ids | None = Field(default=None, description="These elements, and their grids.")
    box: BoxTable | Annotated[list[BoxTable], Field(min_length=1)] | None = Field(
        default=None,
        description="What is inside the box, or inside any of a list of boxes. An element is inside if its centre is.",
    )

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
    """One thermal area: what meets every criterion given, and each selection in `also`; or all that is left.

    Ids are `7`, `"4:9"` or a list of these.
    """

    name: AreaName = Field(description="Name of the area, which becomes the LABEL of its subcase.")
    also: list[SelectionTable] = Field(
        default_factory=list, description="Selections whose grids or elements are in the area as well."
    )
    remainder: bool = Field(
        default=False,
        description="Whether the area is all that is left, in place of criteria. No mean area may follow it.",
    )
    kind: Literal["mean", "gradient"] = Field(
        default="mean",
        description='"mean" is a step of 1 K; "gradient" is 1 K/m through the shells and bars selected, whose '
        "mean temperature stays.",
    )
    carrier: Literal["grids", "elements"] = Field(
        default="grids",
        description='"grids" warms grids, and elements take the temperatures of theirs; "elements" warms the '
        "shells, bars and rods selected by cards of their own, with sharp borders, and solids "
        "through their grids.",
    )
    direction: Direction | None = Field(
        default=None,
        description="Towards the warm side of a gradient, basic frame and any length. Left out, it is along "
        "the shells' own normals.",
    )
    plane: Literal[1, 2] | None = Field(
        default=None,
        description="Plane of the element axes of bars that their gradient is in, in place of `direction`.",
    )

    _no_zero = field_validator("direction")(_not_zero)

    def selections(self) -> list[SelectionTable]:
        """The area is the union of these."""
        return [self, *self.also]

    @property
    def by_elements(self) -> bool:
        """Whether the area is made of elements that have temperatures of their own."""
        return self.kind == "gradient" or self.carrier == "elements"

    def _require_criteria(self) -> None:
        if self.remainder and (self.selects() or self.also):
            raise ValueError("remainder = true takes all that is left, but other criteria are given too")
        if not (self.remainder or self.selects()):
            raise ValueError("selects nothing: give set, property, material, element, box or remainder = true")
        if self.kind == "gradient":
            self._require_gradient()
        elif self.direction is not None or self.plane is not None:
            key = "direction" if self.direction is not None else "plane"
            raise ValueError(f'{key} is that of a gradient, and this is a mean temperature: give kind = "gradient"')

    def _require_gradient(self) -> None:
        if self.remainder:
            raise ValueError(
                "remainder = true is for mean temperatures only: select the elements of a gradient by criteria"
            )
        if self.carrier == "grids" and "carrier" in self.model_fields_set:
            raise ValueError('a gradient is in elements: leave carrier = "grids" out')
        if self.direction is not None and self.plane is not None:
            raise ValueError("direction and plane both say where a gradient points: give one")


class AreaRule(Strict):
    """Attributes of the thermal areas whose name matches."""

    match: str = Field(description='Pattern of area names, such as "STRUT_*".')
    group: str = Field(description="The group of these areas.")
    shield: Literal["inside", "outside"] = Field(description="The side of the thermal shield that they are on.")
    side: Literal["+y", "-y", "mid"] | None = Field(
        default=None, description="Their side of the symmetry plane. Left out, it is that of the centroid."
    )


class SymmetryPlaneTable(Strict):
    """A plane of the basic frame."""

    point_m: Place = Field(description="A point of the plane, basic frame.")
    normal: Direction = Field(
        description="Normal of the plane, basic frame and any length. It points to the side that is called +y."
    )

    _no_zero = field_validator("normal")(_not_zero)


class AreasTable(Strict):
    """Definitions of the areas, and rules for their attributes. No element may be in two areas of elements."""

    symmetry_plane: SymmetryPlaneTable | None = Field(
        default=None,
        description="The plane that sides and mirror pairs refer to. Else the x-z plane of the optical "
        "layout's frame, or y = 0 of the basic frame without a layout.",
    )
    mid_half_width_m: LengthOrZero = Field(
        default=1e-3, description="An area whose centroid is nearer than this to the symmetry plane is on neither side."
    )
    rule: Annotated[list[AreaRule], Field(min_length=1)] = Field(
        description="Attributes of the areas by name. The first rule that matches an area holds."
    )
    strict: bool = Field(
        default=False,
        description="Whether definitions that share grids are refused. Else a grid belongs to the first "
        "definition that it meets.",
    )
    define: list[DefinitionTable] = Field(
        default_factory=list,
        description="Definitions of areas, in this order. Without any, and without `areas_csv`, the "
        "temperature cards of the unit-load deck say what the areas are.",
    )

    @field_validator("define")
    @classmethod
    def _one_each(cls, value: list[DefinitionTable]) -> list[DefinitionTable]:
        first: dict[str, str] = {}
        for definition in value:
            # Nastran does not tell upper from lower case in labels.
            if (name := first.setdefault(definition.name.upper(), definition.name)) is not definition.name:
                raise ValueError(f"area {definition.name!r} is defined twice (as {name!r}); unite them by `also`")
        if any(d.remainder for d in [d for d in value if d.kind == "mean"][:-1]):
            raise ValueError("remainder = true must be the last definition: nothing is left for those after it")
        return value

    def has_boxes(self) -> bool:
        """Whether the positions of grids matter."""
        return any(s.boxes() for d in self.define for s in d.selections())

    def has_gradients(self) -> bool:
        """Whether the axes of elements matter."""
        return any(d.kind == "gradient" for d in self.define)
