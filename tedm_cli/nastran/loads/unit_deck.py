"""Write the unit-load deck: the user's model as it stands, with one subcase of +1 K or +1 K/m per thermal area."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.deck_units import SI, DeckUnits
from tedm_cli.errors import InputError
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.bulk_lines import kept_bulk
from tedm_cli.nastran.cards import no_end, refuse_card_after_end
from tedm_cli.nastran.case_control import Control, unit_control
from tedm_cli.nastran.deck_lines import Line, Sections, read_sections
from tedm_cli.nastran.geometry import Grids, grids, id_list
from tedm_cli.nastran.loads.area_loads import AreaLoad, none, uniform_load
from tedm_cli.nastran.loads.element_cards import element_cards
from tedm_cli.nastran.loads.element_temperatures import SHELLS
from tedm_cli.nastran.loads.temperature_sets import free_set_ids, reference_temperature, temperature_cards
from tedm_cli.nastran.reading import passed_over, read_deck
from tedm_cli.nastran.superelements.deck import DeckMatrices
from tedm_cli.nastran.units import units_of


@dataclass(frozen=True)
class SourceModel:
    """The user's model: its lines, what of its case control stays, and its bulk data as pyNastran reads them."""

    sections: Sections
    control: Control
    bulk: tuple[str, ...]
    model: Any
    grids: Grids
    notes: tuple[str, ...]

    @property
    def where(self) -> str:
        return str(self.sections.files[0])

    @property
    def bulk_notes(self) -> tuple[str, ...]:
        """Those of its bulk data alone."""
        return self.notes[len(self.control.notes) :]


@dataclass(frozen=True)
class UnitDeck:
    """Text of the deck; its subcases as label, set id and load; remarks for the user.

    reference, step, gradient : temperature at rest, step of what is warm, and 1 K/m, as the deck writes them.
    """

    text: str
    cases: tuple[tuple[str, int, AreaLoad], ...]
    reference: float
    step: float
    gradient: float
    notes: tuple[str, ...]


def read_source(
    path: Path,
    scratch: Path,
    constraints_of_subcase: int | None = None,
    *,
    allow_missing_enddata: bool = False,
    units: DeckUnits = SI,
) -> SourceModel:
    """Read a model of any solution, with its INCLUDEs, as the base of unit loads.

    Its bulk data are written to the file `scratch` for pyNastran, which cannot follow every INCLUDE.

    Raises
    ------
    InputError : what `read_sections`, `unit_control`, `kept_bulk` and `read_deck` refuse; superelements; constraints
        that are missing or move a grid; no ENDDATA, unless it is allowed, or cards after it.
    """
    sections = read_sections(path)
    control = unit_control(sections, constraints_of_subcase)
    bulk, notes = kept_bulk(sections.bulk)
    if sections.left_over:
        notes.append(f"{len(sections.left_over)} lines after ENDDATA are no part of the model")
    if not sections.has_end and not allow_missing_enddata:
        raise no_end(path)
    model = _read_model(control, sections.bulk, path, scratch, units)
    for line in sections.left_over:
        refuse_card_after_end(model, line.text, line.place)
    notes += passed_over(model)
    _check_model(model, control, str(path))
    found = grids(model, list(sections.files))
    return SourceModel(sections, control, tuple(bulk), model, found, (*control.notes, *notes))


def with_cards(source: SourceModel, cards: Sequence[str], scratch: Path, units: DeckUnits) -> SourceModel:
    """A model with more bulk data cards, read again."""
    text = "".join(f"{card}{source.sections.newline}" for card in cards)
    where = source.sections.files[0]
    lines = (*source.sections.bulk, *(Line(f"{card}\n", where, 0) for card in cards))
    model = _read_model(source.control, lines, where, scratch, units)
    found = grids(model, list(source.sections.files))
    return replace(source, bulk=(*source.bulk, text), model=model, grids=found)


def _read_model(control: Control, lines: tuple[Line, ...], path: Path, scratch: Path, units: DeckUnits) -> Any:
    """The case control that stays (its SETs may define areas) and the bulk data through `read_deck`.

    Places in messages become those of the user's files.
    """
    head = "\n".join(["SOL 101", "CEND", *control.lines, "BEGIN BULK", ""])
    scratch.write_bytes((head + "".join(line.text for line in lines)).encode("latin-1"))
    try:
        return read_deck(scratch, allow_missing_enddata=True, units=units)
    except InputError as exc:
        where = exc.where.replace(str(scratch), str(path))
        number = exc.where.removeprefix(f"{scratch}:")
        if number.isdigit() and int(number) > head.count("\n"):
            where = lines[int(number) - head.count("\n") - 1].place
        raise InputError(exc.fact, where=where, hint=exc.hint) from exc


