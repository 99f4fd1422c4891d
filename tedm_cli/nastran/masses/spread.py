"""How the mass of elements of one card is spread over them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError

ToBasic = Callable[[int, FloatArray], FloatArray]
"""Turns a vector [3] in the displacement frame (CD) of a grid, by its id, into the basic frame."""


@dataclass(frozen=True)
class Spread:
    """Mass of E elements of one card with n nodes, before PARAM,WTMASS.

    structural, nonstructural : [E, n], at the nodes, per m³, m² or m.
    axis : [E, n, 3], from each node to the line or surface that is measured (bar offsets), basic frame, m.
    structural_lever, nonstructural_lever : [E, n, 3], from each node to either mass, basic frame, m.
    section : [E], thickness of plates (m), area of line elements (m²), 0 for solids.
    """

    structural: FloatArray
    nonstructural: FloatArray
    axis: FloatArray
    structural_lever: FloatArray
    nonstructural_lever: FloatArray
    section: FloatArray

    @property
    def is_uneven(self) -> bool:
        """Whether any of the mass is off its node, or more at one node than at another."""
        uneven = any((mass != mass[:, :1]).any() for mass in (self.structural, self.nonstructural))
        return bool(uneven or self.structural_lever.any() or self.nonstructural_lever.any())

    def part(self, rows: slice) -> Spread:
        """The spread of some of the elements."""
        return Spread(
            self.structural[rows],
            self.nonstructural[rows],
            self.axis[rows],
            self.structural_lever[rows],
            self.nonstructural_lever[rows],
            self.section[rows],
        )


def density_of(material: Any, what: str, where: str) -> float:
    """Density of a material card; 0 where it gives none. `InputError` for materials that are no solids."""
    if material is None:
        return 0.0
    if material.type == "MAT10":
        raise InputError(f"{what}: fluids (MAT10) are not read", where=where, hint="leave the fluid out of the deck")
    if material.type in ("MAT4", "MAT5"):
        raise InputError(f"{what}: {material.type} {material.mid} is a material of heat transfer alone", where=where)
    return float(getattr(material, "rho", 0.0) or 0.0)
