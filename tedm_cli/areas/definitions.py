"""Thermal areas from their definitions: to which area each grid and each element belongs, and which grids are left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from tedm_cli.areas.gradients import gradient_load, refuse_parallel
from tedm_cli.areas.selection import Met, Selector
from tedm_cli.arrays import BoolArray, IntArray
from tedm_cli.config.model.areas import AreasTable, DefinitionTable
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.nastran.geometry import id_list, rows_of
from tedm_cli.nastran.loads.area_loads import AreaLoad
from tedm_cli.nastran.membership import Membership

_OWN = "whose temperature is their own, in areas of elements"
_WHOLE = " (an element is in a set of grids with all of its grids, in a box with its centre)"


@dataclass(frozen=True)
class Overlap:
    """Grids that an area's definition meets and an earlier area has: they stay with the earlier one."""

    area: str
    earlier: str
    grids: IntArray


@dataclass(frozen=True)
class DefinedAreas:
    """What each thermal area's load is on, and what had to be decided or said.

    loads : by name; no grid and no element is in two areas of a mean temperature.
    selected : ascending ids of the elements that a definition selects, where it does so by elements and not by grids,
        and no definition before it does.
    left : ids of grids whose temperature is felt and that are in no area; left_properties : of their elements.
    """

    loads: dict[str, AreaLoad]
    selected: dict[str, IntArray]
    overlaps: list[Overlap]
    left: IntArray
    left_properties: list[int]
    notes: list[str]

    def lines(self) -> list[str]:
        """Overlaps and notes, as text."""
        lost: dict[str, list[Overlap]] = {}
        for o in self.overlaps:
            lost.setdefault(o.area, []).append(o)
        return [
            f"area {name}: {sum(len(o.grids) for o in overlaps):,} shared grids stay with earlier definitions ("
            + ", ".join(f"{o.earlier} {len(o.grids):,}" for o in overlaps)
            + ")"
            for name, overlaps in lost.items()
        ] + self.notes


def define_areas(members: Membership, table: AreasTable, listed: Mapping[str, IntArray], *, where: str) -> DefinedAreas:
    """Areas of a CSV (`listed`), then those of the definitions, each of the grids that are not taken yet.

    Areas of elements have their shells, bars and rods first, wherever they stand among the definitions. Of grids,
    definitions take those whose temperature is felt, by elements without a temperature of their own.

    Raises
    ------
    InputError : the CSV names grids that do not exist.
    ConfigError : ids or coordinate systems that do not exist, a definition that gets nothing, an element in two areas
        of elements or under two gradients of one direction, a gradient where there can be none, with `strict` a
        definition that meets grids of another; all such problems at once.
    """
    work = _Work(members, table.strict)
    for name, ids in listed.items():
        work.owner[rows_of(members.grid_id, ids, where=where, what=f"area '{name}'")] = len(work.names)
        work.names.append(name)
    wanted = []
    for number, definition in enumerate(table.define):
        at = f"areas.define[{number}]"
        if definition.name.upper() in (name.upper() for name in listed):
            work.problems.append((f"{at}.name", f"area '{definition.name}' is in the CSV of areas already"))
        else:
            wanted.append(_Wanted(at, definition, len(work.names), work.select(at, definition)))
            work.names.append(definition.name)
    for area in wanted:
        if area.met is not None and area.definition.carrier == "elements" and area.definition.kind == "mean":
            work.own(area, area.met.elements)
    gradients = [w for w in wanted if w.met is not None and w.definition.kind == "gradient"]
    for area in wanted:
        if area.definition.kind == "mean" and (area.met is not None or area.definition.remainder):
            work.take(area)
    loads = {
        w.name: gradient_load(members, w.at, w.definition, w.elements, work.problems, work.notes) for w in gradients
    }
    refuse_parallel(loads, {w.name: w.at for w in gradients}, work.problems)
    felt = work.felt()
    for area in wanted if not work.problems else ():
        mine, cards = work.owner == area.number, work.element_owner == area.number
        if mine.any() and not ((mine & felt).any() or cards.any()):  # a remainder of elements came after it
            work.problems.append((area.at, f"all grids of area '{area.name}' are of elements {_OWN}"))
    if work.problems:
        raise ConfigError(work.problems, where=where, hint=work.hint)
    for mask, fact in (
        (members.structural, "areas without any structural grid"),
        (felt, f"areas whose grids are all of elements {_OWN}"),
    ):
        idle = [name for i, name in enumerate(work.names[: len(listed)]) if not (mask & (work.owner == i)).any()]
        if idle:  # definitions have been looked at
            raise InputError(f"{fact}: {', '.join(idle)}", where=where)
    return work.result(loads, work.selected(len(listed), [w for w in wanted if w.definition.kind == "mean"]))


