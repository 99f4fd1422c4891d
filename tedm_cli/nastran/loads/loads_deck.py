"""Write other loads than temperature as a deck: the model of a unit-load deck, with one subcase for each load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli import deck_units as u
from tedm_cli.area_names import LONGEST
from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.deck_units import DeckUnits
from tedm_cli.errors import InputError
from tedm_cli.fem.structure import LoadCase, OnFreedoms
from tedm_cli.nastran.loads.adjoint_deck import load_cards
from tedm_cli.nastran.loads.temperature_sets import free_set_ids
from tedm_cli.nastran.loads.unit_deck import SourceModel, source_comments
from tedm_cli.nastran.loads.unit_deck_check import control_problem, require_as_meant
from tedm_cli.nastran.structure.mechanical_loads import MechanicalReader
from tedm_cli.nastran.units import units_of

_CARDS = ("FORCE", "MOMENT", "GRAV", "SPCD")
_ROUNDING = 1e-8  # of numbers with nine digits behind the point


@dataclass(frozen=True)
class LoadsDeck:
    """Text of the deck; its subcases as set id and load, in the units of the deck; the number of cards added."""

    text: str
    cases: tuple[tuple[int, LoadCase], ...]
    cards: int


def loads_deck(source: SourceModel, cases: Sequence[LoadCase]) -> LoadsDeck:
    """Compose the deck of a unit-load deck's model and constraints, a subcase for each load, in the deck's units.

    Parameters
    ----------
    cases : in SI, of the structure of that deck, without temperatures.

    Raises
    ------
    InputError : a name that is too long for a LABEL.
    """
    long = [case.label for case in cases if len(case.label) > LONGEST]
    if long:
        fact = f"load {long[0]} has a name of {len(long[0])} characters, and a LABEL has room for {LONGEST}"
        raise InputError(fact, where=source.where, hint="give it a shorter one")
    sections, grid_id, units = source.sections, source.grids.grid_id, units_of(source.model)
    sids = free_set_ids(source.model, len(cases), source.where)
    held = [line for line in source.control.lines if not line.startswith("TEMPERATURE")]
    control = [*source.control.executive, "SOL 101", "CEND", *held]
    added = ["$ Loads other than temperature, added by tedm to the bulk data of", *source_comments(sections)]
    written = []
    for number, (case, sid) in enumerate(zip(cases, sids, strict=True), start=1):
        own = _in_deck_units(case, units)
        control += [f"SUBCASE {number}", f"  LABEL = {case.label}", f"  LOAD = {sid}", "  DISPLACEMENT(PLOT) = ALL"]
        added += [f"$ {case.label}", *_cards(sid, grid_id, own)]
        written.append((sid, own))
    control.append("BEGIN BULK")
    added.append("ENDDATA")
    newline = sections.newline
    text = "".join((newline.join(control), newline, "".join(source.bulk), newline.join(added), newline))
    return LoadsDeck(text, tuple(written), sum(line.startswith(_CARDS) for line in added))


def _in_deck_units(case: LoadCase, units: DeckUnits) -> LoadCase:
    def scaled(given: OnFreedoms | None, along: float, about: float) -> OnFreedoms | None:
        return given and OnFreedoms(given.dof, given.value / np.where(given.dof % 6 < 3, along, about))

    return LoadCase(
        id=case.id,
        label=case.label,
        force=scaled(case.force, units.factor(u.FORCE), units.factor(u.MOMENT)),
        acceleration=None if case.acceleration is None else case.acceleration / units.factor(u.ACCELERATION),
        enforced=scaled(case.enforced, units.length_m, 1.0),
    )


def _cards(sid: int, grid_id: IntArray, case: LoadCase) -> list[str]:
    lines = []
    if case.force is not None:
        lines += load_cards(sid, grid_id, _on_grids(case.force, len(grid_id)))
    if case.acceleration is not None:
        size = float(np.linalg.norm(case.acceleration))
        x, y, z = (_field(v) for v in (case.acceleration / size).tolist())
        lines += [f"{'GRAV*':<8}{sid:>16}{0:>16}{_field(size):>16}{x:>16}", f"*       {y:>16}{z:>16}"]
    if case.enforced is not None:
        # Some solvers want a load beside motions: a force of nothing.
        first = int(grid_id[case.enforced.dof[0] // 6])
        lines += [f"{'FORCE*':<8}{sid:>16}{first:>16}{0:>16}{'0.':>16}", f"*       {'1.':>16}{'0.':>16}{'0.':>16}"]
        for dof, value in zip(case.enforced.dof.tolist(), case.enforced.value.tolist(), strict=True):
            grid, component = int(grid_id[dof // 6]), dof % 6 + 1
            lines += [f"{'SPCD*':<8}{sid:>16}{grid:>16}{component:>16}{_field(value):>16}", "*"]
    return lines


def _field(value: float) -> str:
    return f"{value:.9E}" if value else "0."


def _on_grids(given: OnFreedoms, grids: int) -> FloatArray:
    out = np.zeros(6 * grids)
    np.add.at(out, given.dof, given.value)
    return out.reshape(grids, 6)


def verify_loads_deck(written: Path, out: Path, source: SourceModel, deck: LoadsDeck, supports: IntArray) -> None:
    """Refuse a deck that does not read back as the model with these loads; `out` is its name in messages.

    Parameters
    ----------
    supports : degrees of freedom that the constraints hold.

    Raises
    ------
    InputError : another structure than the model's; other subcases, labels, constraints or loads.
    """
    grids = len(source.grids.grid_id)
    held = OnFreedoms(supports, np.zeros(len(supports)))

    def problem_of(model: Any) -> str:
        wanted = [(case.label, sid) for sid, case in deck.cases]
        if problem := control_problem(model, source, "LOAD", wanted):
            return problem
        reader = MechanicalReader(model, source.grids.grid_id, np.zeros((grids, 3)), held, out)
        for sid, case in deck.cases:
            found = reader.loads(sid)
            pairs = ((found.force, case.force), (found.enforced, case.enforced))
            same = all(_alike(_values(a, grids), _values(b, grids)) for a, b in pairs)
            pull = [np.zeros(3) if a is None else a for a in (found.acceleration, case.acceleration)]
            if not (same and _alike(*pull)):
                return f"loads of {case.label}"
        return ""

    require_as_meant(written, out, source, problem_of, _CARDS)


def _values(given: OnFreedoms | None, grids: int) -> FloatArray:
    return np.zeros((grids, 6)) if given is None else _on_grids(given, grids)


def _alike(found: FloatArray, wanted: FloatArray) -> bool:
    return bool(np.allclose(found, wanted, rtol=_ROUNDING, atol=_ROUNDING**2 * float(np.abs(wanted).max(initial=0.0))))
