"""Area, moments of inertia, torsion constant and shear factors of the cross-sections of PBARL and PBEAML.

Torsion of rectangles and thin-walled boxes: Young & Budynas, Roark's Formulas for Stress and Strain, chapter 10. Shear
factors: 5/6 of a rectangle, 0.9 of a circle, 1/2 of a thin tube, the share of the webs of a box.
"""

from __future__ import annotations

import math
from collections.abc import Callable

Section = tuple[float, float, float, float, float, float, float]
"""Area, I1, I2, I12, J, K1, K2."""


def _tube(outer: float, inner: float = 0.0) -> Section:
    inertia = math.pi * (outer**4 - inner**4) / 4.0
    shear = 0.5 if inner else 0.9
    return math.pi * (outer**2 - inner**2), inertia, inertia, 0.0, 2.0 * inertia, shear, shear


def _bar(width: float, height: float) -> Section:
    b, h = max(width, height), min(width, height)
    torsion = b * h**3 * (1.0 / 3.0 - 0.21 * h / b * (1.0 - h**4 / (12.0 * b**4)))
    shear = 5.0 / 6.0
    return b * h, width * height**3 / 12.0, height * width**3 / 12.0, 0.0, torsion, shear, shear


def _box(width: float, height: float, flange: float, web: float) -> Section:
    inner_width, inner_height = width - 2.0 * web, height - 2.0 * flange
    area = width * height - inner_width * inner_height
    middle = (width - web) * (height - flange)
    torsion = 2.0 * flange * web * middle**2 / (width * web + height * flange - web**2 - flange**2)
    return (
        area,
        (width * height**3 - inner_width * inner_height**3) / 12.0,
        (height * width**3 - inner_height * inner_width**3) / 12.0,
        0.0,
        torsion,
        2.0 * web * height / area,
        2.0 * flange * width / area,
    )


SECTIONS: dict[str, Callable[..., Section]] = {
    "ROD": _tube,
    "TUBE": _tube,
    "TUBE2": lambda outer, thickness: _tube(outer, outer - thickness),
    "BAR": _bar,
    "BOX": _box,
}
"""Sections by Nastran's name; the arguments are DIM1, DIM2, ... of the card."""
