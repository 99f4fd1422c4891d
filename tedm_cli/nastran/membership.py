"""What the grids of a deck belong to: sets, elements with their properties and materials, coordinate systems."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.frames import local_coordinates
from tedm_cli.nastran.geometry import Grids, rows_of
from tedm_cli.nastran.loads.area_loads import Mesh
from tedm_cli.nastran.loads.element_axes import gradient_axes
from tedm_cli.nastran.positions import Frames, frames_of, grid_positions
from tedm_cli.nastran.units import frames_in_si, units_of

_KINDS = {"GRID": "grid", "ELEM": "element", "ELEMENT": "element", "PROP": "property", "PROPERTY": "property"}


@dataclass(frozen=True, eq=False)
class Membership:
    """Grids of a deck by what they belong to.

    grid_id [N] ascending; structural [N]: corners of elements. element_id [E] ascending, property_id [E] (0: none);
    node_offset [E+1] and node_index: rows of the grid table. property_materials: (property, material) pairs [P,2];
    element_material [E]: of elements without property (0: none). card [E]: their names. sets: by id, (where it stands,
    what its ids are, ids).
    position_m [N,3] (basic frame), frames (type, origin [3] in m, axes [3,3] as rows), axes [E,2,3] as in
    `gradient_axes`: empty unless asked for.
    """

    grid_id: IntArray
    structural: BoolArray
    element_id: IntArray
    property_id: IntArray
    node_offset: IntArray
    node_index: IntArray
    property_materials: IntArray
    element_material: IntArray
    card: NDArray[np.str_]
    sets: dict[int, list[tuple[str, str, IntArray]]]
    position_m: FloatArray
    frames: Frames
    axes: FloatArray

    @cached_property
    def mesh(self) -> Mesh:
        """Its elements, and which of them follow their grids."""
        return Mesh(self.structural, self.card, self.node_offset, self.node_index)

    def of_material(self, material: IntArray) -> BoolArray:
        """Elements [E] that have one of these materials in any layer."""
        pairs = self.property_materials
        with_it = pairs[np.isin(pairs[:, 1], material), 0]
        return np.isin(self.property_id, with_it) | np.isin(self.element_material, material)

    def centres(self) -> FloatArray:
        """Mean position [E,3] (m, basic frame) of the grids of each element."""
        counts = np.diff(self.node_offset)
        element = np.repeat(np.arange(len(counts)), counts)
        sums = [np.bincount(element, self.position_m[self.node_index, i], len(counts)) for i in range(3)]
        return np.asarray(np.stack(sums, axis=1) / np.maximum(counts, 1)[:, None])

    def of_set(self, sid: int) -> SetMembers:
        """The members of a set of the deck, by the first of its cards."""
        place, kind, ids = self.sets[sid][0]
        other = next((p for p, k, i in self.sets[sid] if (k, i.tolist()) != (kind, ids.tolist())), None)
        table = {"grid": self.grid_id, "element": self.element_id, "property": np.unique(self.property_id)}[kind]
        if kind == "grid":
            elements = np.zeros(len(self.element_id), dtype=bool)
            grids = np.isin(self.grid_id, ids)
        else:
            elements = np.isin(self.element_id if kind == "element" else self.property_id, ids)
            grids = self.mesh.grids_of(elements)
        conflict = "" if other is None else f"set {sid} is a {place} and a {other} with other members"
        return SetMembers(kind, grids, elements, ids[~np.isin(ids, table)], conflict)

    def coordinates(self, frame: int, position_m: FloatArray) -> dict[str, FloatArray]:
        """Coordinates [n] of places [n,3] (m, basic frame) in a coordinate system, by name."""
        kind, origin, axes = self.frames[frame]
        return local_coordinates(kind, (position_m - origin) @ axes.T)


@dataclass(frozen=True, eq=False)
class SetMembers:
    """A set: what its ids are of, its grids [N], the elements [E] that stand in it as such, ids that the deck does not
    have, and a card that differs.

    A range of ids (THRU) may run over gaps in the numbering, so that unknown ids are no mistake in themselves.
    """

    kind: str
    grids: BoolArray
    elements: BoolArray
    unknown: IntArray
    conflict: str


def membership(model: Any, grids: Grids, *, positions: bool, axes: bool = False) -> Membership:
    """Membership of a model's grids; with `positions` or `axes` the model must be cross-referenced."""
    columns = columns_of(model)
    elements = columns.element
    offset, flat = elements.without(())
    own = [e for e in columns.element_cards.values() if hasattr(e, "mid") and int(getattr(e, "pid", None) or 0) <= 0]
    material = np.zeros(len(elements.id), dtype=np.int64)
    material[np.searchsorted(elements.id, [int(e.eid) for e in own])] = [int(e.Mid()) for e in own]
    pairs = [(int(pid), int(mid)) for pid, prop in sorted(model.properties.items()) for mid in _materials(prop)]
    sets: dict[int, list[tuple[str, str, IntArray]]] = {}
    for sid, entry in _sets(model):
        sets.setdefault(sid, []).append(entry)
    units, where = units_of(model), str(grids.files[0])
    frames = frames_of(model) if positions or axes else {}
    place = grid_positions(model, grids.grid_id, frames) if positions or axes else np.zeros((0, 3))
    return Membership(
        grid_id=grids.grid_id,
        structural=grids.structural,
        element_id=elements.id,
        property_id=np.maximum(elements.property_id, 0),  # pyNastran gives CONROD a negative one
        node_offset=offset,
        node_index=rows_of(grids.grid_id, flat, where=where, what="an element"),
        property_materials=np.array(pairs, dtype=np.int64).reshape(-1, 2),
        element_material=material,
        card=elements.card,
        sets=sets,
        position_m=units.length_m * place,
        frames=frames_in_si(frames, units),
        axes=gradient_axes(model, grids.grid_id, place, frames, where) if axes else np.zeros((0, 2, 3)),
    )


def _materials(prop: Any) -> list[int]:
    """Materials of a property: of all layers of a laminate; of membrane, bending and shear of a plate; else the one."""
    found = getattr(prop, "material_ids", None) or [getattr(prop, "mid", None), *(getattr(prop, "mids", None) or [])]
    return [int(mid) for mid in found if mid]


def _sets(model: Any) -> Iterator[tuple[int, tuple[str, str, IntArray]]]:
    """SET1 and SET3 of the bulk data, and the sets of the case control; sets of neither grids nor elements are left."""
    for sid, card in model.sets.items():
        kind = _KINDS.get(str(card.desc).upper()) if card.type == "SET3" else "grid" if card.type == "SET1" else None
        if kind is not None:
            yield int(sid), (card.type, kind, np.unique(np.array(card.get_ids(), dtype=np.int64)))
    control = model.case_control_deck
    for number, subcase in sorted(control.subcases.items()) if control is not None else ():
        place = f"SET of subcase {number}" if number else "SET of the case control"
        for key in subcase.params:
            if key.startswith("SET "):
                ids, sid = subcase.get_parameter(key)
                if all(isinstance(i, int) for i in ids):
                    yield int(sid), (place, "grid", np.unique(np.array(ids, dtype=np.int64)))
                elif ids == ["ALL"]:
                    yield int(sid), (place, "grid", columns_of(model).grid.id)
