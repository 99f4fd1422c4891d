"""write-deck --adjoint: the outputs as loads, for another Nastran to solve."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from tedm_cli.config.project import Project
from tedm_cli.errors import InputError
from tedm_cli.files.store import replacing
from tedm_cli.nastran.loads.adjoint_deck import adjoint_deck, verify_adjoint_deck
from tedm_cli.nastran.loads.adjoint_rows import adjoint_rows
from tedm_cli.nastran.loads.unit_deck import read_source
from tedm_cli.nastran.units import units_of
from tedm_cli.stages.adjoint.model import coupled_structure
from tedm_cli.stages.output_inputs import output_inputs

_NAME = "adjoint_loads.bdf"


@dataclass(frozen=True)
class AdjointDeckSummary:
    """What was written: outputs with a subcase, outputs that nothing acts on, number of cards, and what to know."""

    path: Path
    outputs: list[str]
    without: list[str]
    grids: int
    cards: int
    no_read_outs: str
    notes: tuple[str, ...]


def write_adjoint_deck(project: Project, output: Path | None) -> AdjointDeckSummary:
    """Write the adjoint deck of the unit-load deck and the matrices, and read it back before it is put in place.

    Raises
    ------
    ConfigError, InputError : what `output_inputs` refuses; something without a thermal coupling here, before anything
        is solved; a name that is too long for a label.
    """
    with output_inputs(project, "the adjoint") as given:
        structure = coupled_structure(given.raw, given.deck, superelements=bool(given.config.superelement))
        outputs = given.outputs(structure.grid_id)
        table, deck = given.config.model, given.deck
        rows = adjoint_rows(outputs.label, outputs.force, units_of(given.raw), str(deck))
        if not rows:
            raise InputError("has no grid that moves any output", where=str(deck))
        no_read_outs = given.no_read_outs
    out = output if output is not None else deck.with_name(_NAME)
    with replacing(out) as temporary:
        source = read_source(
            deck, temporary, allow_missing_enddata=table.allow_missing_enddata, units=table.deck_units()
        )
        if os.path.realpath(out) in [os.path.realpath(f) for f in source.sections.files]:
            raise InputError("is a file of the model itself", where=str(out), hint="give it another name")
        written = adjoint_deck(source, rows)
        temporary.write_bytes(written.text.encode("latin-1"))
        verify_adjoint_deck(temporary, out, source, written)
    named = {row.output for row in rows}
    return AdjointDeckSummary(
        out,
        [row.output for row in rows],
        [label for label in outputs.label if label not in named],
        len(structure.grid_id),
        written.cards,
        no_read_outs,
        source.bulk_notes,
    )
