"""Where thermal areas are in a model: which grids, elements and corners are of each, their centroids and masses."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.nastran.geometry import ModelGeometry
from tedm_cli.nastran.loads.area_loads import AreaLoad


def element_owners(geometry: ModelGeometry, loads: Collection[AreaLoad]) -> IntArray:
    """Row of the area of each element [E] that has a mean temperature of its own, -1: none."""
    owner = np.full(len(geometry.elements.id), -1)
    for number, load in enumerate(loads):
        if load.gradient is None:
            owner[np.searchsorted(geometry.elements.id, load.element_id)] = number
    return owner


def grid_owners(geometry: ModelGeometry, loads: Collection[AreaLoad]) -> IntArray:
    """Row of the area of each grid [N], -1: none."""
    owner = np.full(len(geometry.grid_id), -1)
    for number, load in enumerate(loads):
        owner[np.searchsorted(geometry.grid_id, load.grid_id)] = number
    return owner


def corner_areas(geometry: ModelGeometry, loads: Collection[AreaLoad], owner: IntArray) -> IntArray:
    """Row of the area whose step each node of each element gets [M]: the element's own (`owner`), else its grid's."""
    e = geometry.elements
    own = np.repeat(owner, np.diff(e.node_offset))
    return np.asarray(np.where(own >= 0, own, grid_owners(geometry, loads)[e.node_index]))


def area_centroids(geometry: ModelGeometry, loads: Collection[AreaLoad]) -> FloatArray:
    """Mean position [k, 3] of the grids of each area and of the centres of its elements, m; NaN of one without."""
    places = [_points(geometry, load) for load in loads]
    return np.array([place.mean(axis=0) if len(place) else np.full(3, np.nan) for place in places])


def area_points(geometry: ModelGeometry, loads: Collection[AreaLoad]) -> FloatArray:
    """Positions [n, 3] of all that is in areas, m."""
    return np.concatenate([_points(geometry, load) for load in loads])


def _points(geometry: ModelGeometry, load: AreaLoad) -> FloatArray:
    rows = np.searchsorted(geometry.grid_id, load.grid_id)
    return np.concatenate(
        [geometry.position_m[rows], geometry.centres(np.searchsorted(geometry.elements.id, load.element_id))]
    )


def area_masses(geometry: ModelGeometry, loads: Collection[AreaLoad]) -> FloatArray:
    """Mass [k] of each area, kg: of its elements, and of its grids what other elements and masses put on them.

    Those of a mean temperature sum to the mass of the model less that on grids of no area; one under a gradient has its
    elements, which other areas have too.
    """
    e, owner = geometry.elements, element_owners(geometry, loads)
    counts = np.maximum(np.diff(e.node_offset), 1)
    share = np.repeat(np.where(owner >= 0, e.mass_kg, 0.0) / counts, np.diff(e.node_offset))
    on_grids = (
        geometry.lumped_kg - np.bincount(e.node_index, share, len(geometry.grid_id))
        if (owner >= 0).any()
        else geometry.lumped_kg
    )
    return np.array(
        [
            on_grids[np.searchsorted(geometry.grid_id, load.grid_id)].sum()
            + e.mass_kg[np.searchsorted(e.id, load.element_id)].sum()
            for load in loads
        ]
    )
