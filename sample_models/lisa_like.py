"""Write the LISA-like sample model: two assemblies at 60 degrees on one frame, synthetic, not flight data.

Each assembly is meshed in its own frame (mm: x towards the far spacecraft, z up, origin at the centre of its test
mass), then turned by +30 or -30 degrees and placed. From behind to the front: a titanium vacuum enclosure with a
molybdenum electrode housing around the test mass, a Zerodur bench on three feet, a silicon carbide mirror, and four
struts that carry a secondary mirror; a strongback of fibre composite joins them. Six struts hold each assembly on a
common plate, and eight more hold that plate on the spacecraft, where they are clamped.

Usage: python sample_models/lisa_like.py --element-size-mm 60 --layout configs/lisa_like/optics.toml -o model.bdf

writes the deck and, beside it, `<name>_areas.csv` with the thermal area of every structural grid. The same arguments
give the same bytes.
"""

from __future__ import annotations

import argparse
import tomllib
from collections.abc import Iterable, Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from deck_cards import field8, footprint, grid_card, list_card, real8, round_bar
from lisa_like_layout import placed
from ltp_like_solids import Block, Mesh, fill, subdivide

# name: (material id, E [Pa], Poisson's ratio, density [kg/m3], expansion [1/K]); handbook values, rounded
MATERIALS = {
    "zerodur": (1, 90.3e9, 0.24, 2530.0, 2.0e-8),
    "titanium": (2, 114.0e9, 0.34, 4430.0, 8.6e-6),
    "molybdenum": (3, 320.0e9, 0.31, 10220.0, 4.8e-6),
    "silicon_carbide": (4, 420.0e9, 0.16, 3160.0, 2.2e-6),
    "window_glass": (5, 71.0e9, 0.30, 3610.0, 10.1e-6),
    "composite": (6, 70.0e9, 0.30, 1600.0, 1.0e-6),
    "glass_fibre": (7, 45.0e9, 0.28, 1950.0, 7.0e-6),
}
BARS = {"telescope": (11, "composite", 8e-3), "mount": (12, "titanium", 6e-3), "spacecraft": (13, "glass_fibre", 9e-3)}

TOP, UNDER, FLOOR = -12.0, -88.0, -180.0  # of the bench, under the strongback, top of the plate (mm)
ASSEMBLY_PLANES = (
    [-69, -57, -33, -27, 27, 33, 57, 69, 90, 120, 235, 350, 380, 400, 430, 700, 715],
    [0, 27, 33, 57, 69, 110, 160],  # and their mirror images
    [-88, -69, -57, -33, -27, -12, 27, 33, 57, 69, 110],
)
PLATE_PLANES = ([80, 780], [-480, -160, 160, 480], [-200, -180])


def assembly_blocks() -> Iterator[Block]:
    """One assembly, in its frame; later blocks override earlier ones."""
    void = ("", None)
    # Vacuum enclosure, 12 mm titanium, as six walls laid over a solid block whose inside is then emptied.
    yield Block("VE_UP", "titanium", (-69, 69), (-69, 69), (-69, 69))
    yield Block("VE_DOWN", "titanium", (-69, 69), (-69, 69), (-69, -57))
    yield Block("VE_PLUS_Y", "titanium", (-69, 69), (57, 69), (-57, 57))
    yield Block("VE_MINUS_Y", "titanium", (-69, 69), (-69, -57), (-57, 57))
    yield Block("VE_REAR", "titanium", (-69, -57), (-57, 57), (-57, 57))
    yield Block("VE_FRONT", "titanium", (57, 69), (-57, 57), (-57, 57))
    yield Block(*void, (-57, 57), (-57, 57), (-57, 57))
    yield Block("WINDOW", "window_glass", (57, 69), (-27, 27), (-27, 27))
    # Electrode housing, 6 mm molybdenum, 4 mm from the faces of the 46 mm test mass, open towards the window.
    yield Block("EH_UP", "molybdenum", (-33, 33), (-33, 33), (-33, 33))
    yield Block("EH_DOWN", "molybdenum", (-33, 33), (-33, 33), (-33, -27))
    yield Block("EH_PLUS_Y", "molybdenum", (-33, 33), (27, 33), (-27, 27))
    yield Block("EH_MINUS_Y", "molybdenum", (-33, 33), (-33, -27), (-27, 27))
    yield Block("EH_REAR", "molybdenum", (-33, -27), (-27, 27), (-27, 27))
    yield Block(*void, (-27, 33), (-27, 27), (-27, 27))
    for z, name in (((-57, -33), "DOWN"), ((33, 57), "UP")):
        yield Block(f"CAGING_{name}", "titanium", (-27, 27), (-27, 27), z)
    for x, name in (((90, 235), "REAR"), ((235, 380), "FRONT")):
        yield Block(f"BENCH_{name}_MINUS_Y", "zerodur", x, (-160, 0), (-57, -12))
        yield Block(f"BENCH_{name}_PLUS_Y", "zerodur", x, (0, 160), (-57, -12))
    yield Block("FOOT_REAR", "titanium", (90, 120), (-33, 33), (-69, -57))
    yield Block("FOOT_PLUS_Y", "titanium", (350, 380), (57, 69), (-69, -57))
    yield Block("FOOT_MINUS_Y", "titanium", (350, 380), (-69, -57), (-69, -57))
    yield Block("STRONGBACK_REAR", "composite", (-69, 235), (-69, 69), (-88, -69))
    yield Block("STRONGBACK_FRONT", "composite", (235, 430), (-69, 69), (-88, -69))
    yield Block("MIRROR", "silicon_carbide", (400, 430), (-110, 110), (-69, 110))
    yield Block("SECONDARY", "silicon_carbide", (700, 715), (-27, 27), (-27, 27))


