"""Parts of the model by name: what they make up of the limited quantities, and how that changes with their place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.config.model.as_built import PartName
from tedm_cli.contracts import UNIT_LOADS
from tedm_cli.errors import InputError
from tedm_cli.files.store import Reader
from tedm_cli.gravity.masses import MassDistribution
from tedm_cli.gravity.requirements import dc_quantities
from tedm_cli.gravity.structure import StructureGravity, structure_gravity
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.progress import Step, counter
from tedm_cli.results.gravity.at_rest import BY_AREA
from tedm_cli.results.unit_loads import area_of_elements, area_of_grids, mass_of
from tedm_cli.stages.balance.rest import Rest
from tedm_cli.threads import side_by_side

_STEP_M = 5e-4  # to either side: less, and quadratures that are cut anew at either side differ by more than the field
_NO_AREA = "\n"  # group of grids that are in no area: no group has this name


@dataclass(frozen=True, eq=False)
class PartField:
    """A part of mass_kg and the values of the limited quantities [r] that it makes up, SI.

    by_shift : [3, r], their change per metre along each axis of the basic frame; curve : [3, r], that of by_shift.
    """

    name: str
    mass_kg: float
    value: FloatArray
    by_shift: FloatArray
    curve: FloatArray

    def change(self, mass: FloatArray, shift_m: FloatArray) -> FloatArray:
        """Change [d, r] by relative changes of its mass [d] and shifts [d, 3], to the second order along each axis."""
        moved = shift_m @ self.by_shift + 0.5 * shift_m**2 @ self.curve
        return np.asarray(mass[:, None] * self.value + (1.0 + mass[:, None]) * moved)


class Parts:
    """The parts of a model."""

    def __init__(self, unit: Reader, rest: Rest) -> None:
        self.unit, self.rest = unit, rest
        self._property = unit.array(UNIT_LOADS.ELEMENT_PROPERTY_ID)
        self._mass = unit.array(UNIT_LOADS.ELEMENT_MASS)
        self._concentrated = unit.array(UNIT_LOADS.MASS_CONCENTRATED)
        self._on = unit.array(UNIT_LOADS.GRID_ID)[unit.array(UNIT_LOADS.MASS_CONCENTRATED_NODE)]
        self._area = unit.strings(UNIT_LOADS.AREA_NAME)
        of_grid = area_of_grids(unit)
        groups = unit.strings(UNIT_LOADS.AREA_GROUP)
        self._group = np.array([*groups, _NO_AREA])[of_grid]
        self._area_of_element = _most_of(unit, of_grid)
        self._area_of_concentrated = of_grid[unit.array(UNIT_LOADS.MASS_CONCENTRATED_NODE)]

    def members(self, part: PartName) -> tuple[BoolArray, BoolArray]:
        """Elements and concentrated masses of a part; `InputError` where it has no mass."""
        elements, points = np.zeros(len(self._mass), dtype=bool), np.zeros(len(self._concentrated), dtype=bool)
        if part.kind == "property":
            elements = (self._property >= part.low) & (self._property <= part.high)
        elif part.kind == "grid":
            points = (self._on >= part.low) & (self._on <= part.high)
        elif part.name in self._area:
            number = self._area.index(part.name)
            elements, points = self._area_of_element == number, self._area_of_concentrated == number
        if not (self._mass[elements].any() or self._concentrated[points].any()):
            fact = "no concentrated mass" if part.kind == "grid" else "no element with mass"
            raise InputError(f"the model has {fact} of {part.words}", where=part.where, hint=self._hint(part))
        return elements, points

    def _hint(self, part: PartName) -> str:
        if part.kind == "property":
            return f"its properties: {_few(np.unique(self._property[self._mass > 0]).tolist())}"
        if part.kind == "grid":
            return f"grids with concentrated masses: {_few(np.unique(self._on).tolist()) or 'none'}"
        return f"its thermal areas: {_few(self._area)}"

    def fields(self, parts: Sequence[PartName], step: Step) -> list[PartField]:
        """The field of each part, and how it changes with its place.

        Raises
        ------
        InputError : a part has no mass, or shares mass with another.
        """
        taken = np.zeros(len(self._mass) + len(self._concentrated), dtype=np.int64)
        chosen = []
        for number, part in enumerate(parts, start=1):
            elements, points = self.members(part)
            own = np.concatenate([elements, points])
            if (there := taken[own]).any():
                other = parts[int(there.max()) - 1].words
                raise InputError(f"{part.words} has mass that is in {other} already", where=part.where)
            taken[own] = number
            chosen.append(mass_of(self.unit, lumped=self._lumped, elements=elements, concentrated=points))
        advance = counter(step, len(chosen), "field of the parts")
        return side_by_side(
            lambda of, on: self._field(*of, on), [(p.words, m) for p, m in zip(parts, chosen, strict=True)], advance
        )

    @property
    def _lumped(self) -> bool:
        return self.rest.config.gravity.mass_model == "lumped"

    def _field(self, name: str, masses: MassDistribution, advance: object) -> PartField:
        at_rest = self.values(masses, np.zeros(3))
        by_shift, curve = np.zeros((3, len(at_rest))), np.zeros((3, len(at_rest)))
        for axis, along in enumerate(np.eye(3)):
            ahead, behind = (self.values(masses, way * _STEP_M * along) for way in (1.0, -1.0))
            by_shift[axis] = (ahead - behind) / (2.0 * _STEP_M)
            curve[axis] = (ahead - 2.0 * at_rest + behind) / _STEP_M**2
        if callable(advance):
            advance(1)
        return PartField(name, masses.total_kg, at_rest, by_shift, curve)

    def values(self, masses: MassDistribution, shift_m: FloatArray) -> FloatArray:
        """What moved masses make up of the limited quantities [r]: each grid's share by the group of its area."""
        gravity = self.rest.config.gravity
        found = np.zeros(len(self.rest.before))
        for t, tm in enumerate(self.rest.test_masses):
            away = TestMass(
                name=tm.name, position_m=tm.position_m - shift_m, mass_kg=tm.mass_kg, body=tm.body, axes=tm.axes
            )
            field = structure_gravity(
                masses, away, tolerance=gravity.quadrature_tolerance, G=gravity.gravitational_constant_m3_kg_s2
            )
            for group, sums in self._by_group(field).items():
                found += self.rest.functional(t, group) @ sums
        return found

    def _by_group(self, field: StructureGravity) -> dict[str, FloatArray]:
        """What can be judged [12] by the group of the grids."""
        shares = [field.nodal(name) for name in BY_AREA]
        return {
            str(group): dc_quantities(*(share[self._group == group].sum(axis=0) for share in shares))
            for group in np.unique(self._group)
        }


def _most_of(unit: Reader, of_grid: IntArray) -> IntArray:
    """Row of the thermal area of each element [E], -1: none: its own, or that of most of its grids."""
    own = area_of_elements(unit)
    offset, index = unit.array(UNIT_LOADS.ELEMENT_NODE_OFFSET), unit.array(UNIT_LOADS.ELEMENT_NODE_INDEX)
    areas = len(unit.strings(UNIT_LOADS.AREA_NAME))
    element = np.repeat(np.arange(len(own)), np.diff(offset))
    if not len(own):
        return own
    votes = np.zeros((len(own), areas + 1), dtype=np.int32)
    np.add.at(votes, (element, of_grid[index]), 1)
    votes[:, -1] = 0  # grids without an area do not vote
    return np.asarray(np.where(own >= 0, own, np.where(votes.any(axis=1), votes.argmax(axis=1), -1)))


def _few(names: Sequence[object]) -> str:
    shown = ", ".join(map(str, names[:8]))
    return shown + (f" and {len(names) - 8} more" if len(names) > 8 else "")
