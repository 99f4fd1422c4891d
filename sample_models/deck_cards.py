"""Cards of the sample decks, and the mesh nodes that optical elements follow."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from ltp_like_solids import MM, Mesh


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


def round_bar(pid: int, mid: int, radius: float) -> str:
    """Property of a solid round bar; `radius` in m."""
    area = math.pi * radius**2
    inertia = math.pi * radius**4 / 4
    return field8("PBAR", pid, mid, real8(area), real8(inertia), real8(inertia), real8(2 * inertia))


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
