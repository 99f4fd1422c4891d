"""Positions of grids in the basic frame, and their displacement frames."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.captured_output import fact_of
from tedm_cli.nastran.frames import local_basis


def read_grids(model: Any, path: Path) -> tuple[IntArray, FloatArray, FloatArray | None]:
    """Grid ids [N] ascending, positions [N, 3], displacement frames [N, 3, 3] or None where all are the basic frame.

    Raises
    ------
    InputError
        For grids in frames that do not exist, and frames that refer to each other in a loop or have no axes.
    """
    _require_frames(model, path)
    if len(model.coords) > 1:
        try:
            model.cross_reference(
                **dict.fromkeys(
                    (
                        *("xref_elements", "xref_properties", "xref_masses", "xref_materials", "xref_loads"),
                        *("xref_constraints", "xref_aero", "xref_sets", "xref_optimization"),
                    ),
                    False,
                )
            )
        except Exception as error:  # of many kinds: loops, frames on one line
            fact = fact_of(error, "")
            raise InputError(f"the coordinate systems cannot be resolved: {fact}", where=str(path)) from error
    grid = columns_of(model).grid
    grid_id, position, used = grid.id, grid.xyz.copy(), grid.cd
    for row in np.flatnonzero(grid.cp).tolist():
        position[row] = model.nodes[int(grid_id[row])].get_position()
    if not used.any():
        return grid_id, position, None
    frame = np.tile(np.eye(3), (len(grid_id), 1, 1))
    for cid in np.unique(used[used != 0]):
        system, rows = model.coords[cid], used == cid
        axes = np.array(system.beta(), dtype=np.float64)  # rows: the axes in the basic frame
        local = (position[rows] - np.array(system.origin, dtype=np.float64)) @ axes.T
        frame[rows] = axes.T @ local_basis(system.Type, local)
    return grid_id, position, frame


def _require_frames(model: Any, path: Path) -> None:
    missing = []
    columns = columns_of(model)
    grid, known = columns.grid, list(model.coords)
    for row in np.flatnonzero(~np.isin(grid.cp, known) | ~np.isin(grid.cd, known)).tolist():
        named = (int(grid.cp[row]), int(grid.cd[row]))
        missing += [f"GRID {grid.id[row]}: frame {cid}" for cid in named if cid not in model.coords]
    for cid, system in model.coords.items():
        if system.type.startswith("CORD1"):
            missing += [
                f"{system.type} {cid}: grid {g}" for g in (system.g1, system.g2, system.g3) if g not in model.nodes
            ]
        elif system.rid not in model.coords:
            missing.append(f"{system.type} {cid}: frame {system.rid}")
    if missing:
        some = "; ".join(missing[:10]) + (" ..." if len(missing) > 10 else "")
        raise InputError(f"{len(missing)} reference(s) to cards that do not exist: {some}", where=str(path))
