"""Configuration of what balances the field at rest: boxes where mass may be, where it may not, and how far to go."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, field_validator, model_validator

from tedm_cli.arrays import FloatArray
from tedm_cli.config.base import (
    Bounded,
    Duration,
    FileName,
    Length,
    LengthOrZero,
    Mass,
    OneLine,
    OrthonormalAxes,
    Place,
    Strict,
    named_by_project,
)
from tedm_cli.config.base import load as load_table
from tedm_cli.config.model.areas import Ids, id_ranges, ranges_increase
from tedm_cli.config.model.body import Edges
from tedm_cli.config.model.file import RotationVector, axes_of_rotation
from tedm_cli.errors import ConfigError
from tedm_cli.files.provenance import ConfigFile
from tedm_cli.gravity.compensation import Tie
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.quantities import (
    BOX_PARTS,
    DENSITY,
    DRAWS,
    LIMIT_MARGIN,
    POSITION_DEVIATION,
    RELATIVE_DEVIATION,
    SEARCH_STEPS,
    SEED,
    SIGMAS,
    TIED_GRIDS,
)

BASIC = "basic"
Parts = Annotated[list[Annotated[int, Bounded(BOX_PARTS)]], Field(min_length=3, max_length=3)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]{1,64}$")]


class CuboidTable(Strict):
    """A cuboid in space, by two corners or by centre and size."""

    name: Name = Field(description="Its name, in prints and results.")
    frame: OneLine = Field(
        default=BASIC,
        description='"basic", or the name of a test mass: lengths are along its axes from its centre of mass then.',
    )
    low_m: Place | None = Field(default=None, description="Its corner with the least coordinates, with `high_m`.")
    high_m: Place | None = Field(default=None, description="Its corner with the largest coordinates.")
    centre_m: Place | None = Field(default=None, description="Its centre, with `size_m`, in place of corners.")
    size_m: Edges | None = Field(default=None, description="Full edge lengths; one number is a cube.")
    rotation_rad: RotationVector | None = Field(
        default=None, description="Rotation vector that turns it about its centre from its frame. This or `axes`."
    )
    axes: OrthonormalAxes | None = Field(
        default=None, description="Unit vectors along its edges, as rows, in its frame. This or `rotation_rad`."
    )

    @model_validator(mode="after")
    def _one_way_to_say_it(self) -> CuboidTable:
        corners, middle = (self.low_m, self.high_m), (self.centre_m, self.size_m)
        if None in corners and None in middle:
            raise ValueError("needs either low_m and high_m, or centre_m and size_m")
        if any(v is not None for v in corners) and any(v is not None for v in middle):
            raise ValueError("has both corners and centre_m or size_m")
        if self.low_m is not None and self.high_m is not None:
            for axis, low, high in zip("xyz", self.low_m, self.high_m, strict=True):
                if not low < high:
                    raise ValueError(f"low_m is not below high_m along {axis} ({low:g} and {high:g})")
        if self.rotation_rad is not None and self.axes is not None:
            raise ValueError("has both rotation_rad and axes")
        return self

    def place(self, test_masses: list[TestMass]) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Centre [3] and edges [3] (m), and axes [3, 3] as rows, basic frame."""
        if self.low_m is not None and self.high_m is not None:
            low, high = np.array(self.low_m), np.array(self.high_m)
            centre, size = (low + high) / 2.0, high - low
        else:
            assert self.centre_m is not None
            assert self.size_m is not None
            centre = np.array(self.centre_m)
            size = np.array(self.size_m if isinstance(self.size_m, list) else [self.size_m] * 3)
        axes = np.array(self.axes) if self.axes is not None else axes_of_rotation(self.rotation_rad or [0.0] * 3)
        if self.frame == BASIC:
            return centre, size, axes
        tm = next(tm for tm in test_masses if tm.name == self.frame)
        return tm.position_m + centre @ tm.axes, size, axes @ tm.axes


class KeepOutTable(CuboidTable):
    """A cuboid where no mass may be, such as the way of a beam."""


