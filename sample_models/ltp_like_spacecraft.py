"""A spacecraft around the LTP-like sample: sandwich panels, units and tanks. Synthetic, not flight data. Lengths in mm.

A bay of eight walls holds the LTP: the struts end on its walls at +y and -y and on its floor. Eight shear walls lead
from its corners to the eight outer panels; decks close the ring at top and bottom; the solar array stands on posts
above the upper deck. Panels are shells of a sandwich, units and tanks concentrated masses that follow the nodes of a
panel around them (RBE3). Structure and panels are mirror symmetric across the x-z and the y-z plane; units are not.

Nothing outside holds a spacecraft in flight. Here the mean motion of the bay's corners at its floor is held (RBE3): six
freedoms, as many as a rigid body has, so that nothing is stressed. What moves, moves against the bay.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from deck_cards import field8, grid_card, list_card, real8, round_bar
from ltp_like_mounts import Strut
from ltp_like_solids import MM, subdivide

Point = tuple[float, float]
SIDES = ("PX", "PX_PY", "PY", "MX_PY", "MX", "MX_MY", "MY", "PX_MY")  # of an octagon, counter-clockwise from +x
BAY = ((400, -120), (400, 120), (270, 238), (-270, 238), (-400, 120), (-400, -120), (-270, -238), (270, -238))
TOP, BOTTOM, FLOOR, ARRAY = 300.0, -560.0, -208.0, 350.0
BODY, ARRAY_EDGE = 900.0, 1300.0  # distances of the sides of regular octagons from the z axis
HOLE = 0.15  # opening in the middle of the array, as a share of the bay
ALONG_Y_WALL = [0, 53, 106, 128, 150, 188, 226, 248, 270]  # x of nodes, with the feet of struts amid three by three
ACROSS_FLOOR = [0, 45, 89.5, 119.5, 149.5, 194, 238]
LEVELS = [BOTTOM, FLOOR, -132, -110, -88, 88, 110, 132, TOP]
FOOT_HALF = 45.0  # mm, of the nodes that the foot of a strut follows
UNIT_HALF = 200.0
SIZE = 130.0  # mm, longest edge of a shell between the planes above
CFRP, CORE, ALUMINIUM, WEIGHTLESS = 7, 8, 9, 10
FIRST_GRID, FIRST_UNIT, HELD, FIXED, FIRST_ELEMENT = 600001, 700001, 790001, 790002, 600001

#: id, E (Pa), Poisson's ratio, density (kg/m3), expansion (1/K): quasi-isotropic laminate, honeycomb in shear, posts
MATERIAL_CARDS = (
    (CFRP, 60.0e9, 0.30, 1600.0, 2.0e-6),
    (CORE, 0.52e9, 0.30, 50.0, 2.0e-6),
    (ALUMINIUM, 70.0e9, 0.33, 2700.0, 23.0e-6),
)


@dataclass(frozen=True)
class Sandwich:
    """Two equal skins on a core, and what else a square metre carries: core, inserts, harness, foil (kg/m2)."""

    pid: int
    skin_mm: float
    core_mm: float
    carried: float

    def card(self) -> str:
        """PSHELL of the skins' thickness; bending about the middle, shear through the core."""
        t = 2 * self.skin_mm
        bending = 12 * (t / 2 * (self.core_mm + self.skin_mm) ** 2 / 2) / t**3
        values = ["PSHELL", self.pid, CFRP, real8(t * MM), CFRP, real8(bending), CORE, real8(self.core_mm / t)]
        return field8(*values, real8(self.carried))


PANEL = Sandwich(21, 0.5, 20.0, 3.0)
BAY_WALL = Sandwich(22, 1.0, 20.0, 3.0)
SOLAR = Sandwich(23, 0.25, 22.0, 4.2)


@dataclass(frozen=True)
class Unit:
    """A box or a tank: its centre (mm), mass, and the area whose nodes it follows."""

    name: str
    area: str
    at: tuple[float, float, float]
    kg: float


