"""Configuration of a test mass: where it is, and its body, of one of several shapes."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticKnownError

from tedm_cli.arrays import FloatArray
from tedm_cli.config.base import (
    LABEL,
    Bounded,
    Direction,
    FileName,
    Id,
    Length,
    Mass,
    Offset,
    OneLine,
    OrthonormalAxes,
    Place,
    Strict,
)
from tedm_cli.errors import PhysicsError
from tedm_cli.gravity.bodies.body import Body
from tedm_cli.gravity.bodies.box import Box
from tedm_cli.gravity.bodies.composite import Composite, Pocket
from tedm_cli.gravity.bodies.cuboid import Cuboid, Sphere
from tedm_cli.gravity.bodies.cylinder import Cylinder
from tedm_cli.gravity.bodies.stl import stl_triangles
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.quantities import DENSITY, LENGTH, MASS
from tedm_cli.regular_file import require_regular_file

Edges = Length | Annotated[list[Length], Field(min_length=3, max_length=3)]
Sides = Length | Annotated[list[Length], Field(min_length=2, max_length=2)]
PlaceOnFace = Annotated[list[Offset], Field(min_length=2, max_length=2)]
Shape = Literal["cuboid", "cylinder", "sphere", "polyhedron"]

_NEEDED = {"cuboid": ("side_m",), "cylinder": ("radius_m", "height_m"), "sphere": ("radius_m",),
           "polyhedron": ("stl", "stl_unit")}  # fmt: skip
_ALLOWED = {"cuboid": ("chamfer_m", "pocket"), "cylinder": ("inner_radius_m", "axis"), "sphere": (), "polyhedron": ()}
_UNIT_M = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": 0.0254}
_AGREE = 1e-3  # of mass and density times volume, where both are given
_CLOSED, _DIAGONAL = (False, False, False), 1e-12


class ModelParts(Strict):
    """Parts of the finite-element model that stand for the test mass, and are no part of the structure's mass."""

    elements: list[Id] = Field(default_factory=list, description="Ids of elements, concentrated masses among them.")
    properties: list[Id] = Field(default_factory=list, description="Ids of properties, all of whose elements count.")
    grids: list[Id] = Field(
        default_factory=list, description="Ids of grids; an element counts whose grids are all listed."
    )


class PocketTable(Strict):
    """What is cut into a face of a cuboid, straight down: round (`diameter_m`) or rectangular (`size_m`)."""

    face: Literal["+x", "-x", "+y", "-y", "+z", "-z"] = Field(
        description="The face that the pocket is cut into, straight down."
    )
    centre_m: PlaceOnFace = Field(
        default_factory=lambda: [0.0, 0.0],
        description="Centre of the opening from the middle of the face, along the other two axes in the order x, y, z.",
    )
    diameter_m: Length | None = Field(default=None, description="Diameter of a round pocket. Either this or `size_m`.")
    size_m: Sides | None = Field(
        default=None,
        description="Sides of a rectangular pocket, along the axes of `centre_m`; one number is a square. "
        "Either this or `diameter_m`.",
    )
    depth_m: Length = Field(description="Depth of the pocket. Of the whole edge, it goes through.")
    name: OneLine | None = Field(default=None, description="Name of the pocket in messages.")

    @model_validator(mode="after")
    def _round_or_not(self) -> Self:
        if (self.diameter_m is None) == (self.size_m is None):
            raise ValueError("needs either diameter_m or size_m")
        return self

    def pocket(self, half: FloatArray, name: str) -> Pocket:
        """The pocket in a cuboid of half edges [3]; `PhysicsError` where it is deeper than that."""
        k = "xyz".index(self.face[1])
        across = [axis for axis in range(3) if axis != k]
        through = 2.0 * half[k]
        if self.depth_m > through * (1.0 + _DIAGONAL):
            raise PhysicsError(f"{name} is {self.depth_m:g} m deep, the body only {through:g} m")
        goes_through = self.depth_m >= through * (1.0 - _DIAGONAL)
        upper = self.face[0] == "+"
        low, high = -half.copy(), half.copy()
        if not goes_through:
            (low if upper else high)[k] = half[k] - self.depth_m if upper else self.depth_m - half[k]
        below, above = [False] * 3, [False] * 3
        below[k], above[k] = goes_through or not upper, goes_through or upper
        centre = np.zeros(3)
        centre[across] = self.centre_m
        if self.diameter_m is not None:
            along = np.eye(3)[k]
            solid = Cylinder(along, centre, self.diameter_m / 2.0, float(low[k]), float(high[k]))
            ends = ((False, False, below[k]), (False, False, above[k]))
            return Pocket(solid, *ends, name)
        sides = self.size_m if isinstance(self.size_m, list) else [float(self.size_m or 0.0)] * 2
        for axis, side in zip(across, sides, strict=True):
            low[axis], high[axis] = centre[axis] - side / 2.0, centre[axis] + side / 2.0
            # a side in the plane of a face is open there, and in it to the bit
            below[axis] = abs(low[axis] + half[axis]) <= _DIAGONAL * half[axis]
            above[axis] = abs(high[axis] - half[axis]) <= _DIAGONAL * half[axis]
            low[axis] = -half[axis] if below[axis] else low[axis]
            high[axis] = half[axis] if above[axis] else high[axis]
        return Pocket(Box(low, high), (below[0], below[1], below[2]), (above[0], above[1], above[2]), name)