class BoxTable(CuboidTable):
    """A box where mass may be: one block that fills it with less than its full density, or whole shims in a stack."""

    density_kg_m3: Annotated[float, Bounded(DENSITY)] = Field(description="Density of the material.")
    parts: Parts = Field(
        default=[1, 1, 1],
        description="Number of parts that the box is cut into along its edges; each has a mass of its own.",
    )
    shim_m: Length | None = Field(
        default=None,
        description="Thickness of a shim: the mass is a whole number of shims, stacked along `stack` without gaps.",
    )
    stack: Literal["+x", "-x", "+y", "-y", "+z", "-z"] | None = Field(
        default=None,
        description="The way in which shims are stacked, along the edges of the box: from its low face up, or from its "
        "high face down.",
    )
    step_kg: Mass | None = Field(
        default=None, description="Without shims: the mass of each block is a whole number of these, in the same size."
    )
    least_kg: Mass | None = Field(
        default=None, description="Without shims and steps: the least mass of a block that is there at all."
    )
    most_kg: Mass | None = Field(
        default=None, description="The largest mass of each block. Left out: what its size and density hold."
    )
    mirror: bool = Field(
        default=False, description="Whether each block has an image of the same mass behind the symmetry plane."
    )
    alike: bool = Field(
        default=False,
        description="Whether each block has an image of the same mass at the other test mass, behind the plane midway.",
    )
    block_m: Edges | None = Field(
        default=None,
        description="Full edge lengths of the block, along the edges of the box, where it is smaller than the box: its "
        "place in the box is sought. Not with parts or shims.",
    )
    search_size: bool = Field(
        default=False, description="Whether the size is sought too, between `block_m` and that of the box."
    )
    around: bool = Field(
        default=False,
        description="Whether parts that meet a test mass, the structure or a keep-out are left out. Otherwise they are "
        "an error.",
    )
    group: OneLine | None = Field(
        default=None,
        description="Group of thermal areas whose subsystem the blocks count to. Left out: that of the compensation "
        "masses.",
    )
    alike_group: OneLine | None = Field(
        default=None, description="The same of the images at the other test mass. Left out: as `group`."
    )
    grid: Ids | None = Field(default=None, description="Grids that the block follows. Not with parts or images.")
    nearest_grids: Annotated[int, Bounded(TIED_GRIDS)] | None = Field(
        default=None,
        description="Ties every block to so many grids of the structure, those nearest to the middle of the face that "
        "it is stacked on, or to its centre; to more where these are in a line, or others are as near. Left out: "
        "blocks stay still.",
    )

    _order = field_validator("grid")(ranges_increase)

    @model_validator(mode="after")
    def _keys_that_go_together(self) -> BoxTable:
        if (self.shim_m is None) != (self.stack is None):
            raise ValueError("shim_m and stack go together")
        steps = [key for key in ("shim_m", "step_kg", "least_kg") if getattr(self, key) is not None]
        if len(steps) > 1:
            raise ValueError(f"has both {' and '.join(steps)}")
        if self.shim_m is not None and self.parts["xyz".index(self.direction[1])] != 1:
            raise ValueError(f"parts along the stack ({self.direction[1]}) must be 1")
        if self.alike_group is not None and not self.alike:
            raise ValueError("alike_group is of images at the other test mass; alike = true makes them")
        if self.grid is not None and (self.nearest_grids is not None or self.mirror or self.alike):
            other = "nearest_grids" if self.nearest_grids is not None else "images"
            raise ValueError(f"has both grid and {other}; nearest_grids ties blocks with images")
        if self.search_size and self.block_m is None:
            raise ValueError("search_size needs block_m, the least size")
        if self.block_m is not None and (self.shim_m is not None or self.parts != [1, 1, 1]):
            raise ValueError(f"has both block_m and {'shim_m' if self.shim_m is not None else 'parts'}")
        if self.least_kg is not None and self.most_kg is not None and self.least_kg > self.most_kg:
            raise ValueError(f"least_kg ({self.least_kg:g}) is above most_kg ({self.most_kg:g})")
        return self

    @property
    def direction(self) -> str:
        """The way of the stack, "+x" where there is none."""
        return self.stack or "+x"

    def inner(self, size: FloatArray) -> FloatArray | None:
        """Size of the block [3] in a box of this size, m; `ValueError` where it is larger."""
        if self.block_m is None:
            return None
        inner = np.array(self.block_m if isinstance(self.block_m, list) else [self.block_m] * 3)
        if (inner > size * (1.0 + 1e-9)).any():
            raise ValueError(f"block_m {inner.tolist()} is larger than the box {size.round(9).tolist()}")
        return np.minimum(inner, size)

    def tie(self) -> Tie | None:
        """The grids that are named."""
        return None if self.grid is None else Tie("grid", tuple(id_ranges(self.grid)))


class SearchTable(Strict):
    """How places and sizes of blocks are sought that are smaller than their boxes (`block_m`)."""

    generations: Annotated[int, Bounded(SEARCH_STEPS)] = Field(
        default=30, description="Most generations of the differential evolution."
    )
    population: Annotated[int, Bounded(SEARCH_STEPS)] = Field(
        default=8, description="Members of the population for each number that is sought."
    )
    seed: Annotated[int, Bounded(SEED)] = Field(default=1, description="Seed of the random start.")


