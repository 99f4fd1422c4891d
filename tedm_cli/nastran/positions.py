"""Grids and their coordinate systems in the basic frame, all grids of a system at a time."""

from __future__ import annotations

from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.frames import local_basis

Frames = dict[int, tuple[str, FloatArray, FloatArray]]
"""Kind (R, C, S), origin [3] and axes [3, 3] (rows) of each coordinate system, in the basic frame."""


def frames_of(model: Any) -> Frames:
    """The coordinate systems of a cross-referenced model."""
    return {
        int(cid): (str(c.Type), np.array(c.origin, dtype=float), np.array(c.beta(), dtype=float))
        for cid, c in model.coords.items()
    }


def grid_positions(model: Any, grid_id: IntArray, frames: Frames) -> FloatArray:
    """Positions [N, 3] of grids in the basic frame, m, from the systems (CP) in which they are given."""
    grid = columns_of(model).grid
    rows = np.searchsorted(grid.id, grid_id)
    given, system = grid.xyz[rows], grid.cp[rows]
    out = np.empty_like(given)
    for cid in np.unique(system):
        rows = system == cid
        kind, origin, axes = frames[int(cid)]
        out[rows] = origin + _cartesian(kind, given[rows]) @ axes
    return out


def _cartesian(kind: str, given: FloatArray) -> FloatArray:
    """Coordinates (r, θ, z) or (r, θ, φ), angles in degrees, as x, y, z along the axes of their system."""
    if kind == "R":
        return given
    r = given[:, 0]
    if kind == "C":
        angle = np.radians(given[:, 1])
        return np.column_stack([r * np.cos(angle), r * np.sin(angle), given[:, 2]])
    polar, angle = np.radians(given[:, 1]), np.radians(given[:, 2])
    flat = r * np.sin(polar)
    return np.column_stack([flat * np.cos(angle), flat * np.sin(angle), r * np.cos(polar)])


def basis_at(frames: Frames, cid: int, position: FloatArray) -> FloatArray:
    """Unit vectors [3, 3] (rows, basic frame) of a coordinate system at a place [3]."""
    kind, origin, axes = frames[cid]
    local = (position - origin) @ axes.T
    return np.asarray(local_basis(kind, local[None])[0].T @ axes)
