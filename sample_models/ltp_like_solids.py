"""The solids of the LTP-like sample: blocks of one material each, and their mesh of hexahedra.

Lengths in mm. `ltp_like.py` makes a deck of them, `ltp_like_network.py` a thermal network.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

MM = 1e-3
TEST_MASS_X = 188.0  # mm, distance of each test mass from the origin

# name: (material id, E [Pa], Poisson's ratio, density [kg/m3], expansion [1/K]); handbook values, rounded
MATERIALS = {
    "zerodur": (1, 90.3e9, 0.24, 2530.0, 2.0e-8),
    "titanium": (2, 114.0e9, 0.34, 4430.0, 8.6e-6),
    "molybdenum": (3, 320.0e9, 0.31, 10220.0, 4.8e-6),
    "tungsten": (4, 400.0e9, 0.28, 19250.0, 4.5e-6),
    "window_glass": (5, 71.0e9, 0.30, 3610.0, 10.1e-6),
    "glass_fibre": (6, 45.0e9, 0.28, 1950.0, 7.0e-6),
}

FULL_PLANES = {
    "is": [12, 27, 33, 45, 57, 60, 66, 69, 81],  # one side of the test mass; the other mirrors it
    "bench_x": [0, 33, 60, 72, 100],
    "y": [0, 12, 27, 33, 45, 57, 69, 106, 121, 133],
    "z": [0, 12, 27, 33, 45, 57, 69],
}
SMALL_PLANES = {
    "is": [27, 33],
    "bench_x": [33, 100],
    "y": [0, 27, 33, 106, 121],
    "z": [12, 27, 33, 57],
}


@dataclass(frozen=True)
class Block:
    """An axis-parallel block of one material (None: void) that overrides the blocks before it. Lengths in mm."""

    area: str
    material: str | None
    x: tuple[float, float]
    y: tuple[float, float]
    z: tuple[float, float]


def inertial_sensor_full(number: int) -> Iterable[Block]:
    """Vacuum enclosure, window, electrode housing, supports, caging, compensation masses, brackets: 26 areas.

    Blocks are given for the sensor at +x, seen from its test mass, with u pointing away from the bench.
    """
    s = f"IS{number}_"
    void = ("", None)
    # Vacuum enclosure, 12 mm titanium, as six walls laid over a solid block whose inside is then emptied.
    yield Block(s + "VE_UP", "titanium", (-69, 69), (-69, 69), (-69, 69))
    yield Block(s + "VE_DOWN", "titanium", (-69, 69), (-69, 69), (-69, -57))
    yield Block(s + "VE_PLUS_Y", "titanium", (-69, 69), (57, 69), (-57, 57))
    yield Block(s + "VE_MINUS_Y", "titanium", (-69, 69), (-69, -57), (-57, 57))
    yield Block(s + "VE_OUTER", "titanium", (57, 69), (-57, 57), (-57, 57))
    yield Block(s + "VE_INNER", "titanium", (-69, -57), (-57, 57), (-57, 57))
    yield Block(*void, (-57, 57), (-57, 57), (-57, 57))
    yield Block(*void, (-69, -57), (-12, 12), (-12, 12))
    yield Block(s + "WINDOW", "window_glass", (-66, -60), (-12, 12), (-12, 12))
    # Electrode housing, 6 mm molybdenum, 4 mm from the faces of the 46 mm test mass, open towards the window.
    yield Block(s + "EH_UP", "molybdenum", (-33, 33), (-33, 33), (-33, 33))
    yield Block(s + "EH_DOWN", "molybdenum", (-33, 33), (-33, 33), (-33, -27))
    yield Block(s + "EH_PLUS_Y", "molybdenum", (-33, 33), (27, 33), (-27, 27))
    yield Block(s + "EH_MINUS_Y", "molybdenum", (-33, 33), (-33, -27), (-27, 27))
    yield Block(s + "EH_OUTER", "molybdenum", (27, 33), (-27, 27), (-27, 27))
    yield Block(s + "EH_INNER", "molybdenum", (-33, -27), (-27, 27), (-27, 27))
    yield Block(*void, (-27, 27), (-27, 27), (-27, 27))
    yield Block(*void, (-33, -27), (-12, 12), (-12, 12))
    # Four supports, each a pair of posts to the top and the bottom of the enclosure.
    for u, uname in ((-33, "INNER"), (27, "OUTER")):
        for v, vname in ((-33, "MINUS_Y"), (27, "PLUS_Y")):
            for w in ((-57, -33), (33, 57)):
                yield Block(f"{s}SUPPORT_{uname}_{vname}", "titanium", (u, u + 6), (v, v + 6), w)
    for w, wname in (((-57, -45), "DOWN"), ((45, 57), "UP")):
        yield Block(f"{s}CAGING_{wname}", "titanium", (-12, 12), (-12, 12), w)
    for v, vname in (((-27, -12), "MINUS_Y"), ((12, 27), "PLUS_Y")):
        yield Block(f"{s}CM_OUTER_{vname}", "tungsten", (33, 45), v, (-27, 27))
    for v, vname in (((-45, -33), "MINUS_Y"), ((33, 45), "PLUS_Y")):
        yield Block(f"{s}CM_SIDE_{vname}", "tungsten", (-12, 12), v, (-12, 12))
    for v, vname in (((-106, -69), "MINUS_Y"), ((69, 106), "PLUS_Y")):
        yield Block(f"{s}BRACKET_{vname}", "titanium", (-27, 27), v, (-27, 27))
    yield Block(s + "PUMP", "titanium", (69, 81), (-27, 27), (-27, 27))


def inertial_sensor_small(number: int) -> Iterable[Block]:
    """The electrode housing alone, with the brackets that hold it: 6 areas."""
    s = f"IS{number}_"
    yield Block(s + "EH_UP", "titanium", (-33, 33), (-33, 33), (-33, 33))
    yield Block(s + "EH_DOWN", "titanium", (-33, 33), (-33, 33), (-33, -27))
    yield Block(s + "EH_OUTER", "titanium", (27, 33), (-33, 33), (-27, 27))
    yield Block(s + "EH_INNER", "titanium", (-33, -27), (-33, 33), (-27, 27))
    yield Block("", None, (-27, 27), (-27, 27), (-27, 27))
    for v, vname in (((-106, -33), "MINUS_Y"), ((33, 106), "PLUS_Y")):
        yield Block(f"{s}BRACKET_{vname}", "titanium", (-33, 33), v, (-33, -12))


def bench_blocks(detail: str) -> Iterable[Block]:
    """Bench, sidewalls and stiffeners: 14 areas (full) or 5 (small)."""
    x_end = TEST_MASS_X + 33
    if detail == "small":
        yield Block("OB_BENCH_MINUS_Y", "zerodur", (-100, 100), (-106, 0), (-57, -12))
        yield Block("OB_BENCH_PLUS_Y", "zerodur", (-100, 100), (0, 106), (-57, -12))
        yield Block("OB_SIDEWALL_MINUS_Y", "zerodur", (-x_end, x_end), (-121, -106), (-57, -12))
        yield Block("OB_SIDEWALL_PLUS_Y", "zerodur", (-x_end, x_end), (106, 121), (-57, -12))
        return
    # The middle comes last so that it owns both its borders: the areas mirror in x as the structure does.
    for x, xname in (((-100, -33), "LEFT"), ((33, 100), "RIGHT"), ((-33, 33), "MID")):
        yield Block(f"OB_BENCH_{xname}_MINUS_Y", "zerodur", x, (-106, 0), (-57, -12))
        yield Block(f"OB_BENCH_{xname}_PLUS_Y", "zerodur", x, (0, 106), (-57, -12))
    for x, xname in (((-x_end, -100), "LEFT"), ((100, x_end), "RIGHT"), ((-100, 100), "MID")):
        yield Block(f"OB_SIDEWALL_{xname}_MINUS_Y", "zerodur", x, (-121, -106), (-69, 33))
        yield Block(f"OB_SIDEWALL_{xname}_PLUS_Y", "zerodur", x, (106, 121), (-69, 33))
    for x, xname in (((-72, -60), "LEFT"), ((60, 72), "RIGHT")):
        yield Block(f"OB_STIFFENER_{xname}", "zerodur", x, (-106, 106), (-69, -57))


@dataclass(frozen=True)
class Concentrated:
    """A concentrated mass at a mesh node (mm) of an inertial sensor, seen from its test mass, and the area it is on."""

    name: str
    area: str
    u: float
    z: float
    kg: float


CONCENTRATED = (
    Concentrated("CAGING_DRIVE_DOWN", "CAGING_DOWN", 0.0, -45.0, 0.3),
    Concentrated("CAGING_DRIVE_UP", "CAGING_UP", 0.0, 45.0, 0.3),
    Concentrated("FEE", "PUMP", 81.0, 0.0, 0.5),
)
#: of the small model, on the hubs of two flanges (kg)
HUB_MASSES = {1: 0.12, 3: 0.12}


def blocks(detail: str, flanges: Iterable[Block]) -> list[Block]:
    """All blocks of the model, in order of precedence, the mirrored sensor 1 and the flanges of a mount included."""
    sensor = inertial_sensor_full if detail == "full" else inertial_sensor_small
    out: list[Block] = list(bench_blocks(detail))
    for number, sign in ((1, -1), (2, 1)):
        for b in sensor(number):
            x = sorted((sign * (TEST_MASS_X + b.x[0]), sign * (TEST_MASS_X + b.x[1])))
            out.append(Block(b.area, b.material, (x[0], x[1]), b.y, b.z))
    return [*out, *flanges]


def subdivide(planes: Iterable[float], size: float) -> np.ndarray:
    """Sorted planes (mm) with every gap cut into equal parts no longer than `size`; rounded to the nanometre."""
    base = sorted(set(planes))
    out = [base[0]]
    for a, b in pairwise(base):
        n = max(1, math.ceil((b - a) / size - 1e-9))
        out += [a + (b - a) * i / n for i in range(1, n + 1)]
    return np.round(np.array(out, dtype=float), 6)


def grid_planes(
    detail: str, size: float, more: Mapping[str, Sequence[float]]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The planes of the tensor grid along x, y and z (mm), with more of them by axis."""
    p = FULL_PLANES if detail == "full" else SMALL_PLANES
    u = [0.0, *p["is"], *(-v for v in p["is"])] if detail == "full" else [*p["is"], *(-v for v in p["is"])]
    half = [TEST_MASS_X + v for v in u] + p["bench_x"]
    x = subdivide([*half, *(-v for v in half)], size)
    y = subdivide([*p["y"], *(-v for v in p["y"]), *more.get("y", ())], size)
    z = subdivide([*p["z"], *(-v for v in p["z"]), *more.get("z", ())], size)
    return x, y, z