class ToleranceTable(Strict):
    """How exactly masses and places are known: what the balance leaves room for, and builds are drawn from."""

    sum: Literal["worst case", "root sum of squares"] = Field(
        default="root sum of squares",
        description='How deviations add up: "worst case", all at once; "root sum of squares", as independent ones do.',
    )
    sigmas: Annotated[float, Bounded(SIGMAS)] = Field(
        default=3.0, description="Standard deviations that the limits leave room for, besides the margin."
    )
    block_mass: Annotated[float, Bounded(RELATIVE_DEVIATION)] = Field(
        default=0.0, description="Standard deviation of the mass of each block, relative."
    )
    block_position_m: Annotated[float, Bounded(POSITION_DEVIATION)] = Field(
        default=0.0, description="Standard deviation of the place of each block along each axis of the basic frame."
    )
    parts: FileName | None = Field(
        default=None,
        description='A CSV `part,sigma_mass,sigma_position_m` of parts of the model: "property 12", "area NAME", or '
        '"grid 4711" for the concentrated masses on it; deviations as of blocks. Every part is moved as one.',
    )
    draws: Annotated[int, Bounded(DRAWS)] = Field(default=10_000, description="Builds that are drawn for the yield.")
    seed: Annotated[int, Bounded(SEED)] = Field(default=1, description="Seed of the draws.")


class BalanceConfig(Strict):
    """What balances the field at rest: boxes where mass may be, and how far limits are kept."""

    margin: Annotated[float, Bounded(LIMIT_MARGIN)] = Field(
        default=0.1, description="Part of every limit that the balanced field leaves free."
    )
    clearance_m: LengthOrZero = Field(default=1e-3, description="Least gap between a block and a test mass.")
    structure: Literal["keep out", "ignore"] = Field(
        default="keep out",
        description='"keep out": no block may reach into the cuboid, along the basic axes, that holds an element with '
        'mass. "ignore": they may.',
    )
    existing: Literal["keep", "replace"] = Field(
        default="keep",
        description="Whether compensation masses that the model has already pull as they are, or are taken out.",
    )
    subsystems: list[OneLine] | None = Field(
        default=None,
        description='Subsystems whose limits count, as prints name them: "IS", "IS+LTP", "all". Left out: all limits.',
    )
    goal: Literal["least worst ratio", "most met"] = Field(
        default="least worst ratio",
        description="Where not all limits can be met together: make the worst ratio as small as it can be, or meet as "
        "many as can be.",
    )
    time_limit_s: Duration = Field(default=60.0, description="Time that the search for whole shims may take.")
    tolerance: ToleranceTable | None = Field(
        default=None, description="Tolerances of blocks and parts. Without it none has any, and no yield is drawn."
    )
    search: SearchTable = Field(default=SearchTable(), description="The search for places and sizes.")
    box: list[BoxTable] = Field(min_length=1, description="Boxes where mass may be.")
    keep_out: list[KeepOutTable] = Field(default_factory=list, description="Cuboids where no mass may be.")

    @model_validator(mode="after")
    def _names_differ(self) -> BalanceConfig:
        for what, tables in (("boxes", self.box), ("keep-outs", self.keep_out)):
            if twice := [name for name, n in Counter(table.name for table in tables).items() if n > 1]:
                raise ValueError(f"two {what} have the same name: {', '.join(twice)}")
        return self


def load_balance(path: Path, test_masses: list[TestMass], groups: set[str]) -> tuple[ConfigFile, BalanceConfig]:
    """Read the file, for a model with these test masses and groups of areas.

    Raises
    ------
    ConfigError : every problem of the tables, then names that the model does not have.
    """
    file, config = load_table(BalanceConfig, path, hint=named_by_project("balance"))
    names = [tm.name for tm in test_masses]
    problems = []
    for kind, tables in (("box", config.box), ("keep_out", config.keep_out)):
        for number, table in enumerate(tables):
            if table.frame != BASIC and table.frame not in names:
                there = ", ".join((BASIC, *names))
                problems.append((f"{kind}[{number}].frame", f"there is no frame {table.frame!r}; there are: {there}"))
    for number, box in enumerate(config.box):
        for key in ("group", "alike_group"):
            name = getattr(box, key)
            if name is not None and name not in groups:
                there = ", ".join(sorted(groups)) or "none"
                problems.append((f"box[{number}].{key}", f"no area has the group {name!r}; there are: {there}"))
        if box.alike and len(names) != 2:
            problems.append((f"box[{number}].alike", f"images are between two test masses; the model has {len(names)}"))
    if problems:
        raise ConfigError(problems, where=str(path))
    return file, config