class TestMassTable(Strict):
    """A homogeneous test mass. Which keys it has depends on its shape; its frame is about its centre of mass."""

    __test__ = False

    name: Annotated[str, Field(pattern=LABEL)] = Field(
        description="Name of the test mass, of which the labels of its outputs are made (TM1 in TM1_a_x)."
    )
    shape: Shape = Field(default="cuboid", description="Shape of its body.")
    position_m: Place = Field(
        description="Origin of the frame that its geometry is given in, basic frame: the middle of a cuboid "
        "(pockets or not), cylinder or sphere, the origin of an STL file."
    )
    side_m: Edges | None = Field(
        default=None,
        validate_default=True,
        description="Full edge lengths of a cuboid, which needs them; one number is a cube.",
    )
    chamfer_m: Length | None = Field(
        default=None,
        validate_default=True,
        description="Width, along both faces, by which all edges of a cuboid are cut at 45 degrees.",
    )
    pocket: list[PocketTable] = Field(default_factory=list, description="Pockets of a cuboid.")
    radius_m: Length | None = Field(
        default=None, validate_default=True, description="Radius of a cylinder or sphere, which need it."
    )
    inner_radius_m: Length | None = Field(
        default=None, validate_default=True, description="Radius of the bore of a hollow cylinder."
    )
    height_m: Length | None = Field(
        default=None, validate_default=True, description="Height of a cylinder, which needs it."
    )
    axis: Direction | None = Field(
        default=None,
        validate_default=True,
        description="Axis of a cylinder, in the frame of the test mass and of any length; z where left out.",
    )
    stl: FileName | None = Field(
        default=None,
        validate_default=True,
        description="STL file with the closed surface of a polyhedron, which needs it.",
    )
    stl_unit: Literal["m", "cm", "mm", "um", "in"] | None = Field(
        default=None,
        validate_default=True,
        description="Unit of the coordinates in the STL file; a polyhedron needs it.",
    )
    density_kg_m3: Annotated[float, Bounded(DENSITY)] | None = Field(
        default=None, description="Density. Either this or `mass_kg`, or both where they agree to a thousandth."
    )
    mass_kg: Mass | None = Field(
        default=None, validate_default=True, description="Mass. It counts where the density is given too."
    )
    axes: OrthonormalAxes | None = Field(
        default=None,
        description="Unit vectors of the test mass as rows, basic frame. Along the basic frame where left out.",
    )
    model_parts: ModelParts = Field(
        default=ModelParts(),
        description="What stands for the test mass in the finite-element model, and is left out of the "
        "structure's mass.",
    )

    @field_validator(*(key for keys in (*_NEEDED.values(), *_ALLOWED.values()) for key in keys))
    @classmethod
    def _of_its_shape(cls, value: Any, info: ValidationInfo) -> Any:
        shape, key = info.data.get("shape"), str(info.field_name)
        if shape is None:  # it is wrong, and said to be
            return value
        if value is None:
            if key in _NEEDED[shape]:
                raise PydanticKnownError("missing")
        elif key not in (*_NEEDED[shape], *_ALLOWED[shape]) and value != []:
            of = [name for name in _NEEDED if key in (*_NEEDED[name], *_ALLOWED[name])]
            raise ValueError(f"is a key of shape = {' or '.join(map(repr, of))}, and this one is {shape!r}")
        return value

    @field_validator("inner_radius_m")
    @classmethod
    def _smaller(cls, value: float | None, info: ValidationInfo) -> float | None:
        outer = info.data.get("radius_m")
        if value is not None and outer is not None and value >= outer:
            raise ValueError(f"inner radius {value:g} m is not smaller than radius_m, {outer:g} m")
        return value

    @field_validator("axis")
    @classmethod
    def _has_length(cls, value: list[float] | None) -> list[float] | None:
        if value is not None and np.linalg.norm(value) < _DIAGONAL:
            raise ValueError("has no length")
        return value

    @field_validator("chamfer_m")
    @classmethod
    def _fits(cls, value: float | None, info: ValidationInfo) -> float | None:
        side = info.data.get("side_m")
        if value is not None and side is not None:
            least = min(side) if isinstance(side, list) else side
            if value >= least / 2.0:
                raise ValueError(
                    f"{value:g} m leaves nothing of an edge of {least:g} m, which it shortens at both ends"
                )
        return value

    @field_validator("mass_kg")
    @classmethod
    def _mass_or_density(cls, value: float | None, info: ValidationInfo) -> float | None:
        if value is None and info.data.get("density_kg_m3", 0.0) is None:
            raise PydanticKnownError("missing")
        return value

    def body(self, folder: Path) -> Body:
        """The body, about its centre of mass; `folder` is that of the configuration file.

        Raises
        ------
        PhysicsError, OSError : what it cannot be made of.
        """
        if self.shape == "sphere":
            return Sphere(float(self.radius_m or 0.0))
        if self.shape == "cylinder":
            return self._cylinder()
        if self.shape == "polyhedron":
            path = folder / str(self.stl)
            require_regular_file(path)
            return _of_surface(path.read_bytes(), str(self.stl_unit))
        side = np.array(self.side_m if isinstance(self.side_m, list) else [self.side_m] * 3, dtype=np.float64)
        if self.chamfer_m is None and not self.pocket:
            return Cuboid(side)
        # Every command reads a configuration, and most have cuboids alone: what others need takes a while to load.
        from tedm_cli.gravity.bodies.pockets import check_pockets
        from tedm_cli.gravity.bodies.polyhedron import chamfered_cuboid

        half = side / 2.0
        base = Box(-half, half) if self.chamfer_m is None else chamfered_cuboid(side, self.chamfer_m)
        pockets = [table.pocket(half, table.name or f"pocket[{n}]") for n, table in enumerate(self.pocket)]
        check_pockets(base, pockets)
        words = f"edge lengths {side.tolist()} m"
        if self.chamfer_m is not None:
            words += f", chamfers {self.chamfer_m:g} m"
        if pockets:
            words += f", {len(pockets)} pocket" + "s" * (len(pockets) > 1)
        return Composite([base], pockets, words=words)

    def _cylinder(self) -> Body:
        axis = np.array([0.0, 0.0, 1.0] if self.axis is None else self.axis)
        axis = axis / np.linalg.norm(axis)
        half, radius = float(self.height_m or 0.0) / 2.0, float(self.radius_m or 0.0)
        outer = Cylinder(axis, np.zeros(3), radius, -half, half)
        words = f"radius {radius:g} m, height {2.0 * half:g} m"
        if self.inner_radius_m is None:
            return Composite([outer], words=words)
        bore = Cylinder(axis, np.zeros(3), self.inner_radius_m, -half, half)
        through = Pocket(bore, (False, False, True), (False, False, True), "bore")
        return Composite([outer], [through], words=f"{words}, bore {self.inner_radius_m:g} m")

    def test_mass(self, body: Body) -> TestMass:
        """The test mass with its body, as the gravity room takes it.

        Raises
        ------
        PhysicsError : mass and density contradict each other, or make a mass that is out of bounds.
        """
        by_density = None if self.density_kg_m3 is None else self.density_kg_m3 * body.volume_m3
        mass = self.mass_kg if self.mass_kg is not None else float(by_density or 0.0)
        if self.mass_kg is not None and by_density is not None and abs(by_density - mass) > _AGREE * mass:
            raise PhysicsError(
                f"density_kg_m3 {self.density_kg_m3:g} times the volume, {body.volume_m3:.6g} m^3, is"
                f" {by_density:.6g} kg, and mass_kg is {mass:.6g}: give one of them"
            )
        if fact := MASS.fact(mass) or DENSITY.fact(mass / body.volume_m3):
            hint = "lengths must be in metres, masses in kilograms"
            if self.stl_unit:
                hint = f"is stl_unit {self.stl_unit!r} right?"
            raise PhysicsError(
                f"{fact}, of a volume of {body.volume_m3:.6g} m^3 and extents of {_extents(body)} m; {hint}"
            )
        axes = np.eye(3) if self.axes is None else np.array(self.axes)
        position = np.array(self.position_m) + body.centre_m @ axes
        return TestMass(name=self.name, position_m=position, body=body, mass_kg=mass, axes=axes)


def _extents(body: Body) -> str:
    return " x ".join(f"{e:.4g}" for e in body.extent_m)


@lru_cache(maxsize=8)
def _of_surface(content: bytes, unit: str) -> Body:
    """The body that an STL file holds: a configuration is read several times by one command."""
    from tedm_cli.gravity.bodies.mesh_check import checked_polyhedron

    triangles = _UNIT_M[unit] * stl_triangles(content)
    extents = np.ptp(triangles.reshape(-1, 3), axis=0)
    if fact := LENGTH.fact(float(extents.max())) or LENGTH.fact(float(extents.min())):
        raise PhysicsError(f"extent of the surface: {fact}; is stl_unit {unit!r} right?")
    return Composite([checked_polyhedron(triangles)], words=f"surface of {len(triangles)} triangles")
