"""Write thermal nodes as a deck: the model of a unit-load deck, with one subcase of temperatures for each node."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.area_names import LONGEST
from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.loads.grid_temperatures import absolute, grid_temperature_lines
from tedm_cli.nastran.loads.temperature_sets import free_set_ids, reference_temperature
from tedm_cli.nastran.loads.unit_deck import SourceModel, source_comments
from tedm_cli.nastran.loads.unit_deck_check import control_problem, require_as_meant
from tedm_cli.nastran.units import units_of

_ROUNDING_K = 1e-10  # of temperatures in a large field


@dataclass(frozen=True, eq=False)
class NodeDeck:
    """Text of the deck; its subcases as label and set id; the temperature at rest in its scale; what to know."""

    text: str
    cases: tuple[tuple[str, int], ...]
    rest: float
    notes: tuple[str, ...]


def node_deck(
    source: SourceModel, names: Sequence[str], rows: IntArray, field: FloatArray, reference_K: float | None
) -> NodeDeck:
    """Compose the deck of a unit-load deck's model and constraints, a subcase for each node.

    Parameters
    ----------
    rows : [m], of the grids that have a temperature; all others stay at rest.
    field : [N, n], K above rest per kelvin of each node.

    Raises
    ------
    InputError : a name that is too long for a LABEL, or has spaces or signs at its ends that it would lose there; what
        `reference_temperature` refuses.
    """
    unfit = [name for name in names if len(name) > LONGEST or name != name.strip() or not name.isascii()]
    if unfit:
        fact = f"thermal node {unfit[0]!r} has a name that no LABEL can hold: at most {LONGEST} characters of ASCII"
        raise InputError(fact, where=source.where, hint="give it another one")
    reference = reference_temperature(
        source.model, reference_K, material_temperature=source.control.material_temperature, where=source.where
    )
    sections = source.sections
    sids = free_set_ids(source.model, len(names) + reference.is_initial, source.where)
    control = [*source.control.executive, "SOL 101", "CEND", *source.control.lines]
    added = ["$ Temperatures of thermal nodes added by tedm to the bulk data of", *source_comments(sections)]
    ids, degrees = source.grids.grid_id[rows], units_of(source.model).degrees_per_kelvin
    if reference.is_initial:
        control.append(f"TEMPERATURE(INITIAL) = {sids[-1]}")
        added += grid_temperature_lines(sids[-1], reference.value, ids[:0], [])
    for number, (name, sid) in enumerate(zip(names, sids, strict=False), start=1):
        temperature = absolute(field[rows, number - 1], reference.value, degrees)
        control += [
            f"SUBCASE {number}",
            f"  LABEL = {name}",
            f"  TEMPERATURE(LOAD) = {sid}",
            "  DISPLACEMENT(PLOT) = ALL",
        ]
        added += [f"$ {name}", *grid_temperature_lines(sid, reference.value, ids, temperature)]
    control.append("BEGIN BULK")
    added.append("ENDDATA")
    newline = sections.newline
    text = "".join((newline.join(control), newline, "".join(source.bulk), newline.join(added), newline))
    cases = tuple(zip(names, sids, strict=False))
    return NodeDeck(text, cases, float(reference.value), (*source.bulk_notes, *reference.notes))


def verify_node_deck(
    written: Path, out: Path, source: SourceModel, deck: NodeDeck, rows: IntArray, field: FloatArray
) -> None:
    """Refuse a deck that does not read back as the model with these temperatures; `out` is its name in messages.

    Raises
    ------
    InputError : another structure than the model's; other subcases, labels, constraints or temperatures.
    """
    ids, degrees = source.grids.grid_id[rows], float(units_of(source.model).degrees_per_kelvin)

    def problem_of(model: Any) -> str:
        if problem := control_problem(model, source, "TEMPERATURE(LOAD)", deck.cases):
            return problem
        for number, (label, sid) in enumerate(deck.cases):
            found = columns_of(model).temperature_sets.get(sid)
            given, value = (ids[:0], field[:0, 0]) if found is None else (found.grid_id, found.value)
            order = np.argsort(given, kind="stable")
            same = np.array_equal(given[order], ids) and float(model.tempds[sid].temperature) == deck.rest
            steps = (value[order] - deck.rest) / degrees if same else field[:0, 0]
            room = _ROUNDING_K * max(1.0, abs(deck.rest) / 1e3)
            if not same or not np.allclose(steps, field[rows, number], rtol=0.0, atol=room):
                return f"temperatures of {label}"
        return ""

    require_as_meant(written, out, source, problem_of)
