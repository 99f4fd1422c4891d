"""write-deck: the unit-load deck of the model."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tedm_cli.areas.configured import configured_areas, defines_areas
from tedm_cli.areas.definitions import require_partition
from tedm_cli.config.model import load_model
from tedm_cli.config.project import Project
from tedm_cli.errors import ConfigError
from tedm_cli.nastran.geometry import grids
from tedm_cli.nastran.reading import deck_files, read_deck
from tedm_cli.nastran.unit_deck import unit_deck_text
from tedm_cli.store import replacing


@dataclass(frozen=True)
class DeckSummary:
    path: Path
    grids: int
    areas: int
    notes: list[str]


def write_deck(project: Project, output: Path | None) -> DeckSummary:
    """Write the unit-load deck of the configured model and areas."""
    file, config = load_model(project.model)
    missing = [] if config.model.bdf is not None else [("model.bdf", "needed to write a deck")]
    if not defines_areas(config):
        missing.append(("model.areas_csv", "needed to write a deck, or [[areas.define]] tables"))
    if missing:
        raise ConfigError(missing, where=str(file.path))
    source = project.resolve(str(config.model.bdf))
    out = output if output is not None else project.resolve(config.model.deck)
    model = read_deck(source, cross_reference=config.areas.has_boxes())
    found = grids(model, deck_files(model, source))
    areas = configured_areas(project, config, model, found)
    require_partition(areas, where=str(source))
    text = unit_deck_text(source, out, model, found, areas.areas, config.model.uniform_label)
    with replacing(out) as temporary:
        temporary.write_text(text, encoding="latin-1", newline="\n")
    return DeckSummary(out, len(found.grid_id), len(areas.areas), areas.lines())
