"""The thermal network of the LTP-like sample, from the same blocks as its deck. Synthetic, not flight data.

`write_network` writes four tables beside the deck: `thermal_nodes.csv`, `thermal_conductors.csv`, `thermal_powers.csv`,
and `thermal_elements.csv` with the finite elements of each node. Nodes are parts of the thermal areas, and what has no
element: test masses, units, the two skins of the thermal shield's panels, the spacecraft's panels (boundaries).

* Capacity: mass times specific heat.
* Conduction: where two nodes share a face of area A, A / (d_a / k_a + 1 / h + d_b / k_b) with the distances d of their
  centroids from the centroid of the face, and h of the joint.
* Radiation: along x, y and z, every face sees only what stands straight opposite, as parallel plates:
  A / (1 / e_a + 1 / e_b - 1). The last face sees the shield; of a flange it sees the spacecraft.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from ltp_like_assumptions import (
    AREA,
    C_P,
    CONTACT,
    CORE,
    DENSITY,
    EMITTANCE,
    LENGTH,
    LINK,
    MASS,
    POWER,
    TEMPERATURE,
    UNITS,
    K,
)
from ltp_like_mounts import STRUT_BARS, STRUT_RADIUS_M, Mount
from ltp_like_solids import (
    CONCENTRATED,
    HUB_MASSES,
    MATERIALS,
    MM,
    TEST_MASS_X,
    Block,
    Mesh,
    blocks,
    grid_planes,
    owners,
)

SIDES = ("MINUS_X", "PLUS_X", "MINUS_Y", "PLUS_Y", "MINUS_Z", "PLUS_Z")
TEST_MASS_HALF = 23.0  # mm


class Network:
    """Nodes and conductors as they are added; `join` adds to what two nodes have already."""

    def __init__(self) -> None:
        self.nodes: dict[str, tuple[float, str, float | None, np.ndarray]] = {}
        self.conductors: dict[tuple[str, str], list[float]] = {}
        self.powers: dict[str, float] = {}

    def node(
        self, name: str, capacity: float, at_mm: Sequence[float] | np.ndarray, boundary_K: float | None = None
    ) -> str:
        kind = "boundary" if boundary_K is not None else "diffusive" if capacity else "arithmetic"
        self.nodes[name] = (capacity, kind, boundary_K, np.asarray(at_mm, dtype=float) * MM)
        return name

    def join(self, a: str, b: str, gl: float = 0.0, gr: float = 0.0) -> None:
        if a != b:
            both = self.conductors.setdefault((a, b) if (b, a) not in self.conductors else (b, a), [0.0, 0.0])
            both[0] += gl
            both[1] += gr

    def heat(self, node: str, power_W: float) -> None:
        self.powers[node] = self.powers.get(node, 0.0) + power_W


def part(name: str) -> str:
    """What an area or a node is of: VE, EH, SUPPORT, TM, ...; the bench with sidewalls and stiffeners is OB."""
    return re.match(r"(?:IS\d_)?([A-Z]+)", name)[1]


def node_of(detail: str, area: str, at: np.ndarray) -> str:
    """Node of a solid of an area at a place (mm). Large areas, and posts above and below, are several nodes."""
    _, y, z = at
    if detail == "small":
        return area
    if area.startswith("OB_BENCH"):
        return f"{area}_{'EDGE' if abs(y) > 57 else 'CORE'}_{'TOP' if z > -33 else 'BASE'}"
    if area.startswith("OB_SIDEWALL"):
        return f"{area}_{'UPPER' if z > -12 else 'LOWER'}"
    if area.startswith("OB_STIFFENER") or area.endswith(("_VE_UP", "_VE_DOWN")):
        return f"{area}_{'PLUS_Y' if y > 0 else 'MINUS_Y'}"
    if "_SUPPORT_" in area:
        return f"{area}_{'UP' if z > 0 else 'DOWN'}"
    return area


def plates(e_a: float, e_b: float) -> float:
    """Exchange factor of two parallel plates with emittances e_a and e_b."""
    return 1 / (1 / e_a + 1 / e_b - 1)


def contact(a: str, b: str) -> float:
    """Resistance of the joint of two nodes (m2 K/W); pieces of one part are one body."""
    parts = " and ".join(sorted((part(a), part(b))))
    return 0.0 if part(a) == part(b) and part(a) != "EH" else 1 / CONTACT[parts]


def emittance(node: str) -> float:
    return EMITTANCE[part(node)]


@dataclass
class Solids:
    """Blocks and test masses as coarse cells: planes and centroids (mm), volumes (m3), each cell's node or -1."""

    planes: list[np.ndarray]
    names: list[str]
    of: np.ndarray
    material: list[str]
    volume: np.ndarray
    centroid: np.ndarray


