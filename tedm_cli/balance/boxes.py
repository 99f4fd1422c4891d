"""Boxes where mass may be, as the columns of a programme: parts of a box, shims of a stack, and their images."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.gravity.compensation import CompensationMass, Tie
from tedm_cli.symmetry_plane import SymmetryPlane

_DIGITS = 12  # of lengths in m and masses in kg: what a drawing says is not 0.13424999999999998
_FREE_M = 1e-7  # a block that is smaller than its box by less fills it
_WHOLE = 1e-9  # of a shim: a box that is this little short of a whole number of them holds that number


@dataclass(frozen=True, eq=False, kw_only=True)
class Image:
    """A reflection in one plane after another (none: the block itself), the suffix of its name, and its group."""

    planes: tuple[SymmetryPlane, ...] = ()
    suffix: str = ""
    group: str = ""

    def of(self, block: CompensationMass) -> CompensationMass:
        """The image of a block, a cuboid again: edges turned round so that they are right-handed, and turned least."""
        axes = block.axes
        for plane in self.planes:
            axes = axes - 2.0 * (axes @ plane.normal)[:, None] * plane.normal
        along = (axes * block.axes).sum(axis=1)
        hand = round(float(np.linalg.det(axes)))
        signs = [s for s in itertools.product((1.0, -1.0), repeat=3) if np.prod(s) == hand]
        axes = np.array(max(signs, key=lambda s: float(np.array(s) @ along)))[:, None] * axes
        centre = np.round(self.point(block.centre_m), _DIGITS)
        return replace(block, name=block.name + self.suffix, centre_m=centre, axes=axes + 0.0, group=self.group)

    def point(self, position_m: FloatArray) -> FloatArray:
        """The image of a point [3]."""
        for plane in self.planes:
            position_m = plane.image(position_m)
        return position_m


@dataclass(frozen=True, eq=False, kw_only=True)
class Box:
    """A box where mass may be.

    Parameters
    ----------
    centre_m, size_m : [3], m, basic frame; size along its own edges. axes : [3, 3], these edges as rows.
    density_kg_m3 : of the material.
    parts : numbers of parts along its edges.
    shim_m : thickness of a shim, or 0. stack : axis of the stack, and +1 or -1 for its way along that.
    step_kg, least_kg : see `Column`; 0 where the mass of a block may be any.
    most_kg : the largest mass of each block, infinite where only size and density limit it.
    images : the block itself, and its images; all have one mass.
    inner_m : [3], of a box in which the block is smaller and its place is sought: its size, or, where the size is
        sought too (`vary_size`), the least.
    """

    name: str
    centre_m: FloatArray
    size_m: FloatArray
    axes: FloatArray
    density_kg_m3: float
    parts: tuple[int, int, int] = (1, 1, 1)
    shim_m: float = 0.0
    stack: tuple[int, int] = (0, 1)
    step_kg: float = 0.0
    least_kg: float = 0.0
    most_kg: float = np.inf
    images: tuple[Image, ...] = field(default_factory=lambda: (Image(),))
    tie: Tie | None = None
    inner_m: FloatArray | None = None
    vary_size: bool = False

    @property
    def sought(self) -> int:
        """Numbers that say where the block is and how large: along each edge where there is room."""
        if self.inner_m is None:
            return 0
        free = int((self.size_m - self.inner_m > _FREE_M).sum())
        return free * (1 + self.vary_size)

    def placed(self, number: FloatArray) -> Box:
        """The box with the block that `sought` numbers from 0 to 1 say: places, then sizes, along each free edge."""
        assert self.inner_m is not None
        free = np.flatnonzero(self.size_m - self.inner_m > _FREE_M)
        size = self.inner_m.copy()
        if self.vary_size:
            size[free] += number[len(free) :] * (self.size_m - self.inner_m)[free]
        local = np.zeros(3)
        local[free] = (number[: len(free)] - 0.5) * (self.size_m - size)[free]
        return replace(self, centre_m=self.centre_m + local @ self.axes, size_m=size, inner_m=None, vary_size=False)

    @property
    def shims(self) -> int:
        """Whole shims that a stack has room for."""
        thick = float(self.size_m[self.stack[0]])
        room = int(np.floor(thick / self.shim_m + _WHOLE))
        area = float(self.size_m.prod()) / thick
        return int(min(room, np.floor(self.most_kg / (self.density_kg_m3 * area * self.shim_m) + _WHOLE)))

    def cut(self) -> list[Box]:
        """Its parts, each a box without parts; itself where there is one alone."""
        if self.parts == (1, 1, 1):
            return [self]
        size = self.size_m / np.array(self.parts)
        found = []
        for number, place in enumerate(itertools.product(*map(range, self.parts)), start=1):
            local = (np.array(place) + 0.5) * size - self.size_m / 2.0
            centre = self.centre_m + local @ self.axes
            found.append(replace(self, name=f"{self.name}_{number}", centre_m=centre, size_m=size, parts=(1, 1, 1)))
        return found

    def slab(self, first: int, count: int, name: str) -> CompensationMass:
        """Shims `first` to `first + count` of its stack as one block of full density."""
        axis, way = self.stack
        size = self.size_m.copy()
        size[axis] = count * self.shim_m
        local = np.zeros(3)
        local[axis] = way * (first * self.shim_m + (size[axis] - self.size_m[axis]) / 2.0)
        return self._block(name, self.centre_m + local @ self.axes, size, np.inf)

    @property
    def base_m(self) -> FloatArray:
        """[3], middle of the face that shims are stacked on; of a box without shims its centre."""
        local = np.zeros(3)
        if self.shim_m:
            axis, way = self.stack
            local[axis] = -way * self.size_m[axis] / 2.0
        return np.asarray(self.centre_m + local @ self.axes)

    def _block(self, name: str, centre: FloatArray, size: FloatArray, most_kg: float) -> CompensationMass:
        size = np.round(size, _DIGITS)
        mass = round(min(most_kg, self.density_kg_m3 * float(size.prod())), _DIGITS)
        centre = np.round(centre, _DIGITS) + 0.0
        return CompensationMass(name=name, centre_m=centre, size_m=size, mass_kg=mass, axes=self.axes, tie=self.tie)

    def full(self) -> CompensationMass:
        """The block that fills it, with the largest mass that it may have; of a stack, all shims."""
        if self.shim_m:
            return self.slab(0, self.shims, self.name)
        return self._block(self.name, self.centre_m, self.size_m, self.most_kg)

    def with_images(self, block: CompensationMass) -> list[CompensationMass]:
        """A block of this box, and its images."""
        return [image.of(block) for image in self.images]


@dataclass(frozen=True, eq=False, kw_only=True)
class Column:
    """One unknown of the programme: how many units of mass there are.

    Parameters
    ----------
    box : row of the part that it is of; shim : number of the shim in its stack, from 0, or -1.
    blocks : the block of one unit with its images, which weigh `unit_kg` together.
    most : largest number of units. least : least number, where there are any at all.
    whole : whether the number is whole.
    """

    name: str
    box: int
    shim: int
    blocks: tuple[CompensationMass, ...]
    unit_kg: float
    most: float
    least: float = 0.0
    whole: bool = False


def columns_of(boxes: Sequence[Box]) -> list[Column]:
    """The unknowns of boxes that are not cut any further: of a stack one for each shim, of others one.

    A unit is a shim, a step, or all that a block may weigh. Boxes that hold no whole shim or step have none.
    """
    return [column for row, box in enumerate(boxes) for column in _columns(row, box)]


def _columns(row: int, box: Box) -> Iterator[Column]:
    if box.shim_m:
        for shim in range(box.shims):
            blocks = tuple(box.with_images(box.slab(shim, 1, box.name)))
            name = f"{box.name}, shim {shim + 1}"
            mass = sum(b.mass_kg for b in blocks)
            yield Column(name=name, box=row, shim=shim, blocks=blocks, unit_kg=mass, most=1.0, whole=True)
        return
    full = box.full()
    unit, most = full.mass_kg, 1.0
    if box.step_kg:
        unit, most = box.step_kg, float(np.floor(full.mass_kg / box.step_kg + _WHOLE))
        if most < 1.0:
            return
    blocks = tuple(box.with_images(replace(full, mass_kg=unit)))
    yield Column(
        name=box.name,
        box=row,
        shim=-1,
        blocks=blocks,
        unit_kg=sum(b.mass_kg for b in blocks),
        most=most,
        least=box.least_kg / unit,
        whole=box.step_kg > 0.0,
    )


def stacked(columns: Sequence[Column]) -> list[tuple[int, int]]:
    """Pairs of columns of which the second may have mass only where the first is full: a shim lies on the one below."""
    return [
        (i, i + 1)
        for i, (below, above) in enumerate(itertools.pairwise(columns))
        if below.shim >= 0 and above.shim == below.shim + 1 and above.box == below.box
    ]


def blocks_of(
    boxes: Sequence[Box], columns: Sequence[Column], units: FloatArray, *, least_kg: float = 1e-9
) -> list[CompensationMass]:
    """The blocks that a solution [c] stands for: stacks as one block each; none that weighs less than `least_kg`."""
    found: list[CompensationMass] = []
    for row, box in enumerate(boxes):
        own = [i for i, column in enumerate(columns) if column.box == row]
        if not own:
            continue
        if box.shim_m:
            count = round(float(units[own].sum()))
            block = box.slab(0, count, box.name) if count else None
        else:
            mass = float(units[own[0]]) * columns[own[0]].blocks[0].mass_kg
            block = replace(box.full(), mass_kg=mass) if mass > least_kg else None
        found += [] if block is None else box.with_images(block)
    return found
