"""What a deck's materials lack for thermal distortion: an expansion, or a stiffness that a structure can have."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tedm_cli.areas.places import corner_areas, element_owners
from tedm_cli.arrays import BoolArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.nastran.geometry import ModelGeometry
from tedm_cli.nastran.loads.area_loads import AreaLoad
from tedm_cli.nastran.loads.temperatures import expansion_coefficients
from tedm_cli.nastran.membership import Membership, membership
from tedm_cli.nastran.plausible import odd_stiffness

_NAMED = 5  # areas and materials that are named


@dataclass(frozen=True)
class MaterialFindings:
    """Remarks on materials in use, and the areas none of whose elements expands, with the materials of these."""

    notes: list[str]
    still: list[str]
    without: list[str]

    def require(self, where: str) -> None:
        """`InputError` where the unit load of an area could move nothing."""
        if self.still:
            raise InputError(
                f"no element of {'area' if len(self.still) == 1 else 'the areas'} {_listed(self.still)} has an"
                f" expansion: without one in {_listed(self.without)} the unit load moves nothing",
                where=where,
                hint="give the materials their expansion, field A of MAT1",
            )

    @property
    def lines(self) -> list[str]:
        """The remarks, and the areas that stand still, as text."""
        still = [f"areas whose elements have no expansion: {_listed(self.still)}"] if self.still else []
        return [*still, *self.notes]


def judge_materials(model: Any, geometry: ModelGeometry, loads: Mapping[str, AreaLoad]) -> MaterialFindings:
    """Judge the materials of the elements of a cross-referenced model, and what areas are left without expansion.

    An element expands if any of its layers does. Springs and the like have no material, and are not judged.
    """
    members = membership(model, geometry, positions=False)
    names = {mid: f"{material.type} {mid}" for mid, material in sorted(model.materials.items())}
    bare = [mid for mid in names if not any(expansion_coefficients(model.materials[mid]))]
    made = members.of_material(np.array(list(names), dtype=np.int64))
    grows = members.of_material(np.array([mid for mid in names if mid not in bare], dtype=np.int64))
    rigid = made & ~grows
    of_area = _elements(geometry, loads)
    by_links = any(getattr(element, "alpha", 0.0) for element in model.rigid_elements.values())  # what also expands
    still = [n for n, rows in of_area.items() if rigid[rows].any() and not grows[rows].any() and not by_links]
    dead = np.zeros(len(made), dtype=bool)
    for name in still:
        dead[of_area[name]] = True
    notes, without = [], []
    for mid in bare:
        mine = _of(members, mid) & rigid
        if not mine.any():
            continue
        if (mine & dead).any():
            without.append(names[mid])
        of = [name for name, rows in of_area.items() if mine[rows].any()]
        number = f"{mine.sum():,} {'element does' if mine.sum() == 1 else 'elements do'} not grow"
        where = f" (in {'area' if len(of) == 1 else 'areas'} {_listed(of)})" if of else ""
        notes.append(f"{names[mid]} has no expansion: {number}{where}")
    used = [model.materials[mid] for mid in names if _of(members, mid).any()]
    return MaterialFindings([*notes, *odd_stiffness(used, geometry.units)], still, without)


def _of(members: Membership, mid: int) -> BoolArray:
    return members.of_material(np.array([mid]))


def _elements(geometry: ModelGeometry, loads: Mapping[str, AreaLoad]) -> dict[str, IntArray]:
    """Rows of the elements that get a part of the step of each area."""
    e = geometry.elements
    area = corner_areas(geometry, loads.values(), element_owners(geometry, loads.values()))
    element = np.repeat(np.arange(len(e.id)), np.diff(e.node_offset))
    return {
        name: np.unique(element[area == number]) if load.gradient is None else np.searchsorted(e.id, load.element_id)
        for number, (name, load) in enumerate(loads.items())
    }


def _listed(names: list[str]) -> str:
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return ", ".join(names[:_NAMED]) + more
