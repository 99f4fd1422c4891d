"""Which motions of the grids have stiffness (Nastran removes the others by AUTOSPC)."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from tedm_cli.arrays import FloatArray, IntArray

# A stiffness below this share of the largest of its grid's translations (or rotations) holds nothing.
_ZERO_STIFFNESS = 1e-12


def stiff_components(
    stiffness: sp.csr_matrix, dependent: IntArray, constrained: IntArray
) -> tuple[IntArray, FloatArray]:
    """Degrees of freedom with stiffness.

    The three translations of a grid, and its three rotations, are eliminated with pivots from their own 3 x 3 block of
    the stiffness, unconstrained components first; those without a pivot are left out. Where a direction without
    stiffness is along no axis that is one component of it: a positive semi-definite matrix is singular where one of its
    diagonal blocks is, so that nothing is held by leaving it out.

    Parameters
    ----------
    stiffness : sparse [6 N, 6 N], with rigid elements eliminated and supports not yet applied.
    dependent, constrained : degrees of freedom of rigid elements, and of single-point constraints.

    Returns
    -------
    active : degrees of freedom with a pivot, constrained ones included if what they hold has stiffness.
    measure : [6 N, 3], what an active degree of freedom stands for: the sum over the components of its triple that is
        zero for motions without stiffness and for those that the pivots before it account for.
    """
    size = stiffness.shape[0]
    entries = stiffness.tocoo()
    near = entries.row // 3 == entries.col // 3
    block = np.zeros((size // 3, 3, 3))
    block[entries.row[near] // 3, entries.row[near] % 3, entries.col[near] % 3] = entries.data[near]
    taken, last = np.zeros(size, dtype=bool), np.zeros(size, dtype=bool)
    taken[dependent], last[constrained] = True, True
    taken, last = taken.reshape(-1, 3), last.reshape(-1, 3)
    block[taken[:, :, None] | taken[:, None, :]] = 0.0
    least = _ZERO_STIFFNESS * np.diagonal(block, axis1=1, axis2=2).max(axis=1)
    measure, active = np.zeros((size // 3, 3, 3)), np.zeros((size // 3, 3), dtype=bool)
    every = np.arange(len(block))
    for late in (False, True):
        for _ in range(3):
            left = np.where(active | (last != late), 0.0, np.diagonal(block, axis1=1, axis2=2))
            pivot = left.argmax(axis=1)
            good = left[every, pivot] > least
            rows, columns = every[good], pivot[good]
            active[rows, columns] = True
            row = block[rows, columns] / block[rows, columns, columns][:, None]
            measure[rows, columns] = row
            block[rows] -= block[rows, columns][:, :, None] * row[:, None, :]
    return np.flatnonzero(active.reshape(-1)), measure.reshape(-1, 3)