#: round numbers of the usual size; the first four are also in the thermal network of the LTP alone
UNITS = (
    Unit("FEE_1", "SC_BAY_MX", (-450.0, 0.0, -110.0), 4.0),
    Unit("FEE_2", "SC_BAY_PX", (450.0, 0.0, -110.0), 4.0),
    Unit("PHASEMETER", "SC_PANEL_PY", (0.0, 820.0, -130.0), 8.0),
    Unit("LASER", "SC_PANEL_MY", (0.0, -820.0, -130.0), 10.0),
    Unit("BATTERY", "SC_PANEL_MX_MY", (-580.0, -580.0, -300.0), 30.0),
    Unit("POWER", "SC_PANEL_MX_PY", (-580.0, 580.0, -300.0), 25.0),
    Unit("COMPUTER", "SC_PANEL_PX_PY", (580.0, 580.0, -300.0), 20.0),
    Unit("TRANSPONDERS", "SC_PANEL_PX_MY", (580.0, -580.0, -300.0), 20.0),
    Unit("THRUSTERS_PY", "SC_PANEL_PY", (0.0, 940.0, 100.0), 18.0),
    Unit("THRUSTERS_MY", "SC_PANEL_MY", (0.0, -940.0, 100.0), 18.0),
    Unit("THRUSTER_ELECTRONICS", "SC_PANEL_PX", (820.0, 0.0, -250.0), 20.0),
    Unit("STAR_TRACKERS", "SC_PANEL_MX", (-820.0, 0.0, 100.0), 14.0),
    Unit("TANK_1", "SC_DECK_BOTTOM_MX", (-650.0, 0.0, -450.0), 22.0),
    Unit("TANK_2", "SC_DECK_BOTTOM_PX_PY", (470.0, 470.0, -450.0), 22.0),
    Unit("TANK_3", "SC_DECK_BOTTOM_PX_MY", (470.0, -470.0, -450.0), 22.0),
    Unit("ADAPTER_RING", "SC_FLOOR", (0.0, 0.0, -560.0), 20.0),
)


def octagon(distance: float) -> list[Point]:
    """Corners of a regular octagon whose sides are at a distance from its middle; side n from corner n to n + 1."""
    turn = np.deg2rad(45 * np.arange(8) - 22.5)
    r = distance / np.cos(np.pi / 8)
    return [(float(r * np.cos(a)), float(r * np.sin(a))) for a in turn]


class Shells:
    """Nodes and quadrilaterals as surfaces are added; a node is of the last surface that has it."""

    def __init__(self) -> None:
        self.number: dict[tuple[float, float, float], int] = {}
        self.area: list[str] = []
        self.quads: list[tuple[int, list[int]]] = []

    @property
    def xyz(self) -> np.ndarray:
        return np.array(list(self.number))

    def add(self, area: str, pid: int, at: np.ndarray) -> None:
        """A grid of nodes [m, n, 3] (mm) with a shell in each of its cells."""
        keys = [[tuple(float(v) + 0.0 for v in np.round(p, 6)) for p in row] for row in at]
        ids = [[self.number.setdefault(key, len(self.number)) for key in row] for row in keys]
        self.area += [""] * (len(self.number) - len(self.area))
        for n in {n for row in ids for n in row}:
            self.area[n] = area
        for low, high in pairwise(ids):
            self.quads += [(pid, [low[j], high[j], high[j + 1], low[j + 1]]) for j in range(len(low) - 1)]

    def near(self, area: str, at: Sequence[float] | np.ndarray, half: float) -> list[int]:
        """Nodes of an area within a box around a place."""
        close = (np.abs(self.xyz - np.asarray(at)) <= half).all(axis=1)
        return [int(n) for n in np.flatnonzero(close) if self.area[n] == area]


def along(start: Point, end: Point, side: str) -> np.ndarray:
    """Points [n, 2] along a side, from corner to corner; on those of y where the feet of struts need them."""
    if side in ("PY", "MY"):
        x = np.array([*(-v for v in ALONG_Y_WALL[:0:-1]), *ALONG_Y_WALL], dtype=float)
        share = (x - x[0]) / (x[-1] - x[0])
    else:
        share = np.linspace(0.0, 1.0, 5)
    return np.asarray(start) + share[:, None] * (np.asarray(end) - np.asarray(start))


def ring(inner: Sequence[Point], outer: Sequence[Point], cells: int) -> list[np.ndarray]:
    """Points [cells + 1, n, 2] between the sides of two octagons, side by side."""
    out = []
    for n, side in enumerate(SIDES):
        low, high = (along(p[n], p[(n + 1) % 8], side) for p in (inner, outer))
        out.append(low + np.linspace(0.0, 1.0, cells + 1)[:, None, None] * (high - low))
    return out


def upright(points: np.ndarray, z: np.ndarray) -> np.ndarray:
    """A wall [n, levels, 3] on points [n, 2]."""
    flat = np.broadcast_to(points[:, None, :], (len(points), len(z), 2))
    return np.concatenate([flat, np.broadcast_to(z[None, :, None], (len(points), len(z), 1))], axis=2)


def level(points: np.ndarray, z: float) -> np.ndarray:
    return np.concatenate([points, np.full((*points.shape[:2], 1), z)], axis=2)


