"""write-deck --loads: other loads than temperature as a deck, for another Nastran to solve."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.config.loads import load_loads
from tedm_cli.config.project import Project
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.files.store import replacing
from tedm_cli.nastran.loads.loads_deck import loads_deck, verify_loads_deck
from tedm_cli.nastran.loads.unit_deck import read_source
from tedm_cli.stages.loads.model import loaded_model

_NAME = "other_loads.bdf"


@dataclass(frozen=True)
class LoadsDeckSummary:
    """What was written: names of the loads, numbers of grids and cards, and what to know."""

    path: Path
    loads: list[str]
    grids: int
    cards: int
    notes: tuple[str, ...]


def write_loads_deck(project: Project, output: Path | None) -> LoadsDeckSummary:
    """Write the deck of the loads of the project, and read it back before it is put in place.

    Raises
    ------
    ConfigError : the project names no loads, none at all, or what the deck has not.
    InputError : cards that the embedded solver does not model, whose forces of swelling are not known here.
    """
    where = project.required_loads()
    _, config = load_loads(where)
    model = loaded_model(project, config, where)
    if not model.loads:
        raise ConfigError([("", "has no load")], where=str(where))
    structure = model.structure
    out = output if output is not None else model.deck.with_name(_NAME)
    with replacing(out) as temporary:
        table = model.config.model
        source = read_source(
            model.deck, temporary, allow_missing_enddata=table.allow_missing_enddata, units=table.deck_units()
        )
        if os.path.realpath(out) in [os.path.realpath(f) for f in source.sections.files]:
            raise InputError("is a file of the model itself", where=str(out), hint="give it another name")
        written = loads_deck(source, [column.case for column in model.loads])
        temporary.write_bytes(written.text.encode("latin-1"))
        supports = np.unique(6 * structure.spc_grid + structure.spc_component - 1)
        verify_loads_deck(temporary, out, source, written, supports)
    names = [column.name for column in model.loads]
    return LoadsDeckSummary(out, names, structure.n_grids, written.cards, source.bulk_notes)
