"""Forces, moments, accelerations and motions of supports of a deck, as its LOAD commands select them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.fem.structure import OnFreedoms
from tedm_cli.nastran.positions import basis_at, frames_of

LOAD_CARDS = ("FORCE", "MOMENT", "GRAV", "SPCD", "LOAD")
"""Cards that are read; sets of others may stand in a deck where no subcase selects them."""
_FIRST = {"FORCE": 0, "MOMENT": 3}


@dataclass(frozen=True, eq=False)
class MechanicalLoads:
    """Loads of a subcase as in `LoadCase`, in the units of the deck; None of what it has not."""

    force: OnFreedoms | None
    acceleration: FloatArray | None
    enforced: OnFreedoms | None


class MechanicalReader:
    """The load sets of a pyNastran model whose coordinate systems are resolved.

    Parameters
    ----------
    grid_id, position : [N] ascending and [N, 3], basic frame.
    supports : the degrees of freedom that are held, with what SPC cards enforce in every subcase.
    """

    def __init__(self, model: Any, grid_id: IntArray, position: FloatArray, supports: OnFreedoms, path: Path) -> None:
        self._model, self._grid_id, self._position, self._path = model, grid_id, position, path
        self._supports = supports

    def loads(self, selected: int | None) -> MechanicalLoads:
        """What a subcase applies that selects this set.

        Raises
        ------
        InputError : a set without cards, with cards that are not modelled, or with two meanings; a grid or a coordinate
            system that is not there; SPCD on what the selected SPC set does not hold, or twice.
        """
        dof, value = [np.zeros(0, dtype=np.int64)], [np.zeros(0)]
        acceleration, motions = np.zeros(3), dict[int, float]()
        pulled = False
        for sid, factor in [] if selected is None else self._members(selected):
            for card in self._cards(sid):
                where = f"{self._path}: {card.type} of set {sid}"
                if card.type == "SPCD":
                    self._enforce(card, motions, where)
                elif card.type == "GRAV":
                    pulled = True
                    acceleration += factor * card.scale * self._axes(card, None, where).T @ np.array(card.N)
                else:
                    row = self._row(int(card.node), where)
                    vector = factor * card.mag * self._axes(card, self._position[row], where).T @ np.array(card.xyz)
                    dof.append(6 * row + _FIRST[card.type] + np.arange(3))
                    value.append(np.asarray(vector, dtype=np.float64))
        force = OnFreedoms(np.concatenate(dof), np.concatenate(value))
        return MechanicalLoads(
            force if force.dof.size else None, acceleration if pulled else None, self._enforced(motions)
        )

    def _members(self, selected: int) -> list[tuple[int, float]]:
        """Sets of cards, and their factors, that make up a set."""
        combinations = self._model.load_combinations.get(selected, [])
        if not combinations:
            return [(selected, 1.0)]
        where = f"{self._path}: LOAD {selected}"
        if len(combinations) > 1 or self._own(selected):
            raise InputError("this set is given twice: by a LOAD and by other cards", where=where)
        (one,) = combinations
        for sid in one.load_ids:
            if sid in self._model.load_combinations:
                raise InputError(f"combines set {sid}, which is a LOAD itself", where=where)
            if any(card.type == "SPCD" for card in self._own(sid)):
                raise InputError(
                    f"combines set {sid}, which has SPCD cards: not all solvers combine these",
                    where=where,
                    hint="select the set of the SPCD cards itself, and give the forces beside them its number",
                )
        return [(int(s), float(one.scale * f)) for s, f in zip(one.load_ids, one.scale_factors, strict=True)]

    def _own(self, sid: int) -> list[Any]:
        return [card for card in self._model.loads.get(sid, []) if not card.type.startswith("TEMP")]

    def _cards(self, sid: int) -> list[Any]:
        cards = self._own(sid)
        if not cards:
            raise InputError(
                f"LOAD = {sid} is selected, and no card defines this set",
                where=str(self._path),
                hint="temperatures are selected by TEMPERATURE(LOAD)",
            )
        others = sorted({card.type for card in cards} - set(LOAD_CARDS))
        if others:
            raise InputError(
                f"load set {sid} has {', '.join(others)}, which the embedded solver does not model",
                where=str(self._path),
                hint=f"it models {', '.join(LOAD_CARDS)}; run Nastran on the deck instead",
            )
        return cards

    def _row(self, grid: int, where: str) -> int:
        row = int(np.searchsorted(self._grid_id, grid))
        if row == len(self._grid_id) or self._grid_id[row] != grid:
            raise InputError(f"names grid {grid}, which does not exist", where=where)
        return row

    def _axes(self, card: Any, position: FloatArray | None, where: str) -> FloatArray:
        """Axes of the card's system as rows, [3, 3], at a place; without one the system has to be rectangular."""
        cid = int(card.cid)
        if cid == 0:
            return np.eye(3)
        if cid not in self._model.coords:
            raise InputError(f"names coordinate system {cid}, which does not exist", where=where)
        frames = frames_of(self._model)
        if position is None and frames[cid][0] != "R":
            fact = f"names coordinate system {cid}, which is curvilinear, and a field has no place"
            raise InputError(fact, where=where, hint="give the acceleration in a rectangular system")
        return basis_at(frames, cid, np.zeros(3) if position is None else position)

    def _enforce(self, card: Any, motions: dict[int, float], where: str) -> None:
        for grid, digits, value in zip(card.nodes, card.components, card.enforced, strict=True):
            row = self._row(int(grid), where)
            for digit in str(digits):
                dof = 6 * row + int(digit) - 1
                if dof not in self._supports.dof:
                    raise InputError(
                        f"enforces grid {grid} component {digit}, which is free",
                        where=where,
                        hint="hold it in the SPC set that the case control selects",
                    )
                if motions.setdefault(dof, float(value)) != float(value):
                    fact = f"enforces grid {grid} component {digit} twice, with different values"
                    raise InputError(fact, where=where)

    def _enforced(self, motions: dict[int, float]) -> OnFreedoms | None:
        """The values of SPCD, and of SPC where a degree of freedom has no SPCD."""
        by_spc = zip(self._supports.dof.tolist(), self._supports.value.tolist(), strict=True)
        both = {dof: value for dof, value in by_spc if value} | motions
        if not both:
            return None
        dof = np.array(sorted(both), dtype=np.int64)
        return OnFreedoms(dof, np.array([both[d] for d in dof.tolist()]))
