"""What every temperature does to outputs that are linear in the displacements, by one solution for each output.

An output is y = g u, with g nodal forces and moments. With K u = f(T) and f(T) = C (T - T_ref) it is

    K λ = gᵀ,    s = Cᵀ λ,    y = Σ_n s_n (T_n - T_ref)

after the same constraints as any solution. So s holds for all temperature fields at once, and the unit loads of thermal
areas are sums of it. Of shells, bars and rods with temperatures of their own, C has columns for these.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tedm_cli.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False, kw_only=True)
class TemperatureSensitivity:
    """Change of r outputs by the temperatures of N grids, and of L shells, bars and rods that have their own.

    Units are those of the outputs, per kelvin, or per K/m of gradients.

    Attributes
    ----------
    grid : [r, N], of a grid, where all elements take the temperatures of their grids.
    element_id : [L], ascending.
    average : sparse [L, N], the mean temperature of an element's grids, which its own one replaces.
    mean : [r, L], of an element's own mean.
    gradient : [r, L, 2, 2], of its gradients at ends A and B (third index) in planes 1 and 2, see
        `tedm_cli.fem.structure.ElementTemperatures`.
    whole_id : [E], ids of all elements, ascending.
    whole : [r, E], of each of them when all of it warms: its forces times λ. Their sum is that of `grid`, the response
        to 1 K everywhere.
    motion : [6 N, r], the solutions λ, in the frame of the positions; per unit of the output and N or N·m.
    """

    grid: FloatArray
    element_id: IntArray
    average: sp.csr_matrix
    mean: FloatArray
    gradient: FloatArray
    whole_id: IntArray
    whole: FloatArray
    motion: FloatArray

    def felt(self, own: BoolArray) -> FloatArray:
        """The same of grids [r, N] where the elements `own` [L] have temperatures of their own instead of theirs."""
        return np.asarray(self.grid - self.mean[:, own] @ self.average[own])
