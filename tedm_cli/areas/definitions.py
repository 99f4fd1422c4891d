"""Thermal areas from their definitions: which area each grid belongs to, and which grids are left."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.config.areas import AreasTable, BoxTable, DefinitionTable, Ids, SelectionTable, id_ranges
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.nastran.geometry import id_list, rows_of
from tedm_cli.nastran.membership import Membership

_ROUNDING_M = 1e-9  # coordinates written with nine digits, and turned: faces of boxes are closed to within this
_ROUNDING_DEG = 1e-7


@dataclass(frozen=True)
class Overlap:
    """Grids that an area's definition meets and an earlier area has: they stay with the earlier one."""

    area: str
    earlier: str
    grids: IntArray


@dataclass(frozen=True)
class AreaGrids:
    """Grids of each thermal area, and what had to be decided or said.

    areas : ascending grid ids by name; no grid is in two areas.
    selected : ascending ids of the elements that a definition selects, where it does so by elements and not by grids.
    left : ids of grids with stiffness that are in no area; left_properties : of their elements.
    """

    areas: dict[str, IntArray]
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


def define_areas(members: Membership, table: AreasTable, listed: Mapping[str, IntArray], *, where: str) -> AreaGrids:
    """Areas of a CSV (`listed`), then those of the definitions, each of the grids that are not taken yet.

    Definitions take grids with element stiffness only: temperature has no effect on others.

    Raises
    ------
    InputError : the CSV names grids that do not exist.
    ConfigError : ids or coordinate systems that do not exist, a definition that gets no grid, with `strict` one that
        meets grids of another; all such problems at once.
    """
    owner = np.full(len(members.grid_id), -1)
    names: list[str] = []
    problems: list[tuple[str, str]] = []
    overlaps: list[Overlap] = []
    notes: list[str] = []
    selected: dict[str, IntArray] = {}
    for name, ids in listed.items():
        owner[rows_of(members.grid_id, ids, where=where, what=f"area '{name}'")] = len(names)
        names.append(name)
    for number, definition in enumerate(table.define):
        at = f"areas.define[{number}]"
        if definition.name.upper() in (name.upper() for name in listed):
            problems.append((f"{at}.name", f"area '{definition.name}' is in the CSV of areas already"))
            continue
        before = len(problems)
        found = _Selector(members, at, problems, notes).definition(definition, owner < 0)
        met = found.grids
        if found.by_elements:
            selected[definition.name] = members.element_id[found.elements]
        earlier = met & (owner >= 0)
        shared = [
            Overlap(definition.name, names[i], members.grid_id[earlier & (owner == i)])
            for i in np.unique(owner[earlier])
        ]
        overlaps += shared
        names.append(definition.name)
        owner[met & (owner < 0)] = len(names) - 1
        if len(problems) > before:
            continue
        if table.strict and shared:
            listing = "; ".join(f"{o.earlier} {len(o.grids)}: {id_list(o.grids)}" for o in shared)
            problems.append((at, f"area '{definition.name}' shares grids with earlier ones ({listing})"))
        elif not met.any():
            problems.append((at, f"area '{definition.name}' has no grid" + _nothing(definition)))
        elif not (met & ~earlier).any():
            listing = ", ".join(f"{o.earlier} has {len(o.grids)}" for o in shared)
            problems.append((at, f"all grids of area '{definition.name}' are in earlier areas ({listing})"))
    if problems:
        raise ConfigError(problems, where=where)
    idle = [name for i, name in enumerate(names) if not (members.structural & (owner == i)).any()]
    if idle:  # of the CSV: definitions take structural grids only
        raise InputError(f"areas without any structural grid: {', '.join(idle)}", where=where)
    left = (owner < 0) & members.structural
    element = np.repeat(np.arange(len(members.element_id)), np.diff(members.node_offset))
    return AreaGrids(
        {name: members.grid_id[owner == i] for i, name in enumerate(names)},
        selected,
        overlaps,
        members.grid_id[left],
        [int(p) for p in np.unique(members.property_id[element[left[members.node_index]]])],
        notes,
    )


def require_partition(areas: AreaGrids, *, where: str) -> None:
    """`InputError` where grids with stiffness are in no area."""
    if areas.left.size:
        raise InputError(
            f"{len(areas.left)} structural grids are in no thermal area: {id_list(areas.left)}"
            f" (of elements with the properties {id_list(areas.left_properties)})",
            where=where,
            hint="define areas for them, or one with remainder = true at the end; `tedm areas --figure` shows them",
        )


def _nothing(definition: DefinitionTable) -> str:
    if definition.remainder:
        return ": nothing is left"
    several = sum(v is not None for v in (definition.set, definition.property, definition.material, definition.element))
    return " that meets all its criteria" if several + (definition.box is not None) > 1 else " with element stiffness"


@dataclass(frozen=True, eq=False)
class _Met:
    """What meets a selection: grids [N]; elements [E], and whether it is by these that the grids were selected."""

    grids: BoolArray
    elements: BoolArray
    by_elements: bool


