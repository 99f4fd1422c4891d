"""Write the LTP-like sample model: a synthetic stand-in for the LISA Pathfinder technology package, not flight data.

A Zerodur bench (200 x 212 x 45 mm) with sidewalls and stiffeners carries two titanium inertial sensors at x = -188 mm
and +188 mm; four titanium flanges on the sidewalls and eight glass-fibre struts hold it over-determined. Every solid is
a hexahedron of one tensor grid, so parts that touch share their nodes. The structure is mirror symmetric in x; only the
22 optical elements, massless 6-DOF grids that follow the bench or a window (RBE3), are not.

Usage: python sample_models/ltp_like.py --detail full --element-size-mm 15 --layout configs/optics.toml -o model.bdf

writes the deck and, beside it, `<name>_areas.csv` with the thermal area of every structural grid. The same arguments
give the same bytes.
"""

from __future__ import annotations

import argparse
import math
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

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


def flange_blocks(detail: str) -> Iterable[Block]:
    z = (-33, 33) if detail == "full" else (-33, -12)
    u = 27 if detail == "full" else 33
    y = (121, 133) if detail == "full" else (106, 121)
    for n, (sx, sy) in enumerate(FLANGE_SIGNS, start=1):
        x = sorted((sx * (TEST_MASS_X - u), sx * (TEST_MASS_X + u)))
        yv = sorted((sy * y[0], sy * y[1]))
        yield Block(f"FLANGE_{n}", "titanium", (x[0], x[1]), (yv[0], yv[1]), z)


FLANGE_SIGNS = ((-1, -1), (-1, 1), (1, -1), (1, 1))


def blocks(detail: str) -> list[Block]:
    """All blocks of the model, in order of precedence, the mirrored sensor 1 included."""
    sensor = inertial_sensor_full if detail == "full" else inertial_sensor_small
    out: list[Block] = list(bench_blocks(detail))
    for number, sign in ((1, -1), (2, 1)):
        for b in sensor(number):
            x = sorted((sign * (TEST_MASS_X + b.x[0]), sign * (TEST_MASS_X + b.x[1])))
            out.append(Block(b.area, b.material, (x[0], x[1]), b.y, b.z))
    out += flange_blocks(detail)
    return out


def subdivide(planes: Iterable[float], size: float) -> np.ndarray:
    """Sorted planes (mm) with every gap cut into equal parts no longer than `size`; rounded to the nanometre."""
    base = sorted(set(planes))
    out = [base[0]]
    for a, b in pairwise(base):
        n = max(1, math.ceil((b - a) / size - 1e-9))
        out += [a + (b - a) * i / n for i in range(1, n + 1)]
    return np.round(np.array(out, dtype=float), 6)


