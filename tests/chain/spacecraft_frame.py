"""A frame of bars on a plate of shells, in metres or millimetres: an instrument on a spacecraft, whole or without it.

Two feet of the frame are corners of the plate, the two others follow three of its grids (RBE3). The feet are one area
at both sides. The plate carries a box off its grid, and a second one on a rigid foot.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.config.project import Project, load_project

FEET = (11, 12, 13, 14)
CORNERS = ((0.0, 0.0), (0.4, 0.0), (0.4, 0.4), (0.0, 0.4))
TOP, PLATE = 0.0, -0.25
N = 5  # grids along an edge of the plate
BOX, HUNG = 151, 152


@dataclass(frozen=True)
class Frame:
    """How the deck is written: `mm` in mm, t, s; `held` at the plate, or else at the frame."""

    mm: bool = False
    held: bool = False

    def length(self, value: float, power: int = 1) -> str:
        return f"{value * (1e3 if self.mm else 1.0) ** power:.9e}"

    def mass(self, value: float, power: int = 0) -> str:
        return f"{value * (1e-3 if self.mm else 1.0) * (1e3 if self.mm else 1.0) ** power:.9e}"

    def card(self, *fields: object) -> str:
        return ",".join(str(f) for f in fields)

    def grid(self, number: int, x: float, y: float, z: float, cd: int = 0) -> str:
        return self.card("GRID", number, "", *(self.length(v) for v in (x, y, z)), cd)

    def plate(self, i: int, j: int) -> int:
        """Grids of the plate; two corners are feet of the frame."""
        return {(0, 0): FEET[0], (N - 1, 0): FEET[1]}.get((i, j), 101 + i + N * j)

    def instrument(self) -> list[str]:
        u, out = self, []
        for k, (x, y) in enumerate(CORNERS):
            out += [u.grid(1 + k, x, y, TOP), u.grid(FEET[k], x, y, PLATE, 5 if k == 1 else 0)]
            out += [u.card("CBAR", 1 + k, 1, 1 + k, 1 + (k + 1) % 4, "0.", "0.", "1.")]
            out += [u.card("CBAR", 11 + k, 1, 1 + k, FEET[k], "1.", ".3", "0.")]
        out += [u.card("CORD2C", 5, "", *(u.length(v) for v in (-0.1, 0.1, 0.0, -0.1, 0.1, 1.0)))]
        out += ["," + ",".join(u.length(v) for v in (0.9, 0.2, 0.0))]
        area, i1, i2, j = u.length(1e-4, 2), u.length(3e-9, 4), u.length(2e-9, 4), u.length(4e-9, 4)
        out += [u.card("PBAR", 1, 1, area, i1, i2, j)]
        return [*out, u.material(1, 114e9, 4430.0, 8.6e-6), u.material(2, 70e9, 2700.0, 2.3e-5)]

    def material(self, mid: int, e: float, rho: float, alpha: float) -> str:
        return self.card("MAT1", mid, self.mass(e, -1), "", ".3", self.mass(rho, -3), alpha, "20.")

    def spacecraft(self) -> list[str]:
        u, out = self, []
        edge = np.linspace(0.0, 0.4, N)
        for j, y in enumerate(edge):
            for i, x in enumerate(edge):
                if u.plate(i, j) > 100:
                    out.append(u.grid(u.plate(i, j), x, y, PLATE if (i, j) not in ((4, 4), (0, 4)) else PLATE - 0.02))
        for j in range(N - 1):
            for i in range(N - 1):
                corners = (u.plate(i, j), u.plate(i + 1, j), u.plate(i + 1, j + 1), u.plate(i, j + 1))
                out.append(u.card("CQUAD4", 101 + i + N * j, 2, *corners))
        out += [u.card("PSHELL", 2, 2, u.length(0.004), 2, "", 2)]
        for k, (i, j) in enumerate(((4, 4), (0, 4))):
            inner = (i - 1 if i else 1, j - 1)
            near = (u.plate(i, j), u.plate(inner[0], j), u.plate(*inner))
            out += [u.card("RBE3", 201 + k, "", FEET[2 + k], 123456, "1.", 123, *near[:2]), f",{near[2]}"]
        out += [u.grid(BOX, 0.1, 0.2, PLATE - 0.1), u.grid(HUNG, 0.3, 0.2, PLATE + 0.05)]
        out += [
            u.card("RBE2", 203, BOX, 123456, u.plate(1, 2), u.plate(1, 1), u.plate(2, 2)),
            u.card("RBE2", 204, u.plate(3, 2), 123456, HUNG),
        ]
        off = [u.length(v) for v in (0.02, -0.01, -0.05)]
        return [*out, u.card("CONM2", 301, BOX, 0, u.mass(4.0), *off), u.card("CONM2", 302, HUNG, 0, u.mass(6.0))]

    def supports(self) -> list[str]:
        return [self.card("SPC1", 1, 123456, BOX if self.held else 1)]

    def areas(self, *, whole: bool) -> str:
        lines = ["node_id,area", "1,FRAME_A", "2,FRAME_A", "3,FRAME_B", "4,FRAME_B", *(f"{g},FEET" for g in FEET)]
        if whole:
            numbers = [self.plate(i, j) for j in range(N) for i in range(N)]
            lines += [f"{g},{'PLATE_A' if n % N < 2 else 'PLATE_B'}" for n, g in enumerate(numbers) if g > 100]
        return "\n".join(lines) + "\n"

    def project(self, folder: Path, *, whole: bool, table: str = "") -> Project:
        """The project of the instrument on its spacecraft, or without it and with a `table` of superelements."""
        folder.mkdir(parents=True)
        cards = self.instrument() + (self.spacecraft() if whole else [])
        holds = whole or not self.held
        head = "SOL 101\nCEND\n" + ("SPC = 1\n" if holds else "") + "BEGIN BULK\n"
        cards += self.supports() if holds else []
        (folder / "model.bdf").write_text(head + "\n".join(cards) + "\nENDDATA\n", encoding="ascii")
        (folder / "areas.csv").write_text(self.areas(whole=whole), encoding="ascii")
        units = '\nunits = "mm-t-s"' if self.mm else ""
        (folder / "model.toml").write_text(MODEL.format(units=units) + table, encoding="utf-8")
        (folder / "tedm.toml").write_text('title = "frame"\n', encoding="utf-8")
        return load_project(folder / "tedm.toml", folder / "build")


MODEL = """
[model]
bdf = "model.bdf"
areas_csv = "areas.csv"{units}

[areas]
rule = [
    {{ match = "PLATE_*", group = "spacecraft", shield = "outside" }},
    {{ match = "*", group = "instrument", shield = "inside" }},
]

[gravity]
mass_model = "lumped"

[[test_mass]]
name = "TM1"
position_m = [0.17, 0.21, 0.02]
side_m = 0.046
mass_kg = 1.96
"""