def shells() -> Shells:
    """All panels. Of nodes at an edge: walls take them from panels, these from decks."""
    out, body, z = Shells(), octagon(BODY), subdivide(LEVELS, SIZE)
    decks = ring(BAY, body, 5)
    for name, height in (("TOP", TOP), ("BOTTOM", BOTTOM)):
        for side, points in zip(SIDES, decks, strict=True):
            out.add(f"SC_DECK_{name}_{side}", PANEL.pid, level(points, height))
    floor = [np.array([*(-v for v in half[:0:-1]), *half], dtype=float) for half in (ALONG_Y_WALL, ACROSS_FLOOR)]
    out.add("SC_FLOOR", BAY_WALL.pid, level(np.stack(np.meshgrid(*floor, indexing="ij"), axis=2), FLOOR))
    for side, points in zip(SIDES, decks, strict=True):
        out.add(f"SC_BAY_{side}", BAY_WALL.pid, upright(points[0], z))
        out.add(f"SC_PANEL_{side}", PANEL.pid, upright(points[-1], z))
    for n, points in enumerate(decks, start=1):
        out.add(f"SC_WALL_{n}", PANEL.pid, upright(points[:, 0], z))
    small = [(HOLE * x, HOLE * y) for x, y in BAY]
    for name, inner, outer, cells in (("MIDDLE", small, BAY, 3), ("MIDDLE", BAY, body, 5),
                                      ("EDGE", body, octagon(ARRAY_EDGE), 3)):  # fmt: skip
        for points in ring(inner, outer, cells):
            out.add(f"SC_ARRAY_{name}", SOLAR.pid, level(points, ARRAY))
    return out


def spacecraft(struts: Sequence[Strut], areas: list[tuple[int, str]]) -> Iterable[str]:
    """Cards of the spacecraft, with the feet of struts on it and what holds it; `areas` gets its grids."""
    made, element = shells(), FIRST_ELEMENT
    for n, at in enumerate(made.xyz):
        yield grid_card(FIRST_GRID + n, at)
        areas.append((FIRST_GRID + n, made.area[n]))
    for pid, corners in made.quads:
        yield field8("CQUAD4", element, pid, *(FIRST_GRID + n for n in corners))
        element += 1
    for corner in (*BAY, *octagon(BODY)):
        ends = [FIRST_GRID + made.number[(*np.round(corner, 6).tolist(), z)] for z in (TOP, ARRAY)]
        yield field8("CBAR", element, 20, *ends, "1.", "0.", "0.")
        element += 1
    for strut in struts:
        area = "SC_FLOOR" if strut.panel == "MINUS_Z" else "SC_BAY_PY" if strut.end[1] > 0 else "SC_BAY_MY"
        nodes = made.near(area, strut.end, FOOT_HALF)
        yield rbe3(element, 800000 + 100 * strut.number + 4, nodes)
        element += 1
    for n, unit in enumerate(UNITS):
        yield grid_card(FIRST_UNIT + n, unit.at)
        yield rbe3(element, FIRST_UNIT + n, footprint(made, unit))
        yield field8("CONM2", element + 1, FIRST_UNIT + n, "", unit.kg)
        element += 2
    for mid, e, nu, rho, alpha in MATERIAL_CARDS:
        yield field8("MAT1", mid, real8(e), "", real8(nu), real8(rho), real8(alpha), "0.")
    for sandwich in (PANEL, BAY_WALL, SOLAR):
        yield sandwich.card()
    yield round_bar(20, ALUMINIUM, 8e-3)
    # A bar without mass or expansion to a fixed grid. Nothing pulls on it, so the mean motion of the corners is none.
    corners = [made.number[float(x), float(y), FLOOR] for x, y in BAY]
    yield grid_card(HELD, (0.0, 0.0, FLOOR)) + grid_card(FIXED, (0.0, 0.0, FLOOR - 100.0))
    areas += [(HELD, "SC_FLOOR"), (FIXED, "SC_FLOOR")]
    yield rbe3(element, HELD, corners)
    yield field8("CBAR", element + 1, 24, HELD, FIXED, "1.", "0.", "0.")
    yield field8("MAT1", WEIGHTLESS, real8(70.0e9), "", real8(0.33), "0.", "0.", "0.")
    yield round_bar(24, WEIGHTLESS, 20e-3)
    yield list_card(["SPC1", 1, 123456], [FIXED])


def footprint(made: Shells, unit: Unit) -> list[int]:
    """Nodes of the unit's area around what is nearest to it."""
    own = np.flatnonzero([area == unit.area for area in made.area])
    nearest = made.xyz[own[np.argmin(np.linalg.norm(made.xyz[own] - unit.at, axis=1))]]
    return made.near(unit.area, nearest, UNIT_HALF)


def rbe3(eid: int, grid: int, nodes: Iterable[int]) -> str:
    return list_card(["RBE3", eid, "", grid, 123456, "1.", 123], (FIRST_GRID + n for n in nodes))