def _check_model(model: Any, control: Control, where: str) -> None:
    inside = [i for i, grid in columns_of(model).grid_cards.items() if grid.seid]  # plain ones have none
    if inside or (model.grdset is not None and model.grdset.seid):
        some = id_list(sorted(inside)) or "GRDSET"
        raise InputError(f"grids in superelements (SEID): {some}", where=where, hint="solve the model in one piece")
    tables = {"SPC": (model.spcs, model.spcadds), "MPC": (model.mpcs, model.mpcadds)}
    for name, (cards, sums) in tables.items():
        wanted = control.sets.get(name)
        if wanted is not None and wanted not in cards and wanted not in sums:
            raise InputError(f"case control selects {name} {wanted}, which is not in the bulk data", where=where)
    wanted = control.sets.get("SPC")
    if wanted is None:
        return
    sids = {wanted, *(int(i) for card in model.spcadds.get(wanted, []) for i in card.sets)}
    for sid in sorted(sids):
        for card in model.spcs.get(sid, []):
            if card.type == "SPC" and any(card.enforced):
                raise InputError(
                    f"SPC {sid} moves grids {id_list(card.nodes)}, which loads them besides their temperature",
                    where=where,
                    hint="set its displacement to zero",
                )


def unit_deck(
    source: SourceModel,
    areas: Mapping[str, AreaLoad],
    uniform_label: str,
    reference_K: float | None = None,
    superelements: DeckMatrices | None = None,
) -> UnitDeck:
    """Compose the unit-load deck of a model: its own lines, one subcase per area, and one that warms all.

    It is in the model's own units; `reference_K` is in K, and the step is 1 K, in degrees of the model. Of an area
    under a gradient it is 1 K/m at the reference temperature, and the subcase that warms all leaves it out. The areas
    of `superelements` have subcases too; nothing of the deck is warm in those that the deck does not have.

    Raises
    ------
    InputError : an area has the name of the uniform load; what `reference_temperature` refuses.
    """
    where, sections = source.where, source.sections
    for name in areas:
        if name.upper() == uniform_label.upper():
            raise InputError(f"area '{name}' has the name of the uniform load", where=where, hint="set uniform_label")
    reference = reference_temperature(
        source.model, reference_K, material_temperature=source.control.material_temperature, where=where
    )
    matrices = superelements or DeckMatrices()
    known = {name.upper() for name in areas}
    elsewhere = {name: AreaLoad(none(), none(), none()) for name in matrices.names if name.upper() not in known}
    loads = {**areas, **elsewhere, uniform_label: uniform_load(areas.values())}
    units = units_of(source.model)
    gradient = units.degrees_per_kelvin * Decimal(repr(units.length_m))
    sids = free_set_ids(source.model, len(loads) + reference.is_initial, where)
    control = [*source.control.executive, "SOL 101", "CEND", *source.control.lines, *matrices.control()]
    if reference.is_initial:
        control.append(f"TEMPERATURE(INITIAL) = {sids[-1]}")
    for number, (label, sid) in enumerate(zip(loads, sids, strict=False), start=1):
        control += [
            f"SUBCASE {number}",
            f"  LABEL = {label}",
            f"  TEMPERATURE(LOAD) = {sid}",
            "  DISPLACEMENT(PLOT) = ALL",
        ]
    control.append("BEGIN BULK")
    added = ["$ Unit loads added by tedm to the bulk data of", *source_comments(sections)]
    for sid, load in zip(sids, loads.values(), strict=False):
        added += _load_cards(source.model, sid, load, reference.value, gradient)
    if reference.is_initial:
        added += temperature_cards(sids[-1], reference.value, none())
    added += matrices.bulk(list(loads), uniform_label)
    added.append("ENDDATA")
    newline = sections.newline
    parts = (newline.join(control), newline, "".join(source.bulk), newline.join(added), newline)
    cases = tuple((label, sid, load) for (label, load), sid in zip(loads.items(), sids, strict=False))
    notes = (*source.notes, *reference.notes)
    step = float(units.degrees_per_kelvin)
    return UnitDeck("".join(parts), cases, float(reference.value), step, float(gradient), notes)


def source_comments(sections: Sections) -> list[str]:
    """Names and checksums of the files of a model, as comments."""
    out = []
    for file in sections.files:
        # One line of ASCII, whatever the name: a line end in it would begin a card.
        name = file.name.encode("unicode_escape").decode("ascii")
        out += [f"$   {name}", f"$     SHA-256 {hashlib.sha256(file.read_bytes()).hexdigest()}"]
    return out


def _load_cards(model: Any, sid: int, load: AreaLoad, rest: Decimal, gradient: Decimal) -> list[str]:
    """The temperature set of one load: grids, then elements with a temperature of their own, then those at rest."""
    step = units_of(model).degrees_per_kelvin

    elements = columns_of(model).element
    is_shell = elements.is_of(SHELLS)

    def cards(ids: IntArray, mean: Decimal, slope: FloatArray | None = None) -> list[str]:
        return element_cards(sid, ids, is_shell[np.searchsorted(elements.id, ids)], mean, slope, gradient)

    mean = rest if load.gradient is not None else rest + step
    lines = temperature_cards(sid, rest, load.grid_id, step)
    return lines + cards(load.element_id, mean, load.gradient) + cards(load.held_id, rest)