def solids(detail: str, mount: Mount) -> Solids:
    half = TEST_MASS_HALF
    masses = [
        Block(f"TM{n}", "gold_platinum", (x - half, x + half), (-half, half), (-half, half))
        for n, x in ((1, -TEST_MASS_X), (2, TEST_MASS_X))
    ]
    faces = [[x + u for x in (-TEST_MASS_X, TEST_MASS_X) for u in (-half, half)], [-half, half], [-half, half]]
    planes = [np.unique([*p, *f]) for p, f in zip(grid_planes(detail, math.inf, mount.planes), faces, strict=True)]
    all_blocks = [*blocks(detail, mount.blocks), *masses]
    owner = owners((planes[0], planes[1], planes[2]), all_blocks)
    cells = np.argwhere(owner >= 0)
    cells = cells[np.argsort(owner[tuple(cells.T)], kind="stable")]  # nodes in the order of their blocks
    own = [all_blocks[n] for n in owner[tuple(cells.T)]]
    at = np.stack([((p[:-1] + p[1:]) / 2)[i] for p, i in zip(planes, cells.T, strict=True)], axis=1)
    size = np.prod([np.diff(p)[i] for p, i in zip(planes, cells.T, strict=True)], axis=0)
    node = [node_of(detail, block.area, place) for block, place in zip(own, at, strict=True)]
    material = {name: str(block.material) for name, block in zip(node, own, strict=True)}
    names = list(material)
    number = np.array([names.index(name) for name in node])
    of = np.full(owner.shape, -1)
    of[tuple(cells.T)] = number
    volume = np.bincount(number, size)
    centroid = np.stack([np.bincount(number, size * at[:, axis]) / volume for axis in range(3)], axis=1)
    return Solids(planes, names, of, list(material.values()), volume * MM**3, centroid)


def conduct(net: Network, s: Solids) -> None:
    """Conductors through the faces that nodes share."""
    faces: dict[tuple[int, int], list[np.ndarray]] = {}  # area, and area times place, of all faces of a pair
    for lower, upper, area, at in shared_faces(s):
        total = faces.setdefault((min(lower, upper), max(lower, upper)), [np.zeros(1), np.zeros(3)])
        total[0] += area
        total[1] += area * at
    for (a, b), (area, moment) in sorted(faces.items()):
        away = [float(np.linalg.norm(moment / area - s.centroid[n])) * MM for n in (a, b)]
        ways = sum(d / K[s.material[n]] for d, n in zip(away, (a, b), strict=True))
        net.join(s.names[a], s.names[b], gl=float(area[0]) * MM**2 / (ways + contact(s.names[a], s.names[b])))


def shared_faces(s: Solids) -> Iterator[tuple[int, int, float, np.ndarray]]:
    """Both nodes, area (mm2) and centre (mm) of every face between cells of two nodes."""
    for axis in range(3):
        for cell in np.argwhere(np.diff(s.of, axis=axis) != 0):
            beyond = cell.copy()
            beyond[axis] += 1
            lower, upper = int(s.of[tuple(cell)]), int(s.of[tuple(beyond)])
            if lower < 0 or upper < 0:
                continue
            others = [a for a in range(3) if a != axis]
            at = np.array([(p[i] + p[i + 1]) / 2 for p, i in zip(s.planes, cell, strict=True)])
            at[axis] = s.planes[axis][beyond[axis]]
            yield lower, upper, float(np.prod([np.diff(s.planes[a])[cell[a]] for a in others])), at


def radiate(net: Network, s: Solids) -> None:
    """Radiation along every line of cells: across its gaps, and from its ends to what is around."""
    for axis in range(3):
        others = [a for a in range(3) if a != axis]
        widths = [np.diff(s.planes[a]) * MM for a in others]
        for line in np.ndindex(len(widths[0]), len(widths[1])):
            along = np.moveaxis(s.of, axis, 2)[line]
            solid = np.flatnonzero(along >= 0)
            if not len(solid):
                continue
            area = widths[0][line[0]] * widths[1][line[1]]
            for i in np.flatnonzero(np.diff(solid) > 1):
                a, b = s.names[along[solid[i]]], s.names[along[solid[i + 1]]]
                net.join(a, b, gr=area * plates(emittance(a), emittance(b)))
            for side, end in zip(SIDES[2 * axis : 2 * axis + 2], (solid[0], solid[-1]), strict=True):
                name = s.names[along[end]]
                around = f"SC_{side}" if part(name) == "FLANGE" else f"SHIELD_INNER_{side}"
                net.join(name, around, gr=area * plates(emittance(name), emittance(around)))


