"""Write the adjoint deck: the model of a unit-load deck, with one subcase of forces and moments for each output."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.loads.adjoint_rows import AdjointRow
from tedm_cli.nastran.loads.temperature_sets import free_set_ids
from tedm_cli.nastran.loads.unit_deck import SourceModel, source_comments
from tedm_cli.nastran.loads.unit_deck_check import control_problem, require_as_meant

_CARDS = ("FORCE", "MOMENT")
_DIGITS = 9  # behind the point; with sign and exponent they fill a large field
_ROUNDING = 10.0**-_DIGITS


@dataclass(frozen=True)
class AdjointDeck:
    """Text of the deck; its subcases as label, set id and load; the number of its FORCE and MOMENT cards."""

    text: str
    cases: tuple[tuple[str, int, FloatArray], ...]
    cards: int


def adjoint_deck(source: SourceModel, rows: Sequence[AdjointRow]) -> AdjointDeck:
    """Compose the deck of a unit-load deck's model and constraints, a subcase for each of the outputs.

    The forces are in the basic frame, whatever the displacement frames of the grids. No subcase selects temperatures:
    those of the unit loads stay in the bulk data, and are not used.
    """
    sections, grid_id = source.sections, source.grids.grid_id
    sids = free_set_ids(source.model, len(rows), source.where)
    held = [line for line in source.control.lines if not line.startswith("TEMPERATURE")]  # of MATTi, which are refused
    control = [*source.control.executive, "SOL 101", "CEND", *held]
    added = ["$ Adjoint loads added by tedm to the bulk data of", *source_comments(sections)]
    added += ["$ Displacements in m and rad, times SCALE, are per unit of the output over N and N m."]
    for number, (row, sid) in enumerate(zip(rows, sids, strict=True), start=1):
        control += [f"SUBCASE {number}", f"  LABEL = {row.label}", f"  LOAD = {sid}", "  DISPLACEMENT(PLOT) = ALL"]
        added += [f"$ {row.label}", *load_cards(sid, grid_id, row.load)]
    control.append("BEGIN BULK")
    added.append("ENDDATA")
    newline = sections.newline
    text = "".join((newline.join(control), newline, "".join(source.bulk), newline.join(added), newline))
    cases = tuple((row.label, sid, row.load) for row, sid in zip(rows, sids, strict=True))
    return AdjointDeck(text, cases, sum(line.startswith(_CARDS) for line in added))


def load_cards(sid: int, grid_id: IntArray, load: FloatArray) -> list[str]:
    """FORCE and MOMENT cards of the grids [N] with a load [N, 6] that is not zero, in large fields, basic frame."""
    lines = []
    for card, three in zip(_CARDS, (load[:, :3], load[:, 3:]), strict=True):
        head = f"{card + '*':<8}{sid:>16}"
        for row in np.flatnonzero(three.any(axis=1)).tolist():
            x, y, z = (_field(value) for value in three[row].tolist())
            lines += [f"{head}{int(grid_id[row]):>16}{0:>16}{'1.':>16}", f"*       {x:>16}{y:>16}{z:>16}"]
    return lines


def _field(value: float) -> str:
    return f"{value:.{_DIGITS}E}" if value else "0."


def verify_adjoint_deck(written: Path, out: Path, source: SourceModel, deck: AdjointDeck) -> None:
    """Refuse a deck that does not read back as the model with these loads; `out` is its name in messages.

    Raises
    ------
    InputError : another structure than the model's; other subcases, labels, constraints or loads.
    """

    def problem_of(model: Any) -> str:
        wanted = [(label, sid) for label, sid, _ in deck.cases]
        problem = control_problem(model, source, "LOAD", wanted)
        if problem:
            return problem
        grids = source.grids.grid_id
        for number, (label, sid, load) in enumerate(deck.cases, start=1):
            found = loads_of(model, sid, grids)
            if found is None or not np.allclose(found, load, rtol=_ROUNDING, atol=0.0):
                return f"forces of subcase {number} ({label})"
        return ""

    require_as_meant(written, out, source, problem_of, _CARDS)


def loads_of(model: Any, sid: int, grid_id: IntArray) -> FloatArray | None:
    """Forces and moments [N, 6] of a set of FORCE and MOMENT cards in the basic frame; None where it has others."""
    out = np.zeros((len(grid_id), 6))
    if sid in columns_of(model).temperature_sets:
        return None
    for card in model.loads.get(sid, []):
        if card.type not in _CARDS or card.cid != 0:
            return None
        row = int(np.searchsorted(grid_id, card.node))
        first = 3 * _CARDS.index(card.type)
        out[row, first : first + 3] += card.mag * card.xyz
    return out
