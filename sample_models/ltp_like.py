"""Write the LTP-like sample model: a synthetic stand-in for the LISA Pathfinder technology package, not flight data.

A Zerodur bench (200 x 212 x 45 mm) with sidewalls and stiffeners carries two titanium inertial sensors at x = -188 mm
and +188 mm; four titanium flanges on the sidewalls and eight glass-fibre struts hold it over-determined, or another of
the mounts of `ltp_like_mounts.py`. Every solid is a hexahedron of one tensor grid, so parts that touch share their
nodes. With clamped or pinned struts the structure is mirror symmetric in x; only the 22 optical elements, massless
6-DOF grids that follow the bench or a window (RBE3), are not.

Usage: python sample_models/ltp_like.py --mount clamped --element-size-mm 15 --layout configs/optics.toml -o model.bdf

writes the deck and, beside it, `<name>_areas.csv` with the thermal area of every structural grid, and the tables of the
thermal network (`ltp_like_network.py`). The same arguments give the same bytes.
"""

from __future__ import annotations

import argparse
import tomllib
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

import numpy as np
from deck_cards import field8, footprint, grid_card, list_card, real8, round_bar
from ltp_like_mounts import MOUNTS, STRUT_BARS, STRUT_RADIUS_M, Mount, mount
from ltp_like_network import write_network
from ltp_like_solids import CONCENTRATED, HUB_MASSES, MATERIALS, MM, TEST_MASS_X, Mesh, mesh
from ltp_like_spacecraft import spacecraft


def window_nodes(m: Mesh, x: float) -> list[int]:
    """Nodes of the window glass around (x, 0, 0); of the housing's inner face where the model has no window."""
    glass = [i for i, a in enumerate(m.area) if a.endswith("_WINDOW") and a.startswith("IS1" if x < 0 else "IS2")]
    if not glass:
        glass = [i for i, a in enumerate(m.area) if a == ("IS1_EH_INNER" if x < 0 else "IS2_EH_INNER")]
    return glass


def write_model(
    detail: str, held: Mount, size_mm: float, layout: Path, out: Path, *, with_spacecraft: bool = False
) -> None:
    m = mesh(detail, size_mm, held.blocks, held.planes)
    tables = tomllib.loads(layout.read_text(encoding="utf-8"))
    elements = [{"grid": tables.get("grids", {}).get(e["name"])} | e for e in tables["element"]]
    bulk: list[str] = []
    areas: list[tuple[int, str]] = []
    for i, xyz in enumerate(m.xyz):
        bulk.append(grid_card(i + 1, xyz))
        areas.append((i + 1, m.area[i]))
    eid = 0
    for conn, block in zip(m.hexes, m.block, strict=True):
        eid += 1
        bulk.append(list_card(["CHEXA", eid, MATERIALS[str(block.material)][0]], (int(n) + 1 for n in conn)))
    bulk += optical_grids(m, elements, eid)
    eid += len(elements)
    bars: list[tuple[int, str]] = []
    bulk += suspension(m, held, areas, bars, eid)
    bulk += spacecraft(held.struts, areas) if with_spacecraft else clamped_feet(held)
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
    if not with_spacecraft:
        write_network(detail, held, m, bars, elements, out.parent)
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


def suspension(
    m: Mesh, held: Mount, areas: list[tuple[int, str]], bars: list[tuple[int, str]], eid: int
) -> Iterable[str]:
    """Hubs on the flanges (RBE2), and the struts from each, four bar elements to a strut.

    Of a pinned strut the first bar lets go all rotations of the hub (PA), the last one those across it (PB).
    """
    for flange in held.flanges:
        hub = 850000 + flange.number
        yield grid_card(hub, flange.hub)
        areas.append((hub, flange.area))
        eid += 1
        yield list_card(["RBE2", eid, hub, 123], (int(i) + 1 for i in flange.face(m.xyz, m.area)))
        for strut in (s for s in held.struts if s.flange == flange.number):
            ids = [hub]
            for j in range(1, STRUT_BARS + 1):
                gid = 800000 + 100 * strut.number + j
                yield grid_card(gid, np.round(strut.hub + (strut.end - strut.hub) * j / STRUT_BARS, 6))
                areas.append((gid, f"STRUT_{strut.number}"))
                ids.append(gid)
            for n, (a, b) in enumerate(pairwise(ids), start=1):
                eid += 1
                yield field8("CBAR", eid, 10, a, b, "0.", "0.", "1.")
                if held.pinned and n in (1, STRUT_BARS):
                    yield field8("", *((456, "") if n == 1 else ("", 56)))
                bars.append((eid, f"STRUT_{strut.number}"))


def clamped_feet(held: Mount) -> Iterable[str]:
    yield list_card(["SPC1", 1, 123456], (800000 + 100 * strut.number + STRUT_BARS for strut in held.struts))


def concentrated_masses(m: Mesh, detail: str) -> Iterable[str]:
    """Caging drives and front-end electronics, on the caging blocks and the pump flange; of the small model on hubs."""
    if detail == "small":
        for eid, (n, kg) in enumerate(HUB_MASSES.items(), start=900001):
            yield field8("CONM2", eid, 850000 + n, "", kg)
        return
    eid = 900000
    for sx in (-1, 1):
        for mass in CONCENTRATED:
            eid += 1
            yield field8("CONM2", eid, m.find(sx * (TEST_MASS_X + mass.u), 0.0, mass.z) + 1, "", mass.kg)


def properties() -> Iterable[str]:
    for mid, e, nu, rho, alpha in MATERIALS.values():
        yield field8("MAT1", mid, real8(e), "", real8(nu), real8(rho), real8(alpha), "0.")
        if mid != MATERIALS["glass_fibre"][0]:
            yield field8("PSOLID", mid, mid, 0)
    yield round_bar(10, MATERIALS["glass_fibre"][0], STRUT_RADIUS_M)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--detail", choices=("full", "small"), default="full")
    parser.add_argument("--mount", choices=MOUNTS, default="clamped", help="how struts hold the bench")
    parser.add_argument("--element-size-mm", type=float, default=15.0, help="longest edge of a hexahedron")
    parser.add_argument("--layout", type=Path, required=True, help="optical layout (TOML) with each element's grid")
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--spacecraft", action="store_true", help="the spacecraft around it, without thermal network")
    args = parser.parse_args()
    held = mount(args.mount, args.detail)
    options = {"with_spacecraft": args.spacecraft}
    write_model(args.detail, held, args.element_size_mm, args.layout, args.output, **options)


if __name__ == "__main__":
    main()