def grid_planes(detail: str, size: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The planes of the tensor grid along x, y and z (mm)."""
    p = FULL_PLANES if detail == "full" else SMALL_PLANES
    u = [0.0, *p["is"], *(-v for v in p["is"])] if detail == "full" else [*p["is"], *(-v for v in p["is"])]
    half = [TEST_MASS_X + v for v in u] + p["bench_x"]
    x = subdivide([*half, *(-v for v in half)], size)
    y = subdivide([*p["y"], *(-v for v in p["y"])], size)
    z = subdivide([*p["z"], *(-v for v in p["z"])], size)
    return x, y, z


@dataclass
class Mesh:
    """Solid mesh: coordinates in mm, hexahedra in Nastran order with their material, and the area of each node."""

    xyz: np.ndarray
    hexes: np.ndarray
    material: list[str]
    area: list[str]

    def find(self, x: float, y: float, z: float) -> int:
        hit = np.nonzero((np.abs(self.xyz - np.array([x, y, z])) < 1e-6).all(axis=1))[0]
        if len(hit) != 1:
            raise SystemExit(f"no single mesh node at ({x}, {y}, {z}) mm")
        return int(hit[0])


def mesh(detail: str, size: float) -> Mesh:
    """The solids of the model."""
    # The two sensors share no node, so the relative order of their blocks does not matter.
    return fill(grid_planes(detail, size), blocks(detail))


def fill(planes: tuple[np.ndarray, np.ndarray, np.ndarray], all_blocks: list[Block]) -> Mesh:
    """Fill the tensor grid with the blocks; a node belongs to the area of the last block that has a cell at it."""
    centres = [(p[:-1] + p[1:]) / 2 for p in planes]
    shape = tuple(len(c) for c in centres)
    owner = np.full(shape, -1)
    for n, b in enumerate(all_blocks):
        ix = [np.nonzero((c > lo) & (c < hi))[0] for c, (lo, hi) in zip(centres, (b.x, b.y, b.z), strict=True)]
        owner[np.ix_(*ix)] = n if b.material else -1
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
        [str(all_blocks[o].material) for o in cell_owner],
        [all_blocks[o].area for o in node_owner],
    )


def field8(*values: object) -> str:
    return "".join(f"{v:<8}" if i == 0 else f"{v:>8}" for i, v in enumerate(values)).rstrip() + "\n"


def grid_card(gid: int, xyz_mm: Iterable[float]) -> str:
    x, y, z = (f"{v * MM:.9f}" for v in xyz_mm)
    return f"GRID*   {gid:>16}{'':16}{x:>16}{y:>16}\n*       {z:>16}\n"


def list_card(head: list[object], ids: Iterable[int]) -> str:
    """A card whose last items are a list, continued over as many lines as it takes."""
    items = [*head, *ids]
    lines = [field8(*items[:9])]
    for start in range(9, len(items), 8):
        lines.append(field8("", *items[start : start + 8]))
    return "".join(lines)


def real8(value: float) -> str:
    """A Nastran real in at most eight characters."""
    mantissa, exponent = f"{value:.3e}".split("e")
    mantissa = mantissa.rstrip("0")
    return mantissa + (f"{int(exponent):+d}" if int(exponent) else "")


def footprint(m: Mesh, part: np.ndarray, x: float, y: float, z_top: float, half: float = 10.0) -> list[int]:
    """Nodes of a part in the plane z = z_top around (x, y): those within `half` mm, or the corners of their cell."""
    on = np.nonzero(part & (np.abs(m.xyz[:, 2] - z_top) < 1e-6))[0]
    near = on[(np.abs(m.xyz[on, 0] - x) <= half) & (np.abs(m.xyz[on, 1] - y) <= half)]
    if min(len(set(m.xyz[near, 0])), len(set(m.xyz[near, 1]))) >= 2:
        return [int(i) for i in near]
    bounds = []
    for axis, value in ((0, x), (1, y)):
        levels = np.unique(m.xyz[on, axis])
        i = int(np.clip(np.searchsorted(levels, value) - 1, 0, len(levels) - 2))
        bounds.append((levels[i], levels[i + 1]))
    return [m.find(px, py, z_top) for px in bounds[0] for py in bounds[1]]


def window_nodes(m: Mesh, x: float) -> list[int]:
    """Nodes of the window glass around (x, 0, 0); of the housing's inner face where the model has no window."""
    glass = [i for i, a in enumerate(m.area) if a.endswith("_WINDOW") and a.startswith("IS1" if x < 0 else "IS2")]
    if not glass:
        glass = [i for i, a in enumerate(m.area) if a == ("IS1_EH_INNER" if x < 0 else "IS2_EH_INNER")]
    return glass


def write_model(detail: str, size_mm: float, layout: Path, out: Path) -> None:
    m = mesh(detail, size_mm)
    tables = tomllib.loads(layout.read_text(encoding="utf-8"))
    elements = [{"grid": tables.get("grids", {}).get(e["name"])} | e for e in tables["element"]]
    bulk: list[str] = []
    areas: list[tuple[int, str]] = []
    for i, xyz in enumerate(m.xyz):
        bulk.append(grid_card(i + 1, xyz))
        areas.append((i + 1, m.area[i]))
    eid = 0
    for conn, material in zip(m.hexes, m.material, strict=True):
        eid += 1
        bulk.append(list_card(["CHEXA", eid, MATERIALS[material][0]], (int(n) + 1 for n in conn)))
    bulk += optical_grids(m, elements, eid)
    eid += len(elements)
    bulk += suspension(m, detail, areas, eid)
    bulk += concentrated_masses(m, detail)
    bulk += properties()
    total = len({a for _, a in areas})
    head = [
        f"$ LTP-like sample model, synthetic, not flight data: {len(m.xyz)} solid grids, {len(m.hexes)} CHEXA,"
        f" {total} thermal areas\n",
        "$ metre, kilogram, second, newton, kelvin\n",
        "SOL 101\nCEND\nTITLE = LTP-like sample model\nECHO = NONE\nSPC = 1\nDISPLACEMENT(PLOT) = ALL\nBEGIN BULK\n",
        "PARAM       POST      -1\nPARAM    AUTOSPC     YES\n",
    ]
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text("".join(head + bulk) + "ENDDATA\n", encoding="ascii", newline="\n")
    rows = "".join(f"{g},{a}\n" for g, a in sorted(areas))
    out.with_name(out.stem + "_areas.csv").write_text("node_id,area\n" + rows, encoding="ascii", newline="\n")
    print(f"{out}: {len(areas)} structural grids, {len(m.hexes)} CHEXA, {total} thermal areas")


def optical_grids(m: Mesh, elements: list[dict], eid: int) -> Iterable[str]:
    """One 6-DOF grid per optical element, interpolated (RBE3) from the bench surface below it or from its window."""
    top = -12.0
    bench = (np.abs(m.xyz[:, 0]) <= 100) & (np.abs(m.xyz[:, 1]) <= 106)
    for e in elements:
        if e["kind"] == "test_mass":
            continue
        eid += 1
        x, y, z = (v / MM for v in e["ref_m"])
        nodes = window_nodes(m, x) if e["kind"] == "window" else footprint(m, bench, x, y, top)
        yield grid_card(e["grid"], (x, y, z))
        yield list_card(["RBE3", eid, "", e["grid"], 123456, "1.", 123], (n + 1 for n in nodes))


def suspension(m: Mesh, detail: str, areas: list[tuple[int, str]], eid: int) -> Iterable[str]:
    """Four hubs on the flanges (RBE2), two clamped struts from each, four bar elements to a strut."""
    y_hub, z_hub = (133.0, 0.0) if detail == "full" else (121.0, -12.0)
    strut = 0
    clamped = []
    for n, (sx, sy) in enumerate(FLANGE_SIGNS, start=1):
        hub = 850000 + n
        xyz = m.xyz
        face = np.nonzero(
            (np.abs(xyz[:, 1] - sy * y_hub) < 1e-6)
            & (np.abs(xyz[:, 0] - sx * TEST_MASS_X) < 33.5)
            & (np.abs(xyz[:, 2] - z_hub) < (12.5 if detail == "full" else 33.5))
            & np.array([a == f"FLANGE_{n}" for a in m.area])
        )[0]
        centre = np.array([sx * TEST_MASS_X, sy * (y_hub + 5.0), z_hub])
        yield grid_card(hub, centre)
        areas.append((hub, f"FLANGE_{n}"))
        eid += 1
        yield list_card(["RBE2", eid, hub, 123], (int(i) + 1 for i in face))
        for k, (dx, dz) in enumerate(((60.0, 110.0), (-60.0, -110.0))):
            strut += 1
            end = centre + np.array([sx * dx, sy * 100.0, dz])
            ids = [hub]
            for j in range(1, 5):
                gid = 800000 + 100 * strut + j
                yield grid_card(gid, np.round(centre + (end - centre) * j / 4, 6))
                areas.append((gid, f"STRUT_{2 * (n - 1) + k + 1}"))
                ids.append(gid)
            for a, b in pairwise(ids):
                eid += 1
                yield field8("CBAR", eid, 10, a, b, "0.", "0.", "1.")
            clamped.append(ids[-1])
    yield list_card(["SPC1", 1, 123456], clamped)


def concentrated_masses(m: Mesh, detail: str) -> Iterable[str]:
    """Caging drives and front-end electronics, on the caging blocks and the pump flange; none in the small model."""
    if detail == "small":
        yield field8("CONM2", 900001, 850001, "", "0.12")
        yield field8("CONM2", 900002, 850003, "", "0.12")
        return
    eid = 900000
    for sx in (-1, 1):
        for u, z, kg in ((0.0, -45.0, "0.3"), (0.0, 45.0, "0.3"), (81.0, 0.0, "0.5")):
            eid += 1
            yield field8("CONM2", eid, m.find(sx * (TEST_MASS_X + u), 0.0, z) + 1, "", kg)


def properties() -> Iterable[str]:
    for mid, e, nu, rho, alpha in MATERIALS.values():
        yield field8("MAT1", mid, real8(e), "", real8(nu), real8(rho), real8(alpha), "0.")
        if mid != MATERIALS["glass_fibre"][0]:
            yield field8("PSOLID", mid, mid, 0)
    yield round_bar(10, MATERIALS["glass_fibre"][0], 6.0e-3)


def round_bar(pid: int, mid: int, radius: float) -> str:
    """Property of a solid round bar; `radius` in m."""
    area = math.pi * radius**2
    inertia = math.pi * radius**4 / 4
    return field8("PBAR", pid, mid, real8(area), real8(inertia), real8(inertia), real8(2 * inertia))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--detail", choices=("full", "small"), default="full")
    parser.add_argument("--element-size-mm", type=float, default=15.0, help="longest edge of a hexahedron")
    parser.add_argument("--layout", type=Path, required=True, help="optical layout (TOML) with each element's grid")
    parser.add_argument("-o", "--output", type=Path, required=True)
    args = parser.parse_args()
    write_model(args.detail, args.element_size_mm, args.layout, args.output)


if __name__ == "__main__":
    main()