def plate_blocks() -> Iterator[Block]:
    """The plate that carries both assemblies, basic frame."""
    yield Block("PLATE_PLUS_Y", "composite", (80, 780), (160, 480), (-200, -180))
    yield Block("PLATE_MINUS_Y", "composite", (80, 780), (-480, -160), (-200, -180))
    yield Block("PLATE_MID", "composite", (80, 780), (-160, 160), (-200, -180))


class Deck:
    """Cards in the making; grids that carry a temperature, by area."""

    def __init__(self) -> None:
        self.cards: list[str] = []
        self.areas: list[tuple[int, str]] = []
        self.clamped: list[int] = []
        self.solids = 0
        self._grid, self._element = 0, 0

    def grid(self, at_mm: np.ndarray, area: str = "", number: int | None = None) -> int:
        if number is None:
            self._grid += 1
            number = self._grid
        self.cards.append(grid_card(number, np.round(at_mm, 6)))
        if area:
            self.areas.append((number, area))
        return number

    def element(self) -> int:
        self._element += 1
        return self._element

    def mesh(self, m: Mesh, at_mm: np.ndarray, mark: str) -> int:
        """All nodes and solids; the number before that of the first node."""
        first = self._grid
        for at, area in zip(at_mm, m.area, strict=True):
            self.grid(at, mark + area)
        for conn, block in zip(m.hexes, m.block, strict=True):
            ids = (first + int(n) + 1 for n in conn)
            self.cards.append(list_card(["CHEXA", self.element(), MATERIALS[str(block.material)][0]], ids))
        self.solids += len(m.hexes)
        return first

    def follow(self, grid: int, nodes: Iterable[int]) -> None:
        """A grid that follows the mean motion of others (RBE3)."""
        self.cards.append(list_card(["RBE3", self.element(), "", grid, 123456, "1.", 123], nodes))

    def strut(
        self, start: int, start_mm: np.ndarray, end: int | None, end_mm: np.ndarray, kind: str, area: str
    ) -> None:
        """Four bars between two grids; clamped at its end where there is no grid."""
        ids = [start]
        for j in range(1, 4 if end is not None else 5):
            ids.append(self.grid(start_mm + (end_mm - start_mm) * j / 4, area))
        if end is None:
            self.clamped.append(ids[-1])
        else:
            ids.append(end)
        for a, b in pairwise(ids):
            self.cards.append(field8("CBAR", self.element(), BARS[kind][0], a, b, "0.", "0.", "1."))


def near(m: Mesh, *bounds: tuple[float, float]) -> np.ndarray:
    """Nodes within bounds (mm) of x, y and z."""
    low, high = np.array(bounds).T
    found = np.flatnonzero(((m.xyz > low - 1e-6) & (m.xyz < high + 1e-6)).all(axis=1))
    if len(found) < 4:
        raise SystemExit(f"only {len(found)} mesh nodes within {bounds} mm")
    return found


