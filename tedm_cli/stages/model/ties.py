"""Ties of compensation masses on a deck that has been read: the grids that each block follows, and whether they can."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.errors import ConfigError
from tedm_cli.gravity.compensation import CompensationMass, Tie
from tedm_cli.gravity.ties import needs_rotations, own_rotation
from tedm_cli.nastran.geometry import ModelGeometry, id_list
from tedm_cli.nastran.membership import Membership, membership
from tedm_cli.results.gravity.ties import Ties
from tedm_cli.stages.model.masses import element_of_member, parts_of_test_mass

_NOTHING = ("PLOTEL", "CHBDYG", "CHBDYE", "CHBDYP")  # these hold nothing
_NO_TURN = ("CTETRA", "CPYRAM", "CPENTA", "CHEXA", "CROD", "CONROD", "CTUBE")  # these have no use for rotations
# K6ROT or a constraint alone holds the rotation about the normal of these; CQUADR and CTRIAR have a stiffness of it.
_NO_DRILLING = ("CQUAD4", "CQUAD8", "CTRIA3", "CTRIA6", "CSHEAR")
_SMOOTH = np.sin(np.radians(10.0))  # shells this near to a plane do not hold each other's normals
_MORE = "tie the block to three grids or more that are not in a line, as in grid = [4711, 4713, 4725], or to a set"
_NAMED = 8
_OTHERS = "tie the block to grids of the structure, by the numbers that they have in the unit-load deck"


def ties_on(
    blocks: Sequence[CompensationMass], config: ModelConfig, model: Any, whole: ModelGeometry
) -> tuple[Ties, list[str]]:
    """The grids that tied blocks follow, and remarks.

    Parameters
    ----------
    whole : geometry with what stands for the test masses in the model.

    Raises
    ------
    ConfigError : grids or sets that the deck does not have; grids that nothing holds, that are of a test mass, or
        whose rotations are needed and mean nothing. All problems of one file at once.
    """
    tied = [(block, block.tie) for block in blocks if block.tie is not None]
    if not tied:
        return Ties.of([], [], []), []
    members = membership(model, whole, positions=False) if any(tie.kind == "set" for _, tie in tied) else None
    judge = _Judge(config, model, whole)
    rows, notes, soft = [], list[str](), list[str]()
    problems: dict[str, list[tuple[str, str]]] = {}
    for block, tie in tied:
        facts: list[str] = []
        if members is None or tie.kind == "grid":
            chosen = _grids(tie, whole, facts)
        else:
            chosen = _members(tie, members, facts, notes, block.name)
        if not facts:
            facts += judge.facts(chosen)
        if not facts and (loose := judge.soft(chosen)).size:
            soft.append(f"{block.name} (grid{'s' * (loose.size > 1)} {id_list(whole.grid_id[loose])})")
        rows.append(chosen)
        problems.setdefault(tie.file, []).extend((tie.key, f"block {block.name!r}: {fact}") for fact in facts)
    for where, found in problems.items():
        if found:
            hint = _MORE if any("rotations" in fact for _, fact in found) else _OTHERS
            raise ConfigError(found, where=where, hint=hint)
    if soft:
        listed = ", ".join(soft[:_NAMED]) + (f" and {len(soft) - _NAMED} more" if len(soft) > _NAMED else "")
        notes.append(
            "compensation masses that turn about the normal of shells as grids do which shells alone hold:"
            f" {listed}. Shells have next to no stiffness about their normal: K6ROT or a constraint decides that"
            f" rotation, and with it [S_SG]. Better {_MORE}"
        )
    return Ties.of([block.name for block, _ in tied], [tie.words for _, tie in tied], rows), notes


def _grids(tie: Tie, geometry: ModelGeometry, facts: list[str]) -> IntArray:
    ids, chosen = geometry.grid_id, []
    for low, high in tie.ids:
        first, last = np.searchsorted(ids, (low, high + 1))
        if first == last:
            facts.append(f"the deck has no grid {low}" if low == high else f"the deck has no grid of {low}:{high}")
        chosen.append(np.arange(first, last))
    return np.asarray(np.unique(np.concatenate(chosen)))


def _members(tie: Tie, members: Membership, facts: list[str], notes: list[str], name: str) -> IntArray:
    chosen = np.zeros(len(members.grid_id), dtype=bool)
    for low, high in tie.ids:
        numbers = [sid for sid in sorted(members.sets) if low <= sid <= high]
        if not numbers:
            there = f"there are: {id_list(sorted(members.sets))}" if members.sets else "it has no set"
            facts.append(f"the deck has no set {low if low == high else f'{low}:{high}'}; {there}")
        for sid in numbers:
            found = members.of_set(sid)
            facts += [found.conflict] if found.conflict else []
            if found.unknown.size:
                what = f"ids of a {found.kind} that the deck does not have: {id_list(found.unknown)}"
                notes.append(f"block {name!r}: set {sid} names {what}")
            chosen |= found.grids
    if not facts and not chosen.any():
        facts.append(f"{tie.words} of the deck has no grid")
    return np.flatnonzero(chosen)


class _Judge:
    """Whether grids can carry a block."""

    def __init__(self, config: ModelConfig, model: Any, geometry: ModelGeometry) -> None:
        e = geometry.elements
        index, card = element_of_member(e), np.array(e.type)
        self.geometry = geometry
        self.held = geometry.in_rigid_element | self._grids_of(~np.isin(card, _NOTHING))
        by_rigid_elements = np.isin(geometry.grid_id, list(_turned_by_rigid_elements(model)))
        self.turns = by_rigid_elements | self._grids_of(~np.isin(card, (*_NOTHING, *_NO_TURN)))
        drilling = self._grids_of(~np.isin(card, (*_NOTHING, *_NO_TURN, *_NO_DRILLING)))
        self.shells_alone = self.turns & ~by_rigid_elements & ~drilling
        self.floating: dict[str, BoolArray] = {}
        for test_mass in config.test_mass:
            gone, _ = parts_of_test_mass(test_mass.model_parts, geometry)
            there = np.zeros(len(geometry.grid_id), dtype=bool)
            there[e.node_index[gone[index]]] = True
            elsewhere = self._grids_of(~gone)
            listed = np.isin(geometry.grid_id, test_mass.model_parts.grids)
            self.floating[test_mass.name] = listed | (there & ~elsewhere)

    def _grids_of(self, chosen: BoolArray) -> BoolArray:
        e = self.geometry.elements
        mask = np.zeros(len(self.geometry.grid_id), dtype=bool)
        mask[e.node_index[chosen[element_of_member(e)]]] = True
        return mask

    def facts(self, rows: IntArray) -> list[str]:
        """What keeps these grids from carrying a block."""
        ids, position = self.geometry.grid_id, self.geometry.position_m[rows]
        facts = [
            f"{_named(ids[rows[mask[rows]]])} of test mass {name} (its model_parts), which floats free of the structure"
            for name, mask in self.floating.items()
            if mask[rows].any()
        ]
        loose = rows[~self.held[rows]]
        if loose.size:
            facts.append(f"{_named(ids[loose])} in no element and no rigid element: nothing moves it")
        elif needs_rotations(position) and not self.turns[rows].all():
            still = ids[rows[~self.turns[rows]]]
            line = "" if len(rows) == 1 else "; its grids are in a line, so that the rotation about it is theirs"
            facts.append(f"{_named(still)} of solids or rods alone, whose rotations mean nothing{line}")
        return facts

    def soft(self, rows: IntArray) -> IntArray:
        """Those of these grids that turn a block about the normal of shells, and that shells alone hold."""
        own = own_rotation(self.geometry.position_m[rows])
        if not own.any():
            return rows[:0]
        found = [row for row in rows[self.shells_alone[rows]] if _turns_about(self._normals(row), own)]
        return np.array(found, dtype=np.int64)

    def _normals(self, row: int) -> FloatArray:
        """Unit normals [n, 3] of the shells on a grid."""
        e, position = self.geometry.elements, self.geometry.position_m
        out = []
        for element in np.unique(element_of_member(e)[e.node_index == row]):
            if e.type[element] not in _NO_DRILLING:
                continue
            corner = position[e.node_index[e.node_offset[element] : e.node_offset[element + 1]]]
            last = 3 if e.type[element] in ("CQUAD4", "CQUAD8", "CSHEAR") else 1
            across = np.cross(corner[2] - corner[0], corner[last] - corner[1 if last == 3 else 0])
            out.append(across / np.linalg.norm(across))
        return np.array(out)


def _turns_about(normals: FloatArray, own: FloatArray) -> bool:
    """Whether shells are smooth where they meet, and a projection [3, 3] keeps anything of their common normal.

    Shells that meet in a fold hold each other: what is a rotation about the normal of one bends the other.
    """
    normal = np.linalg.eigh(normals.T @ normals)[1][:, -1]
    is_smooth = bool((np.linalg.norm(np.cross(normals, normal), axis=1) < _SMOOTH).all())
    return is_smooth and float(np.linalg.norm(own @ normal)) > _SMOOTH


def _turned_by_rigid_elements(model: Any) -> set[int]:
    """Grids whose rotations rigid elements or multipoint constraints use or give: not those that an RBE3 averages, and
    none that are held in translations alone."""
    found = {int(n) for mpcs in model.mpcs.values() for mpc in mpcs for n in mpc.node_ids if n}
    for element in model.rigid_elements.values():
        given = {"RBE2": "cm", "RBE3": "refc"}.get(element.type)
        if element.type != "RBE3":
            found.update(map(int, element.independent_nodes))
        if given is None or set("456") <= set(str(getattr(element, given))):
            found.update(map(int, element.dependent_nodes))
    return found


def _named(ids: IntArray) -> str:
    return f"grid{'s' * (len(ids) > 1)} {id_list(ids)} {'are' if len(ids) > 1 else 'is'}"