@dataclass
class Mesh:
    """Solid mesh: coordinates in mm, hexahedra in Nastran order with their block, and the area of each node."""

    xyz: np.ndarray
    hexes: np.ndarray
    block: list[Block]
    area: list[str]

    def find(self, x: float, y: float, z: float) -> int:
        hit = np.nonzero((np.abs(self.xyz - np.array([x, y, z])) < 1e-6).all(axis=1))[0]
        if len(hit) != 1:
            raise SystemExit(f"no single mesh node at ({x}, {y}, {z}) mm")
        return int(hit[0])


def mesh(detail: str, size: float, flanges: Iterable[Block], more: Mapping[str, Sequence[float]]) -> Mesh:
    """The solids of the model, with the flanges of a mount and the planes that these need."""
    # The two sensors share no node, so the relative order of their blocks does not matter.
    return fill(grid_planes(detail, size, more), blocks(detail, flanges))


def owners(planes: tuple[np.ndarray, np.ndarray, np.ndarray], all_blocks: list[Block]) -> np.ndarray:
    """Number of the block that each cell [nx, ny, nz] of the tensor grid is of; -1 where it is void."""
    centres = [(p[:-1] + p[1:]) / 2 for p in planes]
    owner = np.full(tuple(len(c) for c in centres), -1)
    for n, b in enumerate(all_blocks):
        ix = [np.nonzero((c > lo) & (c < hi))[0] for c, (lo, hi) in zip(centres, (b.x, b.y, b.z), strict=True)]
        owner[np.ix_(*ix)] = n if b.material else -1
    return owner


def fill(planes: tuple[np.ndarray, np.ndarray, np.ndarray], all_blocks: list[Block]) -> Mesh:
    """Fill the tensor grid with the blocks; a node belongs to the area of the last block that has a cell at it."""
    owner = owners(planes, all_blocks)
    cells = np.argwhere(owner >= 0)
    n_planes = tuple(len(p) for p in planes)
    corner = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])
    lattice = np.ravel_multi_index(tuple((cells[:, None, :] + corner).transpose(2, 0, 1)), n_planes)
    used, hexes = np.unique(lattice, return_inverse=True)
    hexes = hexes.reshape(lattice.shape)
    index = np.array(np.unravel_index(used, n_planes)).T
    xyz = np.stack([planes[a][index[:, a]] for a in range(3)], axis=1)
    cell_owner = owner[tuple(cells.T)]
    node_owner = np.full(len(used), -1)
    np.maximum.at(node_owner, hexes.ravel(), np.repeat(cell_owner, 8))
    return Mesh(
        xyz,
        hexes,
        [all_blocks[o] for o in cell_owner],
        [all_blocks[o].area for o in node_owner],
    )
