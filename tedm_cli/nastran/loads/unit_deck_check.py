"""Read a written unit-load deck back and compare it with the model and the areas it was made from."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.errors import InputError
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.geometry import id_list
from tedm_cli.nastran.loads.area_loads import AreaLoad
from tedm_cli.nastran.loads.element_temperatures import element_temperatures
from tedm_cli.nastran.loads.unit_deck import SourceModel, UnitDeck
from tedm_cli.nastran.reading import read_deck
from tedm_cli.nastran.units import units_of

_OWN = ("TEMP", "TEMPD", "TEMPP1", "TEMPRB", "PARAM", "ENDDATA")
_LOADS = {"LOAD", "DEFORM", "TEMPERATURE", "TEMPERATURE(BOTH)", "TEMPERATURE(LOAD)"}
_TABLES = ("rigid_elements", "masses", "properties", "materials", "coords", "spcs", "mpcs")


def verify_unit_deck(written: Path, out: Path, source: SourceModel, deck: UnitDeck) -> None:
    """Refuse a deck that does not read back as the model with these unit loads; `out` is its name in messages.

    Raises
    ------
    InputError : another set of cards, grids, elements, properties or constraints than the model's; other subcases,
        labels, constraints, temperatures or reference than the unit loads'.
    """
    require_as_meant(written, out, source, lambda model: _load_problem(model, source, deck), ["DMIG"])


def require_as_meant(
    written: Path, out: Path, source: SourceModel, problem_of: Callable[[Any], str], own: Sequence[str] = ()
) -> None:
    """Refuse a deck whose structure is not that of the model it was made of, or with a problem of its loads.

    Parameters
    ----------
    problem_of : what is wrong with the subcases of the deck as it is read back; empty where nothing is.
    own : names of cards that are added, besides those of temperatures.

    Raises
    ------
    InputError : as `verify_unit_deck`; `out` is the deck's name in it.
    """
    try:
        model = read_deck(written, cross_reference=False, units=units_of(source.model))
    except InputError as exc:
        raise InputError(exc.fact, where=exc.where.replace(str(written), str(out)), hint=exc.hint) from exc
    problem = _structure_problem(source.model, model, (*_OWN, *own)) or problem_of(model)
    if problem:
        raise InputError(
            f"does not read back as it was meant, so it is not written: {problem}",
            where=str(out),
            hint="report this with the model, or simplify the cards named",
        )


def _structure_problem(wanted: Any, found: Any, own: Sequence[str]) -> str:
    ours, theirs = columns_of(wanted), columns_of(found)
    for table, ids, others in (
        ("nodes", ours.grid.id, theirs.grid.id),
        ("elements", ours.element.id, theirs.element.id),
    ):
        if not np.array_equal(ids, others):
            return f"{table} {id_list(np.setxor1d(ids, others))}"
    for table in _TABLES:
        differ = set(getattr(wanted, table)) ^ set(getattr(found, table))
        if differ:
            return f"{table} {id_list(sorted(differ))}"
    for name in ("spcs", "mpcs"):
        for sid, cards in getattr(wanted, name).items():
            if len(cards) != len(getattr(found, name)[sid]):
                return f"{name[:-1].upper()} {sid}"
    counts = [Counter({k: n for k, n in m.card_count.items() if k not in own}) for m in (wanted, found)]
    differ = {name for name in counts[0] | counts[1] if counts[0][name] != counts[1][name]}
    if differ:
        return ", ".join(f"{counts[0][n]} {n} in the model, {counts[1][n]} in the deck" for n in sorted(differ))
    moved = ours.grid.id[(ours.grid.xyz != theirs.grid.xyz).any(axis=1)]
    if moved.size:
        return f"coordinates of grids {id_list(moved)}"
    post = found.params.get("POST")
    return "" if post is not None and post.values[0] == -1 else "PARAM,POST is not -1"


def _load_problem(model: Any, source: SourceModel, deck: UnitDeck) -> str:
    wanted = [(label, sid) for label, sid, _ in deck.cases]
    if problem := control_problem(model, source, "TEMPERATURE(LOAD)", wanted):
        return problem
    for number, (label, sid, load) in enumerate(deck.cases, start=1):
        rest = float(model.tempds[sid].temperature)
        warm = columns_of(model).temperature_sets.get(sid)
        ids, values = (load.grid_id[:0], np.zeros(0)) if warm is None else (warm.grid_id, warm.value)
        if rest != deck.reference or not np.array_equal(np.sort(ids), load.grid_id):
            return f"temperatures of subcase {number} ({label})"
        if not np.allclose(values, rest + deck.step, rtol=1e-14, atol=0.0):
            return f"step of subcase {number} ({label})"
        if not _elements_agree(model, sid, load, deck):
            return f"temperatures of elements in subcase {number} ({label})"
    return ""


def control_problem(model: Any, source: SourceModel, key: str, wanted: Sequence[tuple[str, int]]) -> str:
    """What is wrong with subcases 1, 2, ... that are to have these labels and, by `key`, these loads and no others."""
    if model.sol != 101:
        return f"SOL {model.sol}"
    subcases = {int(n): s for n, s in model.case_control_deck.subcases.items() if n != 0}
    if sorted(subcases) != list(range(1, len(wanted) + 1)):
        return f"subcases {id_list(sorted(subcases))}"
    for number, (label, sid) in enumerate(wanted, start=1):
        subcase = subcases[number]
        if str(subcase.get_parameter("LABEL")[0]) != label:
            return f"label of subcase {number}"
        if key not in subcase.params or subcase.get_parameter(key)[0] != sid:
            return f"{key} of subcase {number}"
        for held in ("SPC", "MPC", "SUPORT1"):
            chosen = subcase.get_parameter(held)[0] if held in subcase.params else None
            if chosen != source.control.sets.get(held):
                return f"{held} of subcase {number}"
        foreign = _LOADS & set(subcase.params) - {key}
        if foreign:
            return f"{', '.join(sorted(foreign))} in subcase {number}"
    return ""


def _elements_agree(model: Any, sid: int, load: AreaLoad, deck: UnitDeck) -> bool:
    """Whether the elements of a set, their means and their gradients are those of a load."""
    found = element_temperatures(model, sid)
    ids = np.concatenate([load.element_id, load.held_id])
    if found is None or not ids.size:
        return found is None and not ids.size
    order = np.argsort(ids)
    mean, gradient = np.full(len(ids), deck.reference), np.zeros((len(ids), 2))
    if load.gradient is None:
        mean[: len(load.element_id)] += deck.step
    else:
        gradient[: len(load.element_id)] = deck.gradient * load.gradient
    return bool(
        np.array_equal(found.element_id, ids[order])
        and np.allclose(found.mean, mean[order, None], rtol=1e-14, atol=0.0)
        and np.allclose(found.gradient, gradient[order, None], rtol=1e-8, atol=1e-8 * deck.gradient)
    )
