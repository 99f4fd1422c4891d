"""Grids, elements and masses of a deck as plain arrays in SI and the basic frame."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.deck_units import SI, DeckUnits
from tedm_cli.errors import InputError
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.loads.area_loads import Mesh
from tedm_cli.nastran.masses.concentrated import Concentrated, concentrated_masses
from tedm_cli.nastran.masses.elements import Elements, model_elements
from tedm_cli.nastran.masses.matrices import refuse_matrices
from tedm_cli.nastran.parameter_values import number_parameter
from tedm_cli.nastran.plausible import check_units
from tedm_cli.nastran.positions import Frames, basis_at, frames_of, grid_positions
from tedm_cli.nastran.rigid_grids import grids_of_rigid_elements
from tedm_cli.nastran.units import elements_in_si, frames_in_si, in_si, units_of


@dataclass(frozen=True)
class Grids:
    """Grid ids [N] ascending, which of them are corners of elements, and which are in rigid elements or MPCs.

    `files`: the deck and its includes.
    """

    files: list[Path]
    grid_id: IntArray
    structural: BoolArray
    in_rigid_element: BoolArray


@dataclass(frozen=True)
class ModelGeometry(Grids):
    """Geometry and mass of a finite-element model.

    grid_id [N] ascending; position_m [N,3] in the basic frame; lumped_kg [N]: every element's mass shared equally
    among its corners, plus concentrated masses; `files`: the deck and its includes; `units`: those of the deck.
    """

    position_m: FloatArray
    displacement_frame: IntArray
    frames: Frames
    elements: Elements
    concentrated: Concentrated
    lumped_kg: FloatArray
    units: DeckUnits = SI

    @cached_property
    def mesh(self) -> Mesh:
        """Its elements, and which of them follow their grids."""
        return Mesh(self.structural, np.array(self.elements.type), self.elements.node_offset, self.elements.node_index)

    def centres(self, rows: IntArray) -> FloatArray:
        """Mean positions [n, 3] of the grids of elements, m."""
        index, offset = self.elements.node_index, self.elements.node_offset
        return np.array([self.position_m[index[offset[r] : offset[r + 1]]].mean(axis=0) for r in rows]).reshape(-1, 3)

    @property
    def total_kg(self) -> float:
        return float(self.lumped_kg.sum())


def rows_of(grid_id: IntArray, wanted: IntArray, *, where: str, what: str) -> IntArray:
    """Row of each wanted grid id in the ascending table `grid_id`; `InputError` names those that are missing."""
    rows = np.searchsorted(grid_id, wanted)
    rows[rows == len(grid_id)] = 0
    missing = wanted[grid_id[rows] != wanted]
    if missing.size:
        raise InputError(f"{what} names {missing.size} grids that do not exist: {id_list(missing)}", where=where)
    return np.asarray(rows, dtype=np.int64)


def id_list(ids: Any, most: int = 8) -> str:
    """`1, 2, 3 and 40 more` for messages."""
    ids = [int(i) for i in ids]
    shown = ", ".join(f"{i}" for i in ids[:most])
    return shown + (f" and {len(ids) - most} more" if len(ids) > most else "")


def grids(model: Any, files: list[Path]) -> Grids:
    """Grids of a model that need not be cross-referenced; `InputError`: no grids, no elements, or grids of a fluid."""
    where = str(files[0])
    if not model.nodes or not model.elements:
        raise InputError("holds no grids or no elements", where=where)
    columns = columns_of(model)
    ids = columns.grid.id
    fluid = ids[columns.grid.cd == -1]
    if fluid.size:
        raise InputError(
            f"{len(fluid)} GRID with CD = -1, which hold a pressure and do not move: {id_list(fluid)}",
            where=where,
            hint="leave the fluid out of the deck, or give the grids a frame",
        )
    corners = np.unique(columns.element.without(model.spoints)[1])
    rows = rows_of(ids, corners, where=where, what="an element")
    structural = np.zeros(len(ids), dtype=bool)
    structural[rows] = True
    return Grids(files, ids, structural, np.isin(ids, grids_of_rigid_elements(model, where)))


def model_geometry(model: Any, files: list[Path]) -> ModelGeometry:
    """Turn a cross-referenced pyNastran model into arrays.

    Raises
    ------
    InputError : no grids or no elements, other units than were said, masses that are not read, no mass at all; what
        `refuse_matrices` refuses.
    """
    basic = grids(model, files)
    where, ids = str(files[0]), basic.grid_id
    refuse_matrices(model, where)
    frames = frames_of(model)
    position = grid_positions(model, ids, frames)
    displacement_frame = columns_of(model).grid.cd.astype(np.int64)
    factor = number_parameter(model, "WTMASS", 1.0, where)

    def rows(wanted: IntArray, what: str) -> IntArray:
        return rows_of(ids, wanted, where=where, what=what)

    def to_basic(grid: int, vector: FloatArray) -> FloatArray:
        row = int(np.searchsorted(ids, grid))
        return np.asarray(vector @ basis_at(frames, int(displacement_frame[row]), position[row]))

    def position_of(grid: int) -> FloatArray:
        return np.asarray(position[int(np.searchsorted(ids, grid))])

    elements = model_elements(model, position, rows, to_basic, factor, where)
    concentrated = concentrated_masses(model, frames, factor, where, position_of, rows)
    units = units_of(model)  # until here all is in those
    elements, concentrated = elements_in_si(elements, units), in_si(concentrated, units)
    frames, position = frames_in_si(frames, units), units.length_m * position
    lumped = lumped_masses(len(ids), elements, concentrated)
    check_units(position, elements, float(lumped.sum()), where, units, factor)
    return ModelGeometry(
        files=files,
        grid_id=ids,
        position_m=position,
        displacement_frame=displacement_frame,
        frames=frames,
        elements=elements,
        concentrated=concentrated,
        lumped_kg=lumped,
        units=units,
        structural=basic.structural,
        in_rigid_element=basic.in_rigid_element,
    )


def lumped_masses(grids: int, elements: Elements, concentrated: Concentrated) -> FloatArray:
    """Every element's mass shared equally among its nodes, plus concentrated masses, [N], kg."""
    counts = np.diff(elements.node_offset)
    share = np.repeat(elements.mass_kg / np.maximum(counts, 1), counts)
    out = np.zeros(grids)
    out += np.bincount(elements.node_index, share, grids)
    out += np.bincount(concentrated.node, concentrated.kg, grids)
    return out
