"""Motions of the supports: what enforced displacements do to all that is free to move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import PhysicsError
from tedm_cli.fem.constraints import rigid_body_matrix, to_displacement_frames
from tedm_cli.fem.structure import LoadCase, OnFreedoms, Structure

_NOTHING = 1e-12  # of 1 m or 1 rad: rounding of turned frames


@dataclass(frozen=True, eq=False)
class Supports:
    """The S degrees of freedom that single-point constraints hold, in a structure of n unknowns.

    dof : [S], ascending. stiffness : sparse [n, S], forces on the unknowns by motions of the supports.
    transform : sparse [6 N, S], motions of all grids by them, rigid elements included, in the frame of the positions.
    """

    dof: IntArray
    stiffness: sp.csr_matrix
    transform: sp.csr_matrix

    def motions(self, cases: Sequence[LoadCase]) -> FloatArray | None:
        """Enforced motions [S, m] of m load cases, m and rad; None where no case enforces any.

        Raises
        ------
        PhysicsError : a degree of freedom that no constraint holds.
        """
        if all(case.enforced is None for case in cases):
            return None
        out = np.zeros((len(self.dof), len(cases)))
        for column, case in enumerate(cases):
            if case.enforced is not None:
                loose = case.enforced.dof[~np.isin(case.enforced.dof, self.dof)]
                if loose.size:
                    fact = f"load case {case.id} ({case.label}) enforces motions that no constraint holds"
                    raise PhysicsError(fact, hint="hold them by the selected SPC set")
                np.add.at(out[:, column], np.searchsorted(self.dof, case.enforced.dof), case.enforced.value)
        return out


def carried(structure: Structure, rows: IntArray, about: FloatArray, motion: int) -> OnFreedoms:
    """What the constraints of some grids enforce where these move as one rigid body; nothing where they do not hold it.

    Parameters
    ----------
    rows : [M], of the grids. about : [3], m, the point that the motion is of.
    motion : 0 to 5, translations along and rotations about the axes of the frame of the positions, 1 m or 1 rad.
    """
    rigid = rigid_body_matrix(structure.position[rows] - about)
    own = to_displacement_frames(structure.displacement_frame, rows) @ rigid[:, :, motion : motion + 1]
    dof = (6 * rows[:, None] + np.arange(6)).ravel()
    held = np.isin(dof, 6 * structure.spc_grid + structure.spc_component - 1)
    value = own.reshape(-1)
    kept = held & (np.abs(value) > _NOTHING)
    return OnFreedoms(dof[kept], value[kept])
