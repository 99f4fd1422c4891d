"""The finite-element model that thermal nodes lie on, and its thermal areas."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.areas.configured import configured_areas, defines_areas
from tedm_cli.areas.definitions import DefinedAreas
from tedm_cli.areas.places import corner_areas, element_owners, grid_owners
from tedm_cli.arrays import IntArray
from tedm_cli.config.model.file import ModelConfig, load_model
from tedm_cli.config.project import Project
from tedm_cli.files.provenance import ConfigFile
from tedm_cli.mapping.averages import Volumes
from tedm_cli.nastran.geometry import ModelGeometry, model_geometry
from tedm_cli.nastran.loads.area_loads import AreaLoad, none
from tedm_cli.nastran.loads.unit_loads import deck_unit_loads
from tedm_cli.nastran.membership import Membership, membership
from tedm_cli.nastran.node_volumes import node_volumes
from tedm_cli.nastran.reading import deck_files, read_deck


@dataclass(frozen=True, eq=False)
class FiniteElements:
    """A model of N grids and E elements, by ascending ids; `model` is pyNastran's, cross-referenced."""

    project: Project
    config_file: ConfigFile
    config: ModelConfig
    source: Path
    files: list[Path]
    model: Any
    geometry: ModelGeometry

    @cached_property
    def volumes(self) -> Volumes:
        e = self.geometry.elements
        return Volumes(node_offset=e.node_offset, node_index=e.node_index, volume=node_volumes(self.geometry))

    @cached_property
    def members(self) -> Membership:
        """What selections of elements are made among."""
        return membership(self.model, self.geometry, positions=True)

    @cached_property
    def _defined(self) -> DefinedAreas:
        """The areas of the configuration, or else of the deck's temperature cards."""
        if defines_areas(self.config):
            return configured_areas(self.project, self.config, self.model, self.geometry)
        loads = deck_unit_loads(self.model, self.geometry, self.config.model.uniform_label).areas
        return DefinedAreas({a.label: a.area_load(self.geometry) for a in loads}, {}, [], none(), [], [])

    @property
    def areas(self) -> Mapping[str, AreaLoad]:
        """Thermal areas of a mean temperature, by name."""
        return {name: load for name, load in self._defined.loads.items() if load.gradient is None}

    def grid_area(self) -> IntArray:
        """Row of the area [N] of each grid among `areas`, -1: none."""
        return grid_owners(self.geometry, self.areas.values())

    def place_area(self) -> IntArray:
        """Row of the area [M] of each place of each element, -1: none.

        That which selects the element as such, or gives it a temperature of its own; else that of the grid there.
        """
        loads, ids = self.areas, self.geometry.elements.id
        owner = element_owners(self.geometry, loads.values())
        for number, name in enumerate(loads):
            if name in self._defined.selected:
                owner[np.searchsorted(ids, self._defined.selected[name])] = number
        return corner_areas(self.geometry, loads.values(), owner)


def finite_elements(project: Project, *, solved: bool = False) -> FiniteElements:
    """Read the model of a project: that which is to be solved where its areas are defined, else the unit-load deck.

    `solved`: the unit-load deck in any case, which adjoint.h5 is of. Raises what `tedm areas` does of them.
    """
    file, config = load_model(project.model)
    table = config.model
    bdf = table.bdf if defines_areas(config) and not solved else None
    source = project.resolve(bdf if bdf is not None else table.deck)
    model = read_deck(source, allow_missing_enddata=table.allow_missing_enddata, units=table.deck_units())
    files = deck_files(model, source)
    return FiniteElements(project, file, config, source, files, model, model_geometry(model, files))