def spacecraft(net: Network) -> None:
    """Boundary panels, the two skins of each panel of the shield, and the units on the spacecraft's panels."""
    half = np.array([LENGTH[f"half length along {axis}"] for axis in "xyz"])
    skin, aluminium = LENGTH["skin"], K["aluminium"]
    for n, side in enumerate(SIDES):
        axis, sign = n // 2, 2 * (n % 2) - 1
        area = 4 * float(np.prod(np.delete(half, axis)))
        out = np.zeros(3)
        out[axis] = sign / MM
        net.node(f"SC_{side}", 0.0, out * 2 * half[axis], boundary_K=TEMPERATURE[side])
        capacity = area * skin * DENSITY["aluminium"] * C_P["aluminium"]
        for layer in ("OUTER", "INNER"):
            net.node(f"SHIELD_{layer}_{side}", capacity, out * half[axis])
        net.join(f"SHIELD_OUTER_{side}", f"SHIELD_INNER_{side}", gl=area * CORE["core"])
        net.join(
            f"SC_{side}",
            f"SHIELD_OUTER_{side}",
            gl=LINK["stand-off of a shield's panel"],
            gr=area * plates(EMITTANCE["SC"], EMITTANCE["SHIELD"]),
        )
        for m in range(n if n % 2 == 0 else n - 1):  # panels that share an edge, along the skins
            edge = 2 * float(half[({0, 1, 2} - {axis, m // 2}).pop()])
            for layer in ("OUTER", "INNER"):
                between = edge * skin * aluminium / (half[axis] + half[m // 2])
                net.join(f"SHIELD_{layer}_{SIDES[m]}", f"SHIELD_{layer}_{side}", gl=float(between))
    for unit, side in UNITS.items():
        at = net.nodes[f"SC_{side}"][3] / MM * 0.95
        net.node(f"UNIT_{unit}", MASS[unit] * C_P["electronics"], at)
        net.join(f"UNIT_{unit}", f"SC_{side}", gl=LINK["unit to panel"])
        seen = AREA["unit"]
        net.join(f"UNIT_{unit}", f"SHIELD_OUTER_{side}", gr=seen * plates(emittance("UNIT"), emittance("SHIELD")))
        net.heat(f"UNIT_{unit}", POWER[unit])


def suspend(net: Network, detail: str, mount: Mount) -> None:
    """Struts, a node for each of their bars from the hub on, and the hubs where they meet their flange."""
    section = math.pi * STRUT_RADIUS_M**2
    for strut in mount.struts:
        hub, side = f"HUB_{strut.flange}", f"SC_{strut.panel}"
        if hub not in net.nodes:
            kg = HUB_MASSES.get(strut.flange, 0.0) if detail == "small" else 0.0
            net.node(hub, kg * C_P["electronics"], strut.hub)
            net.join(f"FLANGE_{strut.flange}", hub, gl=LINK["flange to hub"])
        length = float(np.linalg.norm(strut.end - strut.hub)) * MM / STRUT_BARS
        capacity = section * length * MATERIALS["glass_fibre"][3] * C_P["glass_fibre"]
        along = K["glass_fibre"] * section / length
        before, gl = hub, 2 * along
        for n in range(STRUT_BARS):
            bar = f"STRUT_{strut.number}_{n + 1}"
            net.node(bar, capacity, strut.hub + (strut.end - strut.hub) * (n + 0.5) / STRUT_BARS)
            net.join(before, bar, gl=gl)
            net.join(bar, side, gr=2 * math.pi * STRUT_RADIUS_M * length * plates(emittance("STRUT"), emittance("SC")))
            before, gl = bar, along
        net.join(before, side, gl=2 * along)


def instrument(net: Network, detail: str, find: Callable[[np.ndarray], str], elements: Iterable[dict]) -> None:
    """Concentrated masses, harness, and what photodiodes and front-end electronics dissipate."""
    for n, sx in ((1, -1), (2, 1)):
        electronics = f"IS{n}_EH_OUTER"
        if detail == "full":
            for mass in CONCENTRATED:
                at = (sx * (TEST_MASS_X + mass.u), 0.0, mass.z)
                electronics = net.node(f"IS{n}_{mass.name}", mass.kg * C_P["electronics"], at)
                net.join(electronics, f"IS{n}_{mass.area}", gl=LINK["concentrated mass"])
            side = "SHIELD_INNER_MINUS_X" if sx < 0 else "SHIELD_INNER_PLUS_X"
            seen = AREA["front-end electronics"]
            net.join(electronics, side, gr=seen * plates(emittance("UNIT"), emittance(side)))
        net.join(f"UNIT_FEE_{n}", electronics, gl=LINK["harness of front-end electronics"])
        net.heat(electronics, POWER["front-end electronics on a sensor"])
    for e in elements:
        if e["kind"] == "photodiode":
            below = find(np.array(e["ref_m"]) / MM)
            net.heat(below, POWER["photodiode with its amplifier"])
            net.join("UNIT_PHASEMETER", below, gl=LINK["harness of a photodiode"])


def network(detail: str, mount: Mount, elements: Sequence[dict]) -> Network:
    """The whole network; `elements` are those of the optical layout."""
    net, s = Network(), solids(detail, mount)
    for name, material, volume, at in zip(s.names, s.material, s.volume, s.centroid, strict=True):
        kg = MASS["test mass"] if part(name) == "TM" else float(volume) * MATERIALS[material][3]
        net.node(name, kg * C_P[material], at)
    conduct(net, s)
    suspend(net, detail, mount)
    spacecraft(net)
    radiate(net, s)
    bench = [n for n, name in enumerate(s.names) if name.startswith("OB_BENCH")]

    def find(at: np.ndarray) -> str:
        """The node of the bench whose cell is next below a place (mm), or nearest to it."""
        near = min(bench, key=lambda n: float(np.linalg.norm(s.centroid[n] - at)))
        cell = [int(np.clip(np.searchsorted(p, v) - 1, 0, len(p) - 2)) for p, v in zip(s.planes, at, strict=True)]
        below = [n for n in s.of[cell[0], cell[1], : cell[2] + 1] if n in bench]
        return s.names[below[-1] if below else near]

    instrument(net, detail, find, elements)
    return net


def write_network(
    detail: str, mount: Mount, m: Mesh, bars: Sequence[tuple[int, str]], elements: Sequence[dict], folder: Path
) -> None:
    """Write the tables into a folder.

    The elements of the mesh are numbered from 1; `bars` are (element id, area), those of each strut from its hub on.
    """
    net = network(detail, mount, elements)
    number = {name: n for n, name in enumerate(net.nodes)}

    def write(name: str, lines: Iterable[str]) -> None:
        (folder / f"thermal_{name}.csv").write_text("\n".join(lines) + "\n", encoding="ascii", newline="\n")

    rows = ["node,capacity_J_K,kind,temperature_K,x_m,y_m,z_m"]
    for name, (capacity, kind, temperature, at) in net.nodes.items():
        place = ",".join(f"{v + 0.0:.6f}" for v in np.round(at, 6))
        rows.append(f"{name},{capacity:.9g},{kind},{'' if temperature is None else temperature},{place}")
    write("nodes", rows)
    pairs = sorted((number[a], number[b], a, b, *g) if number[a] < number[b] else (number[b], number[a], b, a, *g)
                   for (a, b), g in net.conductors.items())  # fmt: skip
    write("conductors", ["node_a,node_b,GL_W_K,GR_m2", *(f"{a},{b},{gl:.9g},{gr:.9g}" for *_, a, b, gl, gr in pairs)])
    write("powers", ["node,power_W", *(f"{n},{net.powers[n]:.9g}" for n in sorted(net.powers, key=number.__getitem__))])
    of_elements = [
        (node_of(detail, block.area, m.xyz[corners].mean(axis=0)), eid)
        for eid, (corners, block) in enumerate(zip(m.hexes, m.block, strict=True), start=1)
    ]
    for n, (eid, area) in enumerate(bars):
        of_elements.append((f"{area}_{n % STRUT_BARS + 1}", eid))
    write("elements", ["tmm_node,element_id", *(f"{name},{eid}" for name, eid in of_elements)])