@dataclass(frozen=True)
class _Selector:
    """What the selections of one definition meet; problems go to the lists, with the place in the configuration."""

    members: Membership
    at: str
    problems: list[tuple[str, str]]
    notes: list[str]

    def definition(self, d: DefinitionTable, free: BoolArray) -> _Met:
        m = self.members
        if d.remainder:
            return _Met(free & m.structural, np.zeros(len(m.element_id), dtype=bool), False)
        found = [
            self.selection(selection, self.at if number == 0 else f"{self.at}.also[{number - 1}]", d.name)
            for number, selection in enumerate(d.selections())
        ]
        return _Met(
            np.any([f.grids for f in found], axis=0),
            np.any([f.elements for f in found], axis=0),
            all(f.by_elements for f in found),
        )

    def selection(self, s: SelectionTable, at: str, name: str) -> _Met:
        """What meets all criteria; an element is in a box with its centre, in a set of grids with all of its grids."""
        m = self.members
        met, elements = m.structural.copy(), np.ones(len(m.element_id), dtype=bool)
        by_elements = not (s.property is None and s.material is None and s.element is None)
        if s.set is not None:
            members, chosen = self._sets(s.set, f"{at}.set", name)
            met &= members
            elements &= chosen | m.within(members)
            by_elements |= bool(chosen.any())
        chosen = np.ones(len(m.element_id), dtype=bool)
        if s.property is not None:
            chosen &= np.isin(m.property_id, self._known(s.property, m.property_id, f"{at}.property", "property"))
        if s.material is not None:
            ids = np.concatenate([m.property_materials[:, 1], m.element_material])
            chosen &= m.of_material(self._known(s.material, ids, f"{at}.material", "material"))
        if s.element is not None:
            chosen &= np.isin(m.element_id, self._known(s.element, m.element_id, f"{at}.element", "element"))
        if not chosen.all():
            met &= m.grids_of(chosen)
        elements &= chosen
        boxes = s.boxes()
        if boxes:
            place = f"{at}.box" if not isinstance(s.box, list) else f"{at}.box[{{}}]"
            places = np.concatenate([m.position_m, m.centres()])
            inside = np.any([self._box(box, place.format(i), places) for i, box in enumerate(boxes)], axis=0)
            met &= inside[: len(met)]
            elements &= inside[len(met) :]
        return _Met(met, elements, by_elements)

    def _known(self, wanted: Ids, there: IntArray, at: str, what: str) -> IntArray:
        """Ids that are there, of those wanted; a range may have gaps but must hold one."""
        known = np.unique(there[there > 0])
        chosen = []
        for low, high in id_ranges(wanted):
            ids = known[(known >= low) & (known <= high)]
            if not ids.size:
                text = f"{low}" if low == high else f"{low}:{high}"
                self.problems.append((at, f"no element has the {what} {text}{_there(known, low, what)}"))
            chosen.append(ids)
        return np.concatenate(chosen)

    def _sets(self, wanted: Ids, at: str, name: str) -> tuple[BoolArray, BoolArray]:
        """Grids that are in any of these sets, and the elements that stand in them as such."""
        m = self.members
        met, elements = np.zeros(len(m.grid_id), dtype=bool), np.zeros(len(m.element_id), dtype=bool)
        for low, high in id_ranges(wanted):
            numbers = [sid for sid in sorted(m.sets) if low <= sid <= high]
            if not numbers:
                text = f"{low}" if low == high else f"{low}:{high}"
                self.problems.append((at, f"the deck has no set {text}{_there(np.array(sorted(m.sets)), low, 'set')}"))
            for sid in numbers:
                place, kind, ids = m.sets[sid][0]
                other = next((p for p, k, i in m.sets[sid] if (k, i.tolist()) != (kind, ids.tolist())), None)
                if other is not None:
                    self.problems.append((at, f"set {sid} is a {place} and a {other} with other members"))
                table = {"grid": m.grid_id, "element": m.element_id, "property": np.unique(m.property_id)}[kind]
                unknown = ids[~np.isin(ids, table)]
                if unknown.size:
                    # THRU may run over gaps in the numbering, so that this is no mistake in itself.
                    self.notes.append(
                        f"area {name}: set {sid} names {len(unknown)} {kind} ids that the deck does not have:"
                        f" {id_list(unknown)}"
                    )
                if kind == "grid":
                    met |= np.isin(m.grid_id, ids)
                else:
                    elements |= np.isin(m.element_id if kind == "element" else m.property_id, ids)
        return met | m.grids_of(elements), elements

    def _box(self, box: BoxTable, at: str, position_m: FloatArray) -> BoolArray:
        """Which of these places [n,3] lie in it, [n]."""
        m = self.members
        inside = np.ones(len(position_m), dtype=bool)
        if box.frame not in m.frames:
            there = id_list(sorted(m.frames))
            self.problems.append((f"{at}.frame", f"the deck has no coordinate system {box.frame}; there are: {there}"))
            return inside
        coordinates = m.coordinates(box.frame, position_m)
        for key, (low, high) in box.ranges().items():
            if key not in coordinates:
                keys = ", ".join(coordinates)
                self.problems.append((f"{at}.{key}", f"coordinate system {box.frame} has {keys}"))
                continue
            value = coordinates[key]
            if key.endswith("_deg"):
                inside &= np.mod(value - low + _ROUNDING_DEG, 360.0) <= high - low + 2.0 * _ROUNDING_DEG
            else:
                inside &= (value >= low - _ROUNDING_M) & (value <= high + _ROUNDING_M)
        return inside


def _there(known: Sequence[int] | IntArray, wanted: int, what: str) -> str:
    """What there is instead: all of it where that is short, else the nearest."""
    if not len(known):
        return f"; it has no {what}" if what == "set" else ""
    if len(known) <= 12:
        return f"; there are: {', '.join(str(i) for i in known)}"
    near = difflib.get_close_matches(str(wanted), [str(i) for i in known], n=1, cutoff=0.5)
    return f"; did you mean {near[0]}?" if near else ""