@dataclass(frozen=True, eq=False)
class _Wanted:
    """A definition, its place in the configuration, its number among all areas, and what it meets (None: remainder)."""

    at: str
    definition: DefinitionTable
    number: int
    met: Met | None

    @property
    def name(self) -> str:
        return self.definition.name

    @property
    def elements(self) -> BoolArray:
        assert self.met is not None
        return self.met.elements


@dataclass(eq=False)
class _Work:
    """The areas as they are filled: which area has each grid [N] and each element with a card [E], -1: none."""

    members: Membership
    strict: bool
    names: list[str] = field(default_factory=list)
    problems: list[tuple[str, str]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    overlaps: list[Overlap] = field(default_factory=list)
    hint: str = ""

    def __post_init__(self) -> None:
        self.owner = np.full(len(self.members.grid_id), -1)
        self.element_owner = np.full(len(self.members.element_id), -1)
        self.card, self.solid = self.members.mesh.with_card, self.members.mesh.solid

    def felt(self) -> BoolArray:
        return self.members.mesh.followed(self.element_owner >= 0)

    def select(self, at: str, definition: DefinitionTable) -> Met | None:
        """What a definition meets; None of the remainder, and where there are problems."""
        if definition.remainder:
            return None
        before = len(self.problems)
        met = Selector(self.members, at, self.problems, self.notes).definition(definition)
        return met if len(self.problems) == before else None

    def own(self, area: _Wanted, elements: BoolArray) -> None:
        """Give an area those of its elements that can have a temperature of their own, and say which have none."""
        m, mine = self.members, elements & self.card
        bare = elements & ~self.card & ~self.solid
        if not elements.any():
            self.problems.append((area.at, f"area '{area.name}' has no element" + _nothing(area.definition, _WHOLE)))
        elif bare.any():
            shown = _cards(m, bare)
            if not (mine | elements & self.solid).any():
                fact = f"area '{area.name}' has only elements that have no temperature: {shown}"
                self.problems.append((area.at, fact))
            else:
                self.notes.append(f"area {area.name}: elements that have no temperature are left out: {shown}")
        for other in np.unique(self.element_owner[mine & (self.element_owner >= 0)]):
            both = mine & (self.element_owner == other)
            one = both.sum() == 1
            fact = f"{self.names[other]} and {area.name} both select element{'' if one else 's'} {_ids(m, both)}"
            mend = f"an element has one temperature: take {'it' if one else 'them'} out of one of the two areas"
            self.problems.append((area.at, f"{fact}; {mend}"))
        self.element_owner[mine & (self.element_owner < 0)] = area.number

    def take(self, area: _Wanted) -> None:
        """Give an area the grids that it meets and no earlier one has."""
        m, d, free = self.members, area.definition, self.owner < 0
        if area.met is None and d.carrier == "elements":
            self._own_remainder(area, free)
            met = free & self.felt() & m.mesh.grids_of(self.solid)
        elif area.met is None:
            met = free & self.felt()
        elif d.carrier == "elements":
            solids = area.met.elements & self.solid
            met = m.mesh.grids_of(solids) & self.felt()
            if solids.any():
                self.notes.append(
                    f"area {d.name}: {solids.sum():,} solids have no temperature of their own: they are warmed through"
                    f" their {met.sum():,} grids, as in an area of grids"
                )
        else:
            met = area.met.grids & self.felt()
        earlier = met & ~free
        shared = [
            Overlap(d.name, self.names[i], m.grid_id[earlier & (self.owner == i)])
            for i in np.unique(self.owner[earlier])
        ]
        self.overlaps += shared
        self.owner[met & free] = area.number
        cards = bool((self.element_owner == area.number).any())
        if self.strict and shared:
            listing = "; ".join(f"{o.earlier} {len(o.grids)}: {id_list(o.grids)}" for o in shared)
            self.problems.append((area.at, f"area '{d.name}' shares grids with earlier ones ({listing})"))
        elif not (met & free).any() and not cards:
            self._nothing_taken(area, met, shared)

    def _own_remainder(self, area: _Wanted, free: BoolArray) -> None:
        """The shells, bars and rods of no area of elements that have a grid of no area of grids either."""
        left = self.card & (self.element_owner < 0) & self.members.mesh.touching(free & self.members.structural)
        self.element_owner[left] = area.number

    def _nothing_taken(self, area: _Wanted, met: BoolArray, shared: Sequence[Overlap]) -> None:
        d = area.definition
        if met.any():
            listing = ", ".join(f"{o.earlier} has {len(o.grids)}" for o in shared)
            fact = f"all grids of area '{d.name}' are in earlier areas ({listing})"
        elif d.carrier == "elements" and area.met is not None:
            return  # said where the elements were looked at
        elif area.met is not None and area.met.grids.any():
            on = self.members.mesh.touching(area.met.grids) & (self.element_owner >= 0)
            names = ", ".join(self.names[i] for i in np.unique(self.element_owner[on]))
            fact = f"all grids of area '{d.name}' are of elements {_OWN}: {names}"
        else:
            fact = f"area '{d.name}' has no grid" + _nothing(d, " with element stiffness")
            if d.remainder:
                self.hint = f"remove {area.at} ({d.name}): all grids are in areas_csv or in other areas"
        self.problems.append((area.at, fact))

    def selected(self, listed: int, wanted: Sequence[_Wanted]) -> dict[str, BoolArray]:
        """Elements [E] that definitions select as such: the first of these that does, as with grids.

        What lies within a list, a box or a set of grids that came before is not of those after it either.
        """
        if not any(area.met is not None and area.met.by_elements for area in wanted):
            return {}
        within = self.members.mesh.owner(self.owner)
        taken = (within >= 0) & (within < listed)
        out = {}
        for area in wanted:
            if area.met is not None and area.met.by_elements:
                out[area.name] = area.met.elements & ~taken
                taken = taken | area.met.elements
            else:
                taken = taken | (within == area.number)
        return out

    def result(self, gradients: Mapping[str, AreaLoad], selected: Mapping[str, BoolArray]) -> DefinedAreas:
        m, own = self.members, self.element_owner
        loads = {}
        for i, name in enumerate(self.names):
            mine = self.owner == i
            held = (own >= 0) & (own != i) & m.mesh.touching(mine) if (own >= 0).any() else own >= 0
            load = AreaLoad(m.grid_id[mine], m.element_id[own == i], m.element_id[held])
            loads[name] = gradients.get(name, load)
        left = (self.owner < 0) & self.felt()
        on_left = m.mesh.touching(left) & (own < 0)
        return DefinedAreas(
            loads,
            {name: m.element_id[elements] for name, elements in selected.items()},
            self.overlaps,
            m.grid_id[left],
            [int(p) for p in np.unique(m.property_id[on_left])],
            self.notes,
        )


def require_partition(areas: DefinedAreas, *, where: str) -> None:
    """`InputError` where grids whose temperature is felt are in no area."""
    if areas.left.size:
        raise InputError(
            f"{len(areas.left)} structural grids are in no thermal area: {id_list(areas.left)}"
            f" (of elements with the properties {id_list(areas.left_properties)})",
            where=where,
            hint="define areas for them, or one with remainder = true at the end; `tedm areas --figure` shows them",
        )


def _ids(m: Membership, elements: BoolArray) -> str:
    return id_list(m.element_id[elements])


def _cards(m: Membership, elements: BoolArray) -> str:
    """`CBUSH 5, 6; CELAS2 7`."""
    names = np.unique(m.card[elements])
    return "; ".join(f"{name} {_ids(m, elements & (m.card == name))}" for name in names)


def _nothing(definition: DefinitionTable, alone: str) -> str:
    if definition.remainder:
        return ": nothing is left"
    several = sum(v is not None for v in (definition.set, definition.property, definition.material, definition.element))
    return " that meets all its criteria" if several + (definition.box is not None) > 1 else alone
