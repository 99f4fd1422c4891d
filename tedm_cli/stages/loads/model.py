"""The structure of a project's deck with its mass, and the loads on it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import scipy.sparse as sp

from tedm_cli.config.loads import LoadsConfig
from tedm_cli.config.model.file import ModelConfig, load_model
from tedm_cli.config.project import Project
from tedm_cli.errors import InputError
from tedm_cli.fem.structure import Structure
from tedm_cli.nastran.geometry import ModelGeometry, model_geometry
from tedm_cli.nastran.membership import membership
from tedm_cli.nastran.reading import cross_reference, deck_files, read_deck
from tedm_cli.nastran.structure.deck import solver_structure
from tedm_cli.nastran.structure.masses import model_mass
from tedm_cli.nastran.structure.material_use import material_use
from tedm_cli.stages.loads.columns import Column, columns


@dataclass(frozen=True, eq=False)
class LoadedModel:
    """The unit-load deck as a structure, its mass matrix, its geometry, and the loads in SI.

    scalar_points : ids that results may have rows for.
    """

    deck: Path
    config: ModelConfig
    structure: Structure
    geometry: ModelGeometry
    mass: sp.csr_matrix
    loads: list[Column]
    scalar_points: frozenset[int]


def loaded_model(project: Project, loads: LoadsConfig, where: Path, raw: Any = None) -> LoadedModel:
    """Of the deck of a project, or of its model `raw`, not cross-referenced, where that was read already.

    Raises
    ------
    ConfigError : what `columns` refuses of the file of loads, `where`.
    InputError : cards that the embedded solver does not model; superelements, which have their masses elsewhere.
    """
    _, config = load_model(project.model)
    table = config.model
    deck = project.resolve(table.deck)
    if raw is None:
        raw = read_deck(
            deck, cross_reference=False, allow_missing_enddata=table.allow_missing_enddata, units=table.deck_units()
        )
    structure, _ = solver_structure(raw, deck)
    if config.superelement or structure.direct.dof.size:
        raise InputError(
            "has a superelement, whose mass is not in the matrices, and whose inside loads do not reach: there is no"
            " effect of loads",
            where=str(deck),
        )
    use = material_use(raw)
    cross_reference(raw, deck)
    geometry = model_geometry(raw, deck_files(raw, deck))
    members = membership(raw, geometry, positions=True)
    found = columns(loads, structure, members, use, where)
    return LoadedModel(deck, config, structure, geometry, model_mass(geometry), found, frozenset(raw.spoints))
