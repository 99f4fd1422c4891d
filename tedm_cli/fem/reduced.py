"""The stiffness of a structure after its rigid elements and equations, and which of its motions have any."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.fem.assembly import direct_stiffness
from tedm_cli.fem.autospc import stiff_components
from tedm_cli.fem.constraints import eliminate, to_basic
from tedm_cli.fem.structure import Structure


@dataclass(frozen=True, eq=False)
class ReducedStiffness:
    """Of 6 N degrees of freedom in the displacement frames of the grids.

    matrix : sparse [6 N, 6 N], without those that rigid elements make dependent; supports are not yet applied.
    tied, transform : sparse [6 N, 6 N], to motions of all grids: in their displacement frames, and in the frame of the
        positions.
    dependent, constrained : [.], degrees of freedom of rigid elements, and of single-point constraints, ascending.
    active, measure : those with stiffness, see `stiff_components`.
    """

    matrix: sp.csr_matrix
    tied: sp.csr_matrix
    transform: sp.csr_matrix
    dependent: IntArray
    constrained: IntArray
    active: IntArray
    measure: FloatArray

    @property
    def free(self) -> IntArray:
        """Degrees of freedom to be solved for."""
        return np.setdiff1d(self.active, self.constrained)


def reduced_stiffness(structure: Structure, stiffness: sp.csr_matrix) -> ReducedStiffness:
    """Of the `stiffness` [6 N, 6 N] of the elements, and of that which is given as a matrix.

    Raises `InputError` where rigid elements contradict each other.
    """
    elimination = eliminate(structure)
    transform = to_basic(structure) @ elimination.transform
    matrix = (transform.T @ (stiffness + direct_stiffness(structure)) @ transform).tocsr()
    constrained = np.unique(6 * structure.spc_grid + structure.spc_component - 1)
    active, measure = stiff_components(matrix, elimination.dependent, constrained)
    return ReducedStiffness(
        matrix, elimination.transform, transform, elimination.dependent, constrained, active, measure
    )
