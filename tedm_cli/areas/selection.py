"""What meets the selections of a definition of a thermal area: grids, and elements."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.config.model.areas import BoxTable, DefinitionTable, Ids, SelectionTable, id_ranges
from tedm_cli.nastran.geometry import id_list
from tedm_cli.nastran.membership import Membership

_ROUNDING_M = 1e-9  # coordinates written with nine digits, and turned: faces of boxes are closed to within this
_ROUNDING_DEG = 1e-7


@dataclass(frozen=True, eq=False)
class Met:
    """What meets a selection: grids [N]; elements [E], and whether it is by these that the grids were selected."""

    grids: BoolArray
    elements: BoolArray
    by_elements: bool


@dataclass(frozen=True)
class Selector:
    """What the selections of one definition meet; problems go to the lists, with the place in the configuration."""

    members: Membership
    at: str
    problems: list[tuple[str, str]]
    notes: list[str]

    def definition(self, d: DefinitionTable) -> Met:
        """What any of the selections of a definition meets that is not the remainder."""
        found = [
            self.selection(selection, self.at if number == 0 else f"{self.at}.also[{number - 1}]", d.name)
            for number, selection in enumerate(d.selections())
        ]
        return Met(
            np.any([f.grids for f in found], axis=0),
            np.any([f.elements for f in found], axis=0),
            all(f.by_elements for f in found),
        )

    def selection(self, s: SelectionTable, at: str, name: str) -> Met:
        """What meets all criteria; an element is in a box with its centre, in a set of grids with all of its grids."""
        m = self.members
        met, elements = m.structural.copy(), np.ones(len(m.element_id), dtype=bool)
        by_elements = not (s.property is None and s.material is None and s.element is None)
        if s.set is not None:
            members, chosen = self.sets(s.set, f"{at}.set", name)
            met &= members
            elements &= chosen | m.mesh.within(members)
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
            met &= m.mesh.grids_of(chosen)
        elements &= chosen
        boxes = s.boxes()
        if boxes:
            place = f"{at}.box" if not isinstance(s.box, list) else f"{at}.box[{{}}]"
            inside = self.inside(boxes, place, np.concatenate([m.position_m, m.centres()]))
            met &= inside[: len(met)]
            elements &= inside[len(met) :]
        return Met(met, elements, by_elements)

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

    def inside(self, boxes: Sequence[BoxTable], place: str, position_m: FloatArray) -> BoolArray:
        """Which of these places [n, 3] lie in any of the boxes, [n]; `place` is theirs, with {} for their numbers."""
        found = [self._box(box, place.format(i), position_m) for i, box in enumerate(boxes)]
        return np.asarray(np.any(found, axis=0))

    def sets(self, wanted: Ids, at: str, name: str) -> tuple[BoolArray, BoolArray]:
        """Grids that are in any of these sets, and the elements that stand in them as such."""
        m = self.members
        met, elements = np.zeros(len(m.grid_id), dtype=bool), np.zeros(len(m.element_id), dtype=bool)
        for low, high in id_ranges(wanted):
            numbers = [sid for sid in sorted(m.sets) if low <= sid <= high]
            if not numbers:
                text = f"{low}" if low == high else f"{low}:{high}"
                self.problems.append((at, f"the deck has no set {text}{_there(np.array(sorted(m.sets)), low, 'set')}"))
            for sid in numbers:
                found = m.of_set(sid)
                if found.conflict:
                    self.problems.append((at, found.conflict))
                if found.unknown.size:
                    self.notes.append(
                        f"area {name}: set {sid} names {len(found.unknown)} {found.kind} ids that the deck does not"
                        f" have: {id_list(found.unknown)}"
                    )
                met |= found.grids
                elements |= found.elements
        return met, elements

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
