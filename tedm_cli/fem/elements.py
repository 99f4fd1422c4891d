"""What the assembly needs of elements, whatever their kind."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray


@dataclass(frozen=True, eq=False, kw_only=True)
class ElementMatrices:
    """Matrices of a run of e elements of one kind with d degrees of freedom and n grids each, basic frame.

    dof : [e, d], degrees of freedom 6 row + component of the structure's grids, in whole triples: the three
        translations of a grid, or its three rotations, next to each other.
    grids : [e, n], rows of the structure's grids, whose temperatures load the elements.
    stiffness : [e, d, d], N/m (rotations: N·m), symmetric.
    coupling : [e, d, n], N/K, nodal forces per kelvin on a grid.
    expansion_load : [e, d], N, nodal forces of an isotropic thermal strain of one.
    reference_temperature : [e], K, at which the element is free of thermal strain.
    gradient_load : [e, d, g], N per K/m, nodal forces of gradients across the elements: of shells g = 1, along the
        normal; of bars g = 4, in plane 1 at end A, in plane 2 at A, and both at B. None where they have no effect.
    """

    dof: IntArray
    grids: IntArray
    stiffness: FloatArray
    coupling: FloatArray
    expansion_load: FloatArray
    reference_temperature: FloatArray
    gradient_load: FloatArray | None = None


def dof_of(grids: IntArray, per_grid: int) -> IntArray:
    """The first `per_grid` degrees of freedom of each of the grids [e, n], grid by grid, [e, n per_grid]."""
    return np.asarray((6 * grids[:, :, None] + np.arange(per_grid)).reshape(len(grids), -1))
