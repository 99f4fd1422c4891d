"""write-deck: the unit-load deck of the model."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tedm_cli.areas.configured import configured_areas, defines_areas
from tedm_cli.areas.definitions import require_partition
from tedm_cli.areas.materials import judge_materials
from tedm_cli.areas.mean_step import MeanStep, mean_steps
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.deck_units import DeckUnits
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.files.store import replacing
from tedm_cli.nastran.geometry import model_geometry
from tedm_cli.nastran.loads.unit_deck import SourceModel, read_source, unit_deck, with_cards
from tedm_cli.nastran.loads.unit_deck_check import verify_unit_deck
from tedm_cli.nastran.superelements.deck import DeckMatrices, mass_cards
from tedm_cli.regular_file import require_regular_file
from tedm_cli.stages.layout_match import require_layout_fits
from tedm_cli.stages.model.superelements import Reduced, reduced_on, require_own_areas


@dataclass(frozen=True)
class DeckSummary:
    """What was written.

    reference : temperature from which the unit loads start, in the deck's scale `temperature`. mean_step : of the
    areas' own elements, by area.
    """

    path: Path
    grids: int
    areas: int
    reference: float
    temperature: str
    mean_step: tuple[MeanStep, ...]
    notes: tuple[str, ...]


def write_deck(project: Project, output: Path | None) -> DeckSummary:
    """Write the unit-load deck of the configured model and areas, and read it back before it is put in place."""
    file, config = load_model(project.model)
    table = config.model
    missing = [] if table.bdf is not None else [("model.bdf", "needed to write a deck")]
    if not defines_areas(config):
        missing.append(("model.areas_csv", "needed to write a deck, or [[areas.define]] tables"))
    if missing:
        raise ConfigError(missing, where=str(file.path))
    out = output if output is not None else project.resolve(table.deck)
    bdf = project.resolve(str(table.bdf))
    require_regular_file(bdf)
    if not bdf.is_file():
        raise InputError("no such model", where=str(bdf), hint="correct model.bdf")
    with replacing(out) as temporary:
        source = read_source(
            bdf,
            temporary,
            table.constraints_of_subcase,
            allow_missing_enddata=table.allow_missing_enddata,
            units=table.deck_units(),
        )
        if os.path.realpath(out) in [os.path.realpath(f) for f in source.sections.files]:  # no complaint of link loops
            raise InputError("is a file of the model itself", where=str(out), hint="give model.deck another name")
        geometry = model_geometry(
            source.model, list(source.sections.files)
        )  # a wrong unit is said before anything is solved
        require_layout_fits(project, config, geometry.grid_id, geometry.position_m)
        reduced = reduced_on(project, config, geometry)
        matrices = None
        if reduced:
            source, matrices = _with_superelements(source, reduced, temporary, table.deck_units())
            geometry = model_geometry(source.model, list(source.sections.files))
        areas = configured_areas(project, config, source.model, geometry)
        require_own_areas(reduced, [*areas.loads, table.uniform_label], str(bdf))
        require_partition(areas, where=str(bdf))
        materials = judge_materials(source.model, geometry, areas.loads)
        materials.require(str(bdf))
        steps = mean_steps(geometry, areas.loads, areas.selected)
        deck = unit_deck(source, areas.loads, table.uniform_label, table.reference_temperature_K, matrices)
        temporary.write_bytes(deck.text.encode("latin-1"))
        verify_unit_deck(temporary, out, source, deck)
    return DeckSummary(
        out,
        len(source.grids.grid_id),
        len(deck.cases) - 1,
        deck.reference,
        table.temperature,
        tuple(steps),
        (*table.unit_notes(), *areas.lines(), *materials.notes, *deck.notes),
    )


def _with_superelements(
    source: SourceModel, reduced: Sequence[Reduced], scratch: Path, units: DeckUnits
) -> tuple[SourceModel, DeckMatrices]:
    """The model with the grids with mass of superelements, and their matrices.

    Raises
    ------
    InputError : a model that selects matrices itself; what `mass_cards` refuses.
    """
    own = [line for line in source.control.lines if line.upper().startswith("K2GG")]
    if own:
        raise InputError(
            f"its case control has {own[0]}, which would take the place of the superelements",
            where=source.where,
            hint="give that matrix as a [[superelement]], too",
        )
    matrices = DeckMatrices.of([(r.given.interface, r.given.area, r.matrices) for r in reduced])
    for one in reduced:
        given = one.given
        lines = mass_cards(
            source.model, given.node, given.position, given.mass, given.interface, f"superelement '{given.table.name}'"
        )
        source = with_cards(source, lines, scratch, units)
    return source, matrices
