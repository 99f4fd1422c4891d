"""A plate instrument of about a thousand grids, in any units and anywhere: one test mass, six struts, a Michelson.

It is given in SI and in the frame of its optical layout, and written in a system of units of its own conversion, turned
and shifted as a whole. Its cards bring in what has a dimension in one place only: offsets of shells and bars, levers of
equations between displacements, inertias and lever of concentrated masses in two frames, non-structural mass per area,
per length and as a lump, places in a cylindrical frame, whose angles are no lengths.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tedm_cli.arrays import FloatArray
from tedm_cli.config.project import Project, load_project

INCH, POUND_FORCE = 0.0254, 4.4482216152605
SYSTEMS = {
    "m-kg-s": (1.0, 1.0),
    "mm-t-s": (1e-3, 1e3),
    "mm-kg-s": (1e-3, 1.0),
    "in-lbf-s": (INCH, POUND_FORCE / INCH),
}
FREE, TRACKED = 9001, {"FI": 9001, "BS": 9002, "M": 9003, "PD": 9004}
TEST_MASS, SIDES = (0.13, 0.0, 0.0), (0.046, 0.05, 0.04)
PLATE_Z = -0.05
# Layout of the Michelson: the splitter at the origin, the test mass along x, the mirror along y.
PLACES = {"FI": (0.0, -0.1, 0.0), "BS": (0.0, 0.0, 0.0), "M": (0.0, 0.09, 0.0), "PD": (-0.08, 0.0, 0.0)}


@dataclass(frozen=True)
class Units:
    """How a deck is written: its units of length (m) and mass (kg); degrees Fahrenheit or not; densities as weights."""

    name: str = "m-kg-s"
    fahrenheit: bool = False
    wtmass: float = 1.0

    def length(self, value: float, power: int = 1) -> str:
        return real(value / SYSTEMS[self.name][0] ** power)

    def mass(self, value: float, power: int = 0) -> str:
        """A mass times a length to some power, before PARAM,WTMASS."""
        length, mass = SYSTEMS[self.name]
        return real(value / mass / length**power / self.wtmass)

    def stress(self, value: float) -> str:
        length, mass = SYSTEMS[self.name]
        return real(value / mass * length)

    def expansion(self, value: float) -> str:
        return real(value / 1.8 if self.fahrenheit else value)

    def temperature(self, celsius: float) -> str:
        return real(celsius * 1.8 + 32.0 if self.fahrenheit else celsius)


@dataclass(frozen=True)
class Place:
    """Where the layout's frame is in the model's: a place of the layout is at `turn` x + `shift`."""

    turn: FloatArray = field(default_factory=lambda: np.eye(3))
    shift: FloatArray = field(default_factory=lambda: np.zeros(3))

    def point(self, x: object) -> FloatArray:
        return self.turn @ np.array(x, dtype=float) + self.shift

    def vector(self, v: object) -> FloatArray:
        return np.asarray(self.turn @ np.array(v, dtype=float))


TURNED = Place(
    Rotation.from_rotvec(np.radians(30.0) * np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)).as_matrix(),
    np.array([0.31, -0.23, 0.52]),
)


def real(value: float) -> str:
    """A number with as many digits as the sixteen columns of a large field hold."""
    for digits in range(16, 0, -1):
        mantissa, _, exponent = f"{value:.{digits}g}".partition("e")
        mantissa = mantissa.replace("0.", ".", 1) if mantissa.lstrip("-").startswith("0.") else mantissa
        text = mantissa + ("" if "." in mantissa else ".") + (f"{int(exponent):+d}" if exponent else "")
        if len(text) <= 16:
            return text
    raise ValueError(value)


def card(name: str, *fields: object) -> str:
    """A card in large fields; text and integers go as they are."""
    texts = [f"{f!s:>16}" for f in fields]
    texts += [" " * 16] * (-len(texts) % 8)
    starts = [f"{name + '*':8}", *["*       "] * (len(texts) // 4 - 1)]
    return "\n".join(start + "".join(texts[4 * k : 4 * k + 4]).rstrip() for k, start in enumerate(starts))


def lengths(units: Units, vector: FloatArray) -> list[str]:
    return [units.length(float(v)) for v in vector]


class Instrument:
    """The cards of the instrument with `nx` times `ny` grids in its plate."""

    def __init__(self, units: Units = Units(), place: Place = Place(), nx: int = 33, ny: int = 29) -> None:
        self.units, self.place, self.nx, self.ny = units, place, nx, ny
        self.x, self.y = np.linspace(-0.2, 0.2, nx), np.linspace(-0.15, 0.15, ny)

    def plate_grid(self, x: float, y: float) -> int:
        """The grid of the plate nearest to a place."""
        i, j = int(np.abs(self.x - x).argmin()), int(np.abs(self.y - y).argmin())
        return 1 + i + self.nx * j

    def plate_place(self, grid: int) -> FloatArray:
        j, i = divmod(grid - 1, self.nx)
        return np.array([self.x[i], self.y[j], PLATE_Z])

    def grid(self, number: int, where: object) -> str:
        return card("GRID", number, "", *lengths(self.units, self.place.point(where)), "", "", "")

    def bulk(self) -> str:
        parts = (self.frames, self.materials, self.plate, self.optics, self.struts, self.masses)
        return "\n".join(text for part in parts for text in part()) + "\n"

    def frames(self) -> Iterator[str]:
        """5: the layout's frame; 6: a cylindrical one about its z axis."""
        for kind, cid in (("R", 5), ("C", 6)):
            points = [self.place.point(p) for p in ((0.0, 0.0, PLATE_Z), (0.0, 0.0, 1.0), (1.0, 0.0, PLATE_Z))]
            yield card(f"CORD2{kind}", cid, "", *(t for p in points for t in lengths(self.units, p)))

    def materials(self) -> Iterator[str]:
        u, cold = self.units, self.units.temperature(20.0)
        for mid, (e, nu, rho, a) in enumerate(
            [(70e9, 0.33, 2700.0, 2.3e-5), (90.3e9, 0.24, 2530.0, 2e-8), (114e9, 0.34, 4430.0, 8.6e-6)], start=1
        ):
            yield card("MAT1", mid, u.stress(e), "", real(nu), u.mass(rho, -3), u.expansion(a), cold)
        if u.wtmass != 1.0:
            yield card("PARAM", "WTMASS", real(u.wtmass))

    def plate(self) -> Iterator[str]:
        """Two halves of other thickness and material, off their grids, stiffer in bending than they are thick."""
        u = self.units
        yield card("PSHELL", 1, 1, u.length(0.012), 1, "1.5", 1, ".7", u.mass(2.0, -2))
        yield card("PSHELL", 2, 2, u.length(0.016), 2, "", 2)
        yield card("NSM1", 7, "PSHELL", u.mass(1.5, -2), 2)
        yield card("NSML1", 7, "PBAR", u.mass(0.1), 3)
        for grid in range(1, 1 + self.nx * self.ny):
            yield self.grid(grid, self.plate_place(grid))
        for j in range(self.ny - 1):
            for i in range(self.nx - 1):
                a = 1 + i + self.nx * j
                pid = 1 if self.y[j] < -1e-9 else 2
                corners = (a, a + 1, a + 1 + self.nx, a + self.nx)
                yield card("CQUAD4", a, pid, *corners, "", u.length(0.003))

    def optics(self) -> Iterator[str]:
        """An interpolated injector, a splitter on a post, a mirror on a rigid foot, a diode that equations tie."""
        u = self.units
        for name, grid in TRACKED.items():
            yield self.grid(grid, PLACES[name])
        near = [self.plate_grid(PLACES["FI"][0] + dx, PLACES["FI"][1] + dy) for dx, dy in AROUND]
        yield card("RBE3", 9101, "", TRACKED["FI"], 123456, "1.", 123, *near)
        foot = self.plate_grid(*PLACES["BS"][:2])
        yield card("CBAR", 9102, 4, foot, TRACKED["BS"], *(real(v) for v in self.place.vector((1.0, 0.0, 0.0))))
        yield card("PBARL", 4, 3, "", "ROD", "", "", "", "", u.length(0.006), u.mass(0.2, -1))
        near = [self.plate_grid(PLACES["M"][0] + dx, PLACES["M"][1] + dy) for dx, dy in AROUND]
        yield card("RBE2", 9103, TRACKED["M"], 123456, *near)
        yield from self.equations(TRACKED["PD"], self.plate_grid(*PLACES["PD"][:2]))

    def equations(self, diode: int, foot: int) -> Iterator[str]:
        """The diode follows a grid of the plate as a rigid body: u_d = u_f + turn x lever, in basic components."""
        lever = self.place.vector(np.array(PLACES["PD"]) - self.plate_place(foot))
        for k in range(3):
            one, two = (k + 1) % 3, (k + 2) % 3
            yield card(
                "MPC", 8, diode, k + 1, "1.", foot, k + 1, "-1.", "",
                "", foot, one + 4, self.units.length(-lever[two]), foot, two + 4, self.units.length(lever[one]), "",
            )  # fmt: skip
            yield card("MPC", 8, diode, k + 4, "1.", foot, k + 4, "-1.")

    def struts(self) -> Iterator[str]:
        """Six bars to clamped feet, with a grid half way, both in the cylindrical frame."""
        u = self.units
        yield card(
            "PBAR", 3, 3, u.length(1.2e-4, 2), u.length(2e-9, 4), u.length(1e-9, 4), u.length(2.5e-9, 4),
            u.mass(0.05, -1), "", *[""] * 8, "", "", u.length(3e-10, 4),
        )  # fmt: skip
        for k in range(6):
            corner = np.radians(60.0 * (k // 2) * 2 + 30.0)
            top = self.plate_grid(0.14 * np.cos(corner), 0.14 * np.sin(corner))
            end = self.plate_place(top) - [0.0, 0.0, PLATE_Z]
            angle = corner + (-0.4 if k % 2 else 0.4)
            foot = np.array([0.26 * np.cos(angle), 0.26 * np.sin(angle), -0.16])
            for number, p in ((FOOT + k, foot), (MIDDLE + k, (foot + end) / 2.0)):
                r, theta = np.hypot(*p[:2]), np.degrees(np.arctan2(p[1], p[0]))
                yield card("GRID", number, 6, u.length(r), real(theta), u.length(p[2]), 6, "", "")
            yield card("CBAR", 9200 + k, 3, FOOT + k, MIDDLE + k, "0.", "0.", "1.")
            down = lengths(u, self.place.vector((0.0, 0.0, -0.006)))
            yield card(
                "CBAR", 9300 + k, 3, MIDDLE + k, top, "0.", "0.", "1.", "", "", "", "0.", "0.", "0.", *down
            )  # fmt: skip
            yield card("SPC1", 9, 123456, FOOT + k)
        yield card("CONROD", 9400, MIDDLE, MIDDLE + 1, 3, u.length(3e-5, 2), u.length(1e-10, 4), "", u.mass(0.03, -1))

    def masses(self) -> Iterator[str]:
        """A box off its grid given along the layout's axes, another one along the model's, a scalar mass."""
        u, inertia = self.units, np.array([[4e-3, 3e-4, -2e-4], [3e-4, 5e-3, 1e-4], [-2e-4, 1e-4, 6e-3]])
        for number, (grid, cid) in enumerate([(self.plate_grid(-0.15, 0.1), 5), (self.plate_grid(0.15, -0.1), 0)]):
            turn = np.eye(3) if cid else self.place.turn
            offset, i = turn @ [0.01, -0.02, -0.03], turn @ inertia @ turn.T
            upper = [i[0, 0], -i[0, 1], i[1, 1], -i[0, 2], -i[1, 2], i[2, 2]]
            yield card(
                "CONM2", 9500 + number, grid, cid, u.mass(2.5 + number), *lengths(u, offset), "",
                *(u.mass(float(v), 2) for v in upper),
            )  # fmt: skip
        for component in (1, 2, 3):
            yield card("CMASS2", 9510 + component, u.mass(0.4), self.plate_grid(-0.1, -0.1), component)


AROUND = ((-0.03, -0.03), (0.03, -0.03), (0.03, 0.03), (-0.03, 0.03))
FOOT, MIDDLE = 9020, 9030
HEAD = "SOL 101\nCEND\nSPC = 9\nMPC = 8\nNSM = 7\nBEGIN BULK\n"

MODEL = """
[model]
bdf = "model.bdf"
{keys}

[areas]
rule = [{{ match = "*", group = "all", shield = "inside" }}]
[[areas.define]]
name = "CORNER"
property = [1, 2]
box = {{ frame = 6, r_m = [0.19, inf], theta_deg = [0.0, 90.0] }}
[[areas.define]]
name = "PLATE_BACK"
property = [1, 2]
box = {{ frame = 5, y_m = [-inf, -0.02] }}
[[areas.define]]
name = "PLATE_FRONT"
property = [1, 2]
[[areas.define]]
name = "FEET"
property = 3
box = {{ frame = 5, z_m = [-inf, -0.15] }}
[[areas.define]]
name = "REST"
remainder = true

[[test_mass]]
name = "TM1"
position_m = {position}
side_m = {sides}
mass_kg = 1.84
axes = {axes}
"""

OPTICS = """
title = "Michelson on a plate"
wavelength_m = 1.064e-6
read_out = ["x", "eta", "phi"]
frame = {{ origin_m = {origin}, axes = {axes} }}
sets = {{ A = ["PD"] }}

[[element]]
name = "TM1"
kind = "test_mass"
ref_m = {test_mass}
normal = [-1.0, 0.0, 0.0]
front_offset_m = 0.023

[[element]]
name = "FI"
kind = "injector"
grid = 9001
ref_m = [0.0, -0.1, 0.0]
normal = [0.0, 1.0, 0.0]

[[element]]
name = "BS"
kind = "beamsplitter"
grid = 9002
ref_m = [0.0, 0.0, 0.0]
normal = [0.7071067811865476, -0.7071067811865476, 0.0]
thickness_m = 0.005
index = 1.45

[[element]]
name = "M"
kind = "mirror"
grid = 9003
ref_m = [0.0, 0.09, 0.0]
normal = [0.0, -1.0, 0.0]

[[element]]
name = "PD"
kind = "photodiode"
grid = 9004
ref_m = [-0.08, 0.0, 0.0]
normal = [1.0, 0.0, 0.0]
local_y = [0.0, 0.0, 1.0]

[[path]]
photodiode = "PD"
beam = "meas"
steps = ["FI", "BS:R", "TM1:R", "BS:T", "PD"]

[[path]]
photodiode = "PD"
beam = "ref"
steps = ["FI", "BS:T", "M:R", "BS:R", "PD"]
"""


def rows(matrix: FloatArray) -> str:
    return str([[float(v) for v in row] for row in matrix])


def write_project(folder: Path, instrument: Instrument, keys: str = "") -> Project:
    """The instrument as a project in `folder`; `keys`: what `[model]` says of its units."""
    folder.mkdir(parents=True, exist_ok=True)
    place = instrument.place
    axes = rows(place.turn.T)  # what the layout calls x, y, z, in the model's frame
    (folder / "model.bdf").write_text(HEAD + instrument.bulk() + "ENDDATA\n", encoding="ascii")
    (folder / "tedm.toml").write_text('title = "plate"\n', encoding="utf-8")
    position = [float(v) for v in place.point(TEST_MASS)]
    model = MODEL.format(keys=keys, position=position, sides=list(SIDES), axes=axes)
    (folder / "model.toml").write_text(model, encoding="utf-8")
    origin = [float(v) for v in place.shift]
    optics = OPTICS.format(origin=origin, axes=axes, test_mass=list(TEST_MASS))
    (folder / "optics.toml").write_text(optics, encoding="utf-8")
    return load_project(folder / "tedm.toml", folder / "build")