def assembly(deck: Deck, number: int, size: float, elements: list[dict], plate: tuple[Mesh, int]) -> None:
    """The solids of one assembly, its optical elements, its telescope, and the six struts that hold it on the plate."""
    x, y, z = ASSEMBLY_PLANES
    m = fill((subdivide(x, size), subdivide([*y, *(-v for v in y)], size), subdivide(z, size)), list(assembly_blocks()))
    mark = f"A{number}_"
    first = deck.mesh(m, placed(number, m.xyz), mark)
    ids = lambda nodes: [first + int(n) + 1 for n in nodes]  # noqa: E731
    is_bench = np.array([a.startswith("BENCH") for a in m.area])
    window = np.flatnonzero([a == "WINDOW" for a in m.area])
    origin = placed(number, np.zeros(3))
    turn = placed(number, np.eye(3)) - origin  # rows: axes of the assembly in the basic frame
    for e in elements:
        at = turn @ (np.array(e["ref_m"]) * 1e3 - origin)
        nodes = window if e["kind"] == "window" else footprint(m, is_bench, at[0], at[1], TOP, 12.0)
        deck.follow(deck.grid(np.array(e["ref_m"]) * 1e3, number=e["grid"]), ids(nodes))

    def hub(at: tuple[float, float, float], area: str, nodes: np.ndarray) -> tuple[int, np.ndarray]:
        place = placed(number, np.array(at))
        grid = deck.grid(place, mark + area)
        deck.follow(grid, ids(nodes))
        return grid, place

    front = hub((700, 0, 0), "SECONDARY", near(m, (700, 700), (-27, 27), (-27, 27)))
    corners = [(sy, bounds) for sy in (1, -1) for bounds in ((69, 110), (-69, -57))]
    for n, (sy, z_bounds) in enumerate(corners, start=1):
        y_bounds = tuple(sorted((sy * 69.0, sy * 110.0)))
        foot = hub((430, sy * 90, sum(z_bounds) / 2), "MIRROR", near(m, (430, 430), y_bounds, z_bounds))
        deck.strut(*foot, *front, "telescope", f"{mark}TELESCOPE_{n}")
    strut = 0
    for at, box in (((-63, 0), ((-69, -57), (-27, 27))), ((415, 63), ((400, 430), (57, 69))),
                    ((415, -63), ((400, 430), (-69, -57)))):  # fmt: skip
        up = hub((*at, UNDER), f"STRONGBACK_{'REAR' if at[0] < 0 else 'FRONT'}", near(m, *box, (UNDER, UNDER)))
        for sign in (1, -1):
            strut += 1
            along = (0, sign * 90) if at[0] < 0 else (-sign * 60, np.copysign(70, at[1]))
            base = placed(number, np.array([at[0] + along[0], at[1] + along[1], FLOOR]))
            of_plate = footprint(plate[0], np.ones(len(plate[0].xyz), dtype=bool), base[0], base[1], FLOOR, 30.0)
            name = "PLATE_MID" if abs(base[1]) < 160 else f"PLATE_{'PLUS' if base[1] > 0 else 'MINUS'}_Y"
            down = deck.grid(base, name)
            deck.follow(down, (plate[1] + n + 1 for n in of_plate))
            deck.strut(*up, down, base, "mount", f"{mark}MOUNT_{strut}")


def model(size: float, layout: Path) -> Deck:
    """Plate, struts to the spacecraft, and both assemblies."""
    tables = tomllib.loads(layout.read_text(encoding="utf-8"))
    elements = [e for e in tables["element"] if e["kind"] != "test_mass"]
    deck = Deck()
    x, y, z = PLATE_PLANES
    m = fill((subdivide(x, 1.5 * size), subdivide(y, 1.5 * size), subdivide(z, size)), list(plate_blocks()))
    first = deck.mesh(m, m.xyz, "")
    for number in (1, 2):
        mine = [e for e in elements if e["grid"] // 100 == 9000 + number]
        assembly(deck, number, size, mine, (m, first))
    strut = 0
    whole = np.ones(len(m.xyz), dtype=bool)
    for sx in (1, -1):
        for sy in (1, -1):
            at = np.array([430.0 + sx * 300.0, sy * 430.0, -200.0])
            hub = deck.grid(at, f"PLATE_{'PLUS' if sy > 0 else 'MINUS'}_Y")
            deck.follow(hub, (first + n + 1 for n in footprint(m, whole, at[0], at[1], -200.0, 40.0)))
            for end in ((sx * 120.0, 0.0, -160.0), (0.0, sy * 120.0, -160.0)):
                strut += 1
                deck.strut(hub, at, None, at + np.array(end), "spacecraft", f"SC_STRUT_{strut}")
    return deck


def properties() -> Iterator[str]:
    for mid, e, nu, rho, alpha in MATERIALS.values():
        yield field8("MAT1", mid, real8(e), "", real8(nu), real8(rho), real8(alpha), "0.")
        yield field8("PSOLID", mid, mid, 0)
    for pid, material, radius in BARS.values():
        yield round_bar(pid, MATERIALS[material][0], radius)


def write_model(size_mm: float, layout: Path, out: Path) -> None:
    deck = model(size_mm, layout)
    total = len({a for _, a in deck.areas})
    facts = f"{len(deck.areas)} structural grids, {deck.solids} CHEXA, {total} thermal areas"
    head = [
        f"$ LISA-like sample model, synthetic, not flight data: {facts}\n",
        "$ metre, kilogram, second, newton, kelvin\n",
        "SOL 101\nCEND\nTITLE = LISA-like sample model\nECHO = NONE\nSPC = 1\nDISPLACEMENT(PLOT) = ALL\nBEGIN BULK\n",
        "PARAM       POST      -1\nPARAM    AUTOSPC     YES\n",
    ]
    bulk = [*deck.cards, list_card(["SPC1", 1, 123456], deck.clamped), *properties()]
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text("".join(head + bulk) + "ENDDATA\n", encoding="ascii", newline="\n")
    rows = "".join(f"{g},{a}\n" for g, a in sorted(deck.areas))
    out.with_name(out.stem + "_areas.csv").write_text("node_id,area\n" + rows, encoding="ascii", newline="\n")
    print(f"{out}: {facts}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--element-size-mm", type=float, default=60.0, help="longest edge of a hexahedron")
    parser.add_argument("--layout", type=Path, required=True, help="optical layout (TOML) with each element's grid")
    parser.add_argument("-o", "--output", type=Path, required=True)
    args = parser.parse_args()
    write_model(args.element_size_mm, args.layout, args.output)


if __name__ == "__main__":
    main()
