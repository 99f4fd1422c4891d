"""Two plates on top of each other, joined by four short struts: decks and projects of a test."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.config.project import Project, load_project
from tedm_cli.nastran.loads.area_loads import AreaLoad

LENGTH, ALPHA = 0.1, 8.6e-6  # of the struts: m, 1/K
AREA, INERTIA = np.pi * 0.006**2, np.pi * 0.006**4 / 4.0  # rods of 12 mm
NX, NY = 8, 6  # elements of a plate
CORNERS = ((1, 1), (7, 1), (7, 5), (1, 5))  # plate grids at the struts
HEAD = "SOL 101\nCEND\nSPC = 1\nBEGIN BULK\n"


@dataclass(frozen=True)
class Scale:
    """How the deck is written: its units of length (m) and mass (kg), its degrees, TREF in these."""

    length: float = 1.0
    mass: float = 1.0
    fahrenheit: bool = False
    tref: str = "0."

    def real(self, value: float, length: int = 0, mass: int = 0) -> str:
        mantissa, exponent = f"{value / self.length**length / self.mass**mass:.9e}".split("e")
        return f"{mantissa}{int(exponent):+d}"

    def expansion(self, value: float) -> str:
        return self.real(value / 1.8 if self.fahrenheit else value)


def card(name: str, *fields: object) -> str:
    texts = [f"{f!s:>16}" for f in fields]
    texts += [" " * 16] * (-len(texts) % 8)
    starts = [f"{name + '*':8}", *["*       "] * (len(texts) // 4 - 1)]
    return "\n".join(start + "".join(texts[4 * k : 4 * k + 4]).rstrip() for k, start in enumerate(starts))


def plate_grid(plate: int, i: int, j: int) -> int:
    return 1000 * plate + 1 + i + (NX + 1) * j


def strut_element(strut: int, part: int = 0) -> int:
    return 5000 + 100 * strut + part


def bulk(parts: int = 1, scale: Scale = Scale(), *, block: bool = False) -> str:
    """Bulk data with `parts` bars in each strut, and a block of two solids on the upper plate, if wanted.

    Shells are 1 to 48 (lower plate) and 1001 to 1048. The plates' rotation about their normals is held: it has no
    stiffness but what solvers invent.
    """
    s = scale
    lines = []
    for mid, (e, nu, rho, a) in enumerate([(7e10, 0.33, 2700.0, 2.3e-5), (1.1e11, 0.34, 4430.0, ALPHA)], start=1):
        lines.append(card("MAT1", mid, s.real(e, -1, 1), "", s.real(nu), s.real(rho, -3, 1), s.expansion(a), s.tref))
    lines += [card("PSHELL", 1, 1, s.real(0.01, 1), 1, "", 1), "PARAM,K6ROT,0."]
    section = (s.real(AREA, 2), *(s.real(i, 4) for i in (INERTIA, INERTIA, 2.0 * INERTIA)))
    lines.append(card("PBAR", 2, 2, *section))
    places = {
        plate_grid(p, i, j): (0.05 * i - 0.2, 0.05 * j - 0.15, LENGTH * p)
        for p in (0, 1)
        for j in range(NY + 1)
        for i in range(NX + 1)
    }
    lines.append(card("SPC1", 1, 6, *list(places)[:6]))
    lines += [card("SPC1", 1, 6, *list(places)[k : k + 6]) for k in range(6, len(places), 6)]
    for p in (0, 1):
        for j in range(NY):
            for i in range(NX):
                ring = (
                    plate_grid(p, i, j),
                    plate_grid(p, i + 1, j),
                    plate_grid(p, i + 1, j + 1),
                    plate_grid(p, i, j + 1),
                )
                lines.append(card("CQUAD4", 1000 * p + 1 + i + NX * j, 1, *ring))
    for k, (i, j) in enumerate(CORNERS):
        inner = [3000 + 100 * k + m for m in range(1, parts)]
        for m, grid in enumerate(inner, start=1):
            places[grid] = (0.05 * i - 0.2, 0.05 * j - 0.15, LENGTH * m / parts)
        chain = [plate_grid(0, i, j), *inner, plate_grid(1, i, j)]
        for m in range(parts):
            lines.append(card("CBAR", strut_element(k, m), 2, chain[m], chain[m + 1], "1.", "0.", "0."))
    if block:
        lines.append(card("PSOLID", 3, 1))
        for n, i in enumerate((3, 4)):
            base = [(i, 2), (i + 1, 2), (i + 1, 3), (i, 3)]
            for ii, jj in base:
                x, y, z = places[plate_grid(1, ii, jj)]
                places[plate_grid(2, ii, jj)] = (x, y, z + 0.03)
            lines.append(card("CHEXA", 7001 + n, 3, *(plate_grid(p, ii, jj) for p in (1, 2) for ii, jj in base)))
    lines += [card("GRID", grid, "", *(s.real(v, 1) for v in place)) for grid, place in places.items()]
    held = (plate_grid(0, 0, 0), plate_grid(0, NX, 0), plate_grid(0, NX // 2, NY))
    lines.append(card("SPC1", 1, 12345, *held))
    return "\n".join(lines) + "\n"


def slopes(load: AreaLoad) -> np.ndarray:
    """The gradients of an area under one."""
    assert load.gradient is not None
    return load.gradient


def deck(parts: int = 1, scale: Scale = Scale(), *, block: bool = False) -> str:
    return HEAD + bulk(parts, scale, block=block) + "ENDDATA\n"


def project(folder: Path, text: str, define: str, keys: str = "") -> Project:
    """A project whose model has this text and whose areas these `[[areas.define]]` tables."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "model.bdf").write_text(text)
    rule = '[areas]\nrule = [{ match = "*", group = "all", shield = "inside" }]\n'
    (folder / "model.toml").write_text(f'[model]\nbdf = "model.bdf"\n{keys}\n{rule}{define}')
    (folder / "tedm.toml").write_text('title = "plates and struts"\n')
    return load_project(folder / "tedm.toml", folder / "build")


def define(name: str, **keys: object) -> str:
    """One table of definitions; values as TOML writes them."""
    lines = [f'name = "{name}"', *(f"{key} = {value}" for key, value in keys.items())]
    return "[[areas.define]]\n" + "\n".join(lines) + "\n"


LOWER = define("LOWER", property=1, box="{ z_m = [-inf, 0.05] }")
UPPER = define("UPPER", property=1)
REST = define("REST", remainder="true")
