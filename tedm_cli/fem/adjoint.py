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
from tedm_cli.fem.assembly import assemble, element_ids
from tedm_cli.fem.element_loads import ElementLoads, element_loads
from tedm_cli.fem.structure import Structure


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


@dataclass(frozen=True, eq=False)
class ThermalForces:
    """C: nodal forces of all temperatures of a structure, whoever solves it.

    coupling : sparse [6 N, N], N/K, of grids. loads : of elements with temperatures of their own. warming : sparse
    [E, 6 N], N/K, of each whole element in the order of `ids` [E].
    """

    coupling: sp.csr_matrix
    loads: ElementLoads
    warming: sp.csr_matrix
    ids: IntArray

    @classmethod
    def of(cls, structure: Structure, coupling: sp.csr_matrix, warming: sp.csr_matrix) -> ThermalForces:
        """Of a structure whose operators are assembled."""
        return cls(coupling, element_loads(structure), warming, element_ids(structure))

    @classmethod
    def assembled(cls, structure: Structure) -> ThermalForces:
        """Of a structure; `PhysicsError` from its elements, with their ids."""
        operators = assemble(structure)
        return cls.of(structure, operators.thermal.coupling, operators.warming)

    def sensitivity(self, motion: FloatArray) -> TemperatureSensitivity:
        """s = Cᵀ λ of r solutions [6 N, r]."""
        rows, order = motion.shape[1], np.argsort(self.ids, kind="stable")
        of_elements = self.loads.work(motion)
        return TemperatureSensitivity(
            grid=np.asarray((self.coupling.T @ motion).T),
            element_id=self.loads.element_id,
            average=self.loads.average,
            mean=of_elements[..., 0],
            gradient=of_elements[..., 1:].reshape(rows, len(self.loads.element_id), 2, 2),
            whole_id=self.ids[order],
            whole=np.asarray((self.warming @ motion).T[:, order]),
            motion=motion,
        )
