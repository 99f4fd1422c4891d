"""What the adjoint needs of a deck: its structure, what its areas warm, and where that is."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.adjoint.areas import Places, Warmed
from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.fem.assembly import element_ids
from tedm_cli.fem.structure import Structure
from tedm_cli.nastran.geometry import ModelGeometry, model_geometry
from tedm_cli.nastran.loads.unit_loads import UnitLoad, deck_unit_loads
from tedm_cli.nastran.node_volumes import node_volumes
from tedm_cli.nastran.reading import cross_reference
from tedm_cli.nastran.structure.adjoint_refusals import refuse_without_coupling
from tedm_cli.nastran.structure.deck import solver_structure


@dataclass(frozen=True, eq=False, kw_only=True)
class WarmedModel:
    """A structure of N grids and L shells, bars and rods, by ascending ids, and its k areas.

    element_id : [L]. name, areas : [k]. own : [L], elements that have temperatures of their own in an area.
    volume : of all elements by ascending ids, m³.
    geometry : grids, elements and their masses.
    """

    structure: Structure
    geometry: ModelGeometry
    element_id: IntArray
    name: list[str]
    areas: list[Warmed]
    own: BoolArray
    places: Places
    volume: FloatArray

    @property
    def gradient(self) -> BoolArray:
        """Which areas are gradients through shells and bars."""
        return np.array([area.gradient is not None for area in self.areas])


def coupled_structure(model: Any, deck: Path, *, superelements: bool = False) -> Structure:
    """The structure of a pyNastran model, not cross-referenced; `superelements`: whether the project has any.

    Raises
    ------
    InputError : it has superelements, something else without a thermal coupling here, or what the embedded solver does
        not model.
    """
    refuse_without_coupling(model, deck)
    structure = solver_structure(model, deck)[0]
    if superelements or structure.direct.dof.size:
        raise InputError(
            "has a superelement, of which temperatures of grids and elements are not known: there is no adjoint",
            where=str(deck),
        )
    return structure


def warmed_model(model: Any, structure: Structure, files: list[Path], uniform_label: str) -> WarmedModel:
    """What the areas of the same model warm; it is cross-referenced here. Raises what `ingest` does of a deck."""
    cross_reference(model, files[0])
    geometry = model_geometry(model, files)
    loads = deck_unit_loads(model, geometry, uniform_label).areas
    carriers = (structure.bars, structure.rods, structure.quads, structure.trias)
    ids = np.sort(np.concatenate([block.element_id for block in carriers]))
    areas = [_warmed(load, geometry, ids) for load in loads]
    own = np.zeros(len(ids), dtype=bool)
    for area in areas:
        if area.gradient is None:
            own[area.element] = True
    return WarmedModel(
        structure=structure,
        geometry=geometry,
        element_id=ids,
        name=[load.label for load in loads],
        areas=areas,
        own=own,
        places=_places(geometry, ids, own),
        volume=_volumes(geometry, np.sort(element_ids(structure))),
    )


def _warmed(load: UnitLoad, geometry: ModelGeometry, ids: IntArray) -> Warmed:
    """The step of a unit load over its size, on elements by their rows among `ids` [L]."""
    element = np.searchsorted(ids, geometry.elements.id[load.elements.loaded])
    gradient = load.elements.gradient / load.load_K if load.kind == "gradient" else None
    return Warmed(grid=load.rows, element=element, gradient=gradient)


def _places(geometry: ModelGeometry, ids: IntArray, own: BoolArray) -> Places:
    """Of all temperatures, where some of the elements `ids` have their `own`."""
    e = geometry.elements
    rows = np.searchsorted(e.id, ids)
    follows = np.ones(len(e.id), dtype=bool)
    follows[rows[own]] = False
    member = np.repeat(np.arange(len(e.id)), np.diff(e.node_offset))
    volume = node_volumes(geometry)
    return Places(
        grid=geometry.position_m,
        grid_volume=_sums(e.node_index, np.where(follows[member], volume, 0.0), len(geometry.grid_id)),
        element=geometry.centres(rows),
        element_volume=_sums(member, volume, len(e.id))[rows],
    )


def _volumes(geometry: ModelGeometry, ids: IntArray) -> FloatArray:
    """Volume of the elements `ids`, m³."""
    e = geometry.elements
    member = np.repeat(np.arange(len(e.id)), np.diff(e.node_offset))
    return _sums(member, node_volumes(geometry), len(e.id))[np.searchsorted(e.id, ids)]


def _sums(place: IntArray, value: FloatArray, count: int) -> FloatArray:
    """Sums [count] of values by their place."""
    return np.bincount(place, value, count).astype(np.float64)
