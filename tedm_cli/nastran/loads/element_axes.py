"""Directions in which the gradients of elements count: the normals of shells, the section axes of bars."""

from __future__ import annotations

from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.loads.element_temperatures import SHELLS
from tedm_cli.nastran.masses.lines import line_frame
from tedm_cli.nastran.positions import Frames, basis_at

BENDING_LINES = ("CBAR", "CBEAM")


def gradient_axes(model: Any, grid_id: IntArray, position: FloatArray, frames: Frames, where: str) -> FloatArray:
    """Axes [E, 2, 3] (basic frame) of the elements of a cross-referenced model in ascending order of their ids.

    Of a shell its unit normal, by the right hand along its grids, and 0; of a CBAR or CBEAM y and z of its element
    frame, in planes 1 and 2 (MSC Nastran Quick Reference Guide, TEMPP1, TEMPRB); NaN of others, which do not bend.

    Parameters
    ----------
    grid_id, position : [N] ascending, [N, 3]. where : for messages.
    """

    def to_basic(grid: int, vector: FloatArray) -> FloatArray:
        row = int(np.searchsorted(grid_id, grid))
        return np.asarray(vector @ basis_at(frames, int(model.nodes[grid].Cd()), position[row]))

    columns = columns_of(model).element
    out = np.full((len(columns.id), 2, 3), np.nan)
    for row in np.flatnonzero(columns.is_of((*SHELLS, *BENDING_LINES))).tolist():
        card, nodes = str(columns.cards[columns.kind[row]]), columns.node_id[columns.node_offset[row] :]
        if card in SHELLS:
            corners = position[np.searchsorted(grid_id, nodes[: 3 if "TRIA" in card else 4])]
            normal = np.cross(corners[2] - corners[0], corners[-1] - corners[1])
            out[row] = [normal / np.linalg.norm(normal), np.zeros(3)]
        else:
            element = model.elements[int(columns.id[row])]
            ends = position[np.searchsorted(grid_id, element.node_ids)]
            out[row] = line_frame(element, ends, to_basic, where)[1:]
    return out
