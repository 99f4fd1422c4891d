"""Compensation masses: homogeneous cuboid blocks close to a test mass, by graded Gauss-Legendre quadrature.

A block is cut along its longest edge until each cell is small against its distance from the test mass; Gauss points
inside the cells then converge geometrically, and the order is raised until two successive orders agree.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import Literal

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import PhysicsError
from tedm_cli.gravity.bodies.cuboid import Cuboid
from tedm_cli.gravity.body_source import quantity_differences
from tedm_cli.gravity.constants import G_CODATA_2018
from tedm_cli.gravity.field import SelfGravity, self_gravity
from tedm_cli.gravity.testmass import TestMass, cuboid_gap, to_test_mass_frame

DEFAULT_TOLERANCE = 1e-9
# Half diagonal of a cell over the distance of its centre from the surface of the test mass. At 0.5 an order gains about
# a digit; a smaller value costs more cells than it saves points.
_OPENING = 0.5
_ORDERS = (2, 10)
_MAX_CELLS = 20_000


@dataclass(frozen=True)
class Tie:
    """What a block follows: grids, or the members of sets; `ids`: ranges (low, high) of their numbers.

    `file`, `key`: where the configuration says so.
    """

    kind: Literal["grid", "set"]
    ids: tuple[tuple[int, int], ...]
    file: str = ""
    key: str = ""

    @property
    def words(self) -> str:
        """`grid 4711`, `grids 4711, 4800:4810`, `set 12`."""
        several = len(self.ids) > 1 or any(low != high for low, high in self.ids)
        numbers = ", ".join(f"{low}" if low == high else f"{low}:{high}" for low, high in self.ids)
        return f"{self.kind}{'s' * several} {numbers}"


@dataclass(frozen=True, kw_only=True, eq=False)
class CompensationMass:
    """Homogeneous cuboid block, which stays still in the basic frame or, with a tie, follows grids of the structure.

    Parameters
    ----------
    name : label used in error messages.
    centre_m : [3], centre in the basic frame [m].
    size_m : [3], full edge lengths along its axes [m].
    mass_kg : mass [kg].
    axes : [3, 3], rows are the unit vectors of its edges in the basic frame; the identity by default.
    tie : what it follows.
    group : group of thermal areas whose field it counts to, or "" where it counts to the compensation masses.

    Raises
    ------
    PhysicsError
        If a length or the mass is not positive and finite, or the axes are not a rotation.
    """

    name: str
    centre_m: FloatArray
    size_m: FloatArray
    mass_kg: float
    axes: FloatArray = field(default_factory=lambda: np.eye(3))
    tie: Tie | None = None
    group: str = ""

    def __post_init__(self) -> None:
        for attribute, shape in (("centre_m", (3,)), ("size_m", (3,)), ("axes", (3, 3))):
            array = np.array(getattr(self, attribute), dtype=np.float64).reshape(shape)
            if not np.isfinite(array).all():
                raise PhysicsError(f"{attribute} of compensation mass {self.name!r} is not finite: {array.tolist()}")
            array.flags.writeable = False
            object.__setattr__(self, attribute, array)
        if not (self.size_m > 0).all() or not 0 < self.mass_kg < np.inf:
            raise PhysicsError(f"size and mass of compensation mass {self.name!r} must be positive and finite")
        if np.abs(self.axes @ self.axes.T - np.eye(3)).max() > 1e-9 or np.linalg.det(self.axes) < 0:
            raise PhysicsError(f"axes of compensation mass {self.name!r} are not a right-handed orthonormal triad")


@dataclass(frozen=True)
class BlockQuadrature:
    """How one block was integrated: cells, Gauss points per edge of a cell, estimated relative error; and its field."""

    name: str
    cells: int
    order: int
    error: float
    field: SelfGravity

    @property
    def points(self) -> int:
        """Number of quadrature points."""
        return self.cells * self.order**3


def field_of_compensation_masses(
    tm: TestMass,
    blocks: Sequence[CompensationMass],
    G: float = G_CODATA_2018,
    *,
    tolerance: float = DEFAULT_TOLERANCE,
) -> tuple[SelfGravity, float, list[BlockQuadrature]]:
    """Self-gravity of homogeneous cuboid blocks on a test mass (Montemurro 2004, section 6.3).

    Parameters
    ----------
    tm : the test mass acted upon.
    blocks : the blocks; they add up.
    G : gravitational constant [m³ kg⁻¹ s⁻²].
    tolerance : estimated error of each block's quantities, relative to the largest element of each quantity.

    Returns
    -------
    gravity : SelfGravity, in the frame of `tm`.
    error : largest estimated error over the quantities, relative to the sum of the blocks' magnitudes (blocks that
        cancel leave a larger share of the remainder).
    quadrature : how each block was integrated, with its own field.

    Raises
    ------
    PhysicsError
        If a block touches or overlaps the test mass, or stands so close that `tolerance` is out of reach.
    """
    total = self_gravity(np.zeros((0, 3)), np.zeros(0), tm)
    names = [f.name for f in fields(SelfGravity)]
    doubt, magnitude = dict.fromkeys(names, 0.0), dict.fromkeys(names, 0.0)
    quadrature = []
    for block in blocks:
        gravity, differences, how = _integrate(tm, block, G, tolerance)
        total = total + gravity
        quadrature.append(how)
        for name, (difference, scale) in differences.items():
            doubt[name] += difference
            magnitude[name] += scale
    error = max((doubt[name] / magnitude[name] for name in names if magnitude[name] > 0.0), default=0.0)
    return total, error, quadrature


def block_points(
    centre: FloatArray, half: FloatArray, block: CompensationMass, order: int
) -> tuple[FloatArray, FloatArray]:
    """Gauss-Legendre product points of the cells of a block and their masses.

    Parameters
    ----------
    centre, half : [n, 3], centres and half edge lengths of the cells, in the frame of the block [m].
    block : the block that the cells fill.
    order : points per edge of a cell.

    Returns
    -------
    points : [n order³, 3], basic frame [m].
    masses : [n order³], kg.
    """
    nodes, weights = np.polynomial.legendre.leggauss(order)  # type: ignore[no-untyped-call]
    unit = np.stack(np.meshgrid(nodes, nodes, nodes, indexing="ij"), axis=-1).reshape(1, -1, 3)
    weight = np.einsum("i,j,k->ijk", weights, weights, weights).ravel()
    local = centre[:, None, :] + half[:, None, :] * unit
    density = block.mass_kg / float(np.prod(block.size_m))
    masses = density * half.prod(axis=1)[:, None] * weight
    return block.centre_m + local.reshape(-1, 3) @ block.axes, masses.ravel()


def graded_cells(tm: TestMass, block: CompensationMass) -> tuple[FloatArray, FloatArray]:
    """Cells of a block that are small against their distance from a test mass: centres and half edge lengths, [n, 3].

    Raises
    ------
    PhysicsError
        If the block touches or overlaps the test mass, or is so close that the cells are too many.
    """
    if _gap(tm, block) <= 0.0 and isinstance(tm.body, Cuboid):
        raise _touching(tm, block)
    done_centre, done_half = [], []
    centre, half = np.zeros((1, 3)), block.size_m[None, :] / 2.0
    count = 0
    while centre.size:
        local = to_test_mass_frame(tm, block.centre_m + centre @ block.axes)
        distance = tm.body.distance(local)
        if not distance.all():
            raise _touching(tm, block)
        small = np.linalg.norm(half, axis=1) <= _OPENING * distance
        done_centre.append(centre[small])
        done_half.append(half[small])
        centre, half = centre[~small], half[~small]
        count += int(small.sum())
        if count + 2 * len(centre) > _MAX_CELLS:
            raise PhysicsError(
                f"compensation mass {block.name!r} is {_gap(tm, block):.3g} m from test mass {tm.name!r},"
                " too close for its size to be integrated",
                hint="widen the gap, or split off the part that faces the test mass",
            )
        rows, axis = np.arange(len(half)), half.argmax(axis=1)
        half = half.copy()
        half[rows, axis] /= 2.0
        shift = np.zeros_like(half)
        shift[rows, axis] = half[rows, axis]
        centre, half = np.concatenate([centre - shift, centre + shift]), np.concatenate([half, half])
    return np.concatenate(done_centre), np.concatenate(done_half)


def _integrate(
    tm: TestMass, block: CompensationMass, G: float, tolerance: float
) -> tuple[SelfGravity, dict[str, tuple[float, float]], BlockQuadrature]:
    centre, half = graded_cells(tm, block)
    coarse = self_gravity(*block_points(centre, half, block, _ORDERS[0]), tm, G=G)
    error = np.inf
    for order in range(_ORDERS[0] + 1, _ORDERS[1] + 1):
        fine = self_gravity(*block_points(centre, half, block, order), tm, G=G)
        differences = quantity_differences(fine, coarse)
        error = max((d / s for d, s in differences.values() if d > 0.0), default=0.0)
        if error <= tolerance:
            return fine, differences, BlockQuadrature(block.name, len(centre), order, error, fine)
        coarse = fine
    raise PhysicsError(
        f"quadrature over compensation mass {block.name!r} for test mass {tm.name!r} stays at an error of {error:.1e},"
        f" above the tolerance {tolerance:.1e}"
    )


def _touching(tm: TestMass, block: CompensationMass) -> PhysicsError:
    return PhysicsError(
        f"compensation mass {block.name!r} touches or overlaps test mass {tm.name!r}",
        hint="check its centre_m, size_m and rotation, in metres and radians, in the basic frame",
    )


def _gap(tm: TestMass, block: CompensationMass) -> float:
    """Gap between a block and the cuboid that holds a test mass [m]; not positive when they meet."""
    return cuboid_gap(tm.box_centre_m, tm.side_m, tm.axes, block.centre_m, block.size_m, block.axes)
