"""The mounts of the LTP-like sample: flanges on the bench, and struts from them to the spacecraft. Lengths in mm.

* clamped: eight struts, two from a hub on each of four flanges, clamped at both ends.
* pinned: eight struts with spherical joints at both ends. The lower struts lean outwards as the upper ones do: with the
  feet of the clamped mount pinned struts would be a mechanism (documentation: "Mounts").
* hexapod: those of pinned without the lower struts at +x. Six pinned struts: isostatic.
* hexapod-x: those of pinned without the lower struts at +y. Isostatic.
* bipods: three pairs of pinned struts: one on each flange at -x, one on two halves of a post under the bench at +x.
  Isostatic.

Mounts of eight struts are mirror symmetric across the x-z and the y-z plane. Six struts cannot be both: hexapod-x is
across the y-z plane, hexapod and bipods are across the x-z plane.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from ltp_like_solids import TEST_MASS_X, Block

MOUNTS = ("clamped", "pinned", "hexapod", "hexapod-x", "bipods")
STRUT_RADIUS_M = 6.0e-3
STRUT_BARS = 4  # bar elements to a strut
HUB_GAP = 5.0  # mm, of a hub before the face of its flange

_SIGNS = ((-1, -1), (-1, 1), (1, -1), (1, 1))
_SPREAD = np.array([60.0, 100.0, 110.0])  # of a strut from its hub along x, y, z: all have one length


@dataclass(frozen=True)
class Flange:
    """A flange, and the hub before its face that drives the nodes of the face within a box of half widths."""

    number: int
    block: Block
    hub: np.ndarray
    axis: int  # that the face is normal to
    half_width: tuple[float, float, float]

    @property
    def area(self) -> str:
        return f"FLANGE_{self.number}"

    def face(self, xyz: np.ndarray, area: Sequence[str]) -> np.ndarray:
        """Numbers of the nodes of the face."""
        outward = np.sign(self.hub[self.axis])
        near = np.array([a == self.area for a in area])
        near &= np.abs(xyz[:, self.axis] - (self.hub[self.axis] - HUB_GAP * outward)) < 1e-6
        for other in {0, 1, 2} - {self.axis}:
            near &= np.abs(xyz[:, other] - self.hub[other]) < self.half_width[other]
        return np.nonzero(near)[0]


@dataclass(frozen=True)
class Strut:
    """A strut from the hub of its flange to a panel of the spacecraft."""

    number: int
    flange: int
    hub: np.ndarray
    end: np.ndarray
    panel: str


@dataclass(frozen=True)
class Mount:
    """A mount; `pinned` struts have spherical joints, and only the foot keeps them from turning about themselves."""

    name: str
    flanges: tuple[Flange, ...]
    struts: tuple[Strut, ...]
    pinned: bool

    @property
    def blocks(self) -> list[Block]:
        return [flange.block for flange in self.flanges]

    @property
    def planes(self) -> dict[str, list[float]]:
        """Planes of the mesh, by axis, that its flanges need beside those of the other parts."""
        return {"y": [-12.0, 12.0], "z": [-81.0, -93.0]} if self.name == "bipods" else {}


def mount(name: str, detail: str) -> Mount:
    """The mount of a name, on the full or the small model."""
    flanges = [side_flange(n, detail) for n in (1, 2, 3, 4)]
    if name == "bipods":
        flanges[2:] = [lower_flange(n, detail) for n in (3, 4)]
    struts = [strut for flange in flanges for strut in struts_of(flange, name)]
    return Mount(name, tuple(flanges), tuple(struts), name != "clamped")


def side_flange(number: int, detail: str) -> Flange:
    """On the sidewall beside an inertial sensor, all along the bracket behind it."""
    sx, sy = _SIGNS[number - 1]
    full = detail == "full"
    z, u, y = ((-33, 33), 27, (121, 133)) if full else ((-33, -12), 33, (106, 121))
    x = sorted((sx * (TEST_MASS_X - u), sx * (TEST_MASS_X + u)))
    across = sorted((sy * y[0], sy * y[1]))
    block = Block(f"FLANGE_{number}", "titanium", (x[0], x[1]), (across[0], across[1]), z)
    hub = np.array([sx * TEST_MASS_X, sy * (y[1] + HUB_GAP), 0.0 if full else -12.0])
    return Flange(number, block, hub, 1, (33.5, np.inf, 12.5 if full else 33.5))


def lower_flange(number: int, detail: str) -> Flange:
    """Half of a post under the bench at +x, on one side of the x-z plane."""
    sy = _SIGNS[number - 1][1]
    y = (-27.0, 0.0) if sy < 0 else (0.0, 27.0)
    x = (72.0, 100.0) if detail == "full" else (33.0, 100.0)
    block = Block(f"FLANGE_{number}", "titanium", x, y, (-93.0, -57.0))
    # Not the nodes in the x-z plane: a rigid element may not take those that another has.
    hub = np.array([sum(x) / 2, sy * 19.5, -93.0 - HUB_GAP])
    return Flange(number, block, hub, 2, (40.0, 10.0, np.inf))


def struts_of(flange: Flange, name: str) -> list[Strut]:
    """Up to two struts; the number of each is the same in all mounts."""
    n = flange.number
    sx, sy = _SIGNS[n - 1]
    under = flange.axis == 2
    # Of the bipods at -x the planes are about tangential to a circle around the bench, as of kinematic mounts.
    along = -sx if name == "bipods" and not under else sx
    out = []
    for k, up in enumerate((1, -1), start=1):
        if k == 2 and (under or (name, sx) == ("hexapod", 1) or (name, sy) == ("hexapod-x", 1)):
            continue
        step = _SPREAD * [along, sy, -1 if under else up]
        if name == "clamped" and up < 0:
            step[0] *= -1
        panel = "MINUS_Z" if under else "PLUS_Y" if sy > 0 else "MINUS_Y"
        out.append(Strut(2 * (n - 1) + k, n, flange.hub, flange.hub + step, panel))
    return out
