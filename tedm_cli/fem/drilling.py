"""Does the drilling stiffness of shells decide the displacements?

A flat shell has no stiffness of its own about its normal. The weight that ties this rotation to the mid-surface
(Nastran's K6ROT) is a number without physics: where bars, rigid arms or folds pass moments about the normal into a
shell, the results follow it. Another weight shows by how much.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.fem.factors import Factorisation
from tedm_cli.fem.other_elements import RandomSums, displacements_with
from tedm_cli.fem.structure import Structure

DRILLING_FACTOR = 100.0
"""The other weight over the deck's: between them lie the values that Nastran's defaults and its manuals recommend."""
DECISIVE = 1e-3
"""Relative change from which on the stiffness has a part in the results."""
_ALIKE = 1e-4  # changes this near are one: what the solver leaves must not choose between grids of a symmetric model
_TOLERANCE = 1e-7  # the tie holds little of a structure's energy, however far it turns a mirror


@dataclass(frozen=True)
class DrillingChange:
    """Largest change of a translation and of a rotation of any grid, over the largest of the changed ones.

    moves, turns : ids of the grids with these changes. grid_id, turn : [N], the change of the rotation of each grid,
    over the largest rotation.
    """

    translation: float
    rotation: float
    moves: int
    turns: int
    grid_id: IntArray
    turn: FloatArray


def drilling_change(
    structure: Structure, transform: sp.csr_matrix, factors: Factorisation, sums: RandomSums
) -> DrillingChange | None:
    """Change of the displacements if the drilling stiffness of all shells were a hundred times as large.

    Parameters as of `displacements_with`.

    Returns
    -------
    None where there are no shells, or none with a drilling stiffness.
    """
    blocks = (structure.quads, structure.trias)
    if not any(block.drilling_stiffness.any() for block in blocks):
        return None
    quads, trias = (replace(b, drilling_stiffness=DRILLING_FACTOR * b.drilling_stiffness) for b in blocks)
    stiffer = replace(structure, quads=quads, trias=trias)
    before, after = displacements_with(stiffer, transform, factors, sums, _TOLERANCE)
    motion, turn = (
        np.abs(after[k::2] - before[k::2]).max(axis=(1, 2)) / (np.abs(after[k::2]).max() or 1.0) for k in (0, 1)
    )
    ids = structure.grid_id
    return DrillingChange(
        translation=float(motion.max()),
        rotation=float(turn.max()),
        moves=int(ids[_first_largest(motion)]),
        turns=int(ids[_first_largest(turn)]),
        grid_id=ids,
        turn=turn,
    )


def _first_largest(change: FloatArray) -> int:
    """Place of the first of the largest changes [N]."""
    return int(np.argmax(change >= (1.0 - _ALIKE) * change.max()))
