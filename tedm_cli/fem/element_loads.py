"""Forces of shells, bars and rods that have temperatures of their own instead of those of their grids."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import PhysicsError
from tedm_cli.fem.assembly import line_and_shell_matrices
from tedm_cli.fem.structure import ElementTemperatures, Structure

# Of an element: its mean less that of its grids, and gradients at end A in planes 1 and 2, and at end B.
_KINDS = 5


@dataclass(frozen=True, eq=False)
class ElementLoads:
    """Forces that come on top of those of the grids' temperatures; L shells, bars and rods.

    element_id : [L], ascending.
    average : sparse [L, N], the mean temperature of an element's grids.
    coupling : sparse [6 N, 5 L], N/K for means, N per K/m for gradients, of one element after the other.
    """

    element_id: IntArray
    average: sp.csr_matrix
    coupling: sp.csr_matrix

    def own(self, temperature: FloatArray, elements: ElementTemperatures | None) -> FloatArray:
        """What `forces` takes of one load case, [5 L], K and K/m, given its temperatures on the grids [N].

        Raises
        ------
        PhysicsError : elements that are no shells, bars or rods of the structure, by id.
        """
        out = np.zeros((len(self.element_id), _KINDS))
        if elements is None or not len(elements.element_id):
            return out.reshape(-1)
        known = np.isin(elements.element_id, self.element_id)
        if not known.all():
            some = ", ".join(map(str, elements.element_id[~known][:10]))
            raise PhysicsError(f"{(~known).sum()} element(s) with temperatures are no shells, bars or rods: {some}")
        rows = np.searchsorted(self.element_id, elements.element_id)
        out[rows, 0] = elements.mean.mean(axis=1) - (self.average @ temperature)[rows]
        out[rows, 1:] = elements.gradient.reshape(-1, 4)
        return out.reshape(-1)

    def forces(self, own: FloatArray) -> FloatArray:
        """Nodal forces [6 N, m] of m sums [5 L, m] of load cases."""
        return np.asarray(self.coupling @ own)

    def work(self, motion: FloatArray) -> FloatArray:
        """Work of the forces of each of an element's temperatures over m motions [6 N, m], [m, L, 5]."""
        return np.asarray(self.coupling.T @ motion).T.reshape(motion.shape[1], len(self.element_id), _KINDS)


def element_loads(structure: Structure) -> ElementLoads:
    """The loads of all shells, bars and rods of a structure.

    Raises what `assemble` does of them.
    """
    ids, grids, dofs, forces = [], [], [], []
    for element_id, part in line_and_shell_matrices(structure):
        count, size = part.dof.shape
        force = np.zeros((count, size, _KINDS))
        force[..., 0] = part.coupling.sum(axis=2)
        if part.gradient_load is not None and part.gradient_load.shape[2] == 1:
            force[..., 1::2] = 0.5 * part.gradient_load  # both ends of a shell's gradient are the same
        elif part.gradient_load is not None:
            force[..., 1:] = part.gradient_load
        ids.append(element_id)
        grids.append(part.grids)
        dofs.append(part.dof)
        forces.append(force)
    element_id = np.concatenate([np.zeros(0, dtype=np.int64), *ids])
    order = np.argsort(element_id, kind="stable")
    place = np.argsort(order)  # of each element among the ascending ids
    n, total, start = structure.n_grids, len(element_id), 0
    average, coupling = sp.csr_matrix((total, n)), sp.csr_matrix((6 * n, _KINDS * total))
    for grid, dof, force in zip(grids, dofs, forces, strict=True):
        at = place[start : start + len(grid)]
        start += len(grid)
        average += _sparse(np.full(grid.shape, 1.0 / grid.shape[1]), at[:, None], grid, average.shape)
        columns = _KINDS * at[:, None, None] + np.arange(_KINDS)
        coupling += _sparse(force, dof[:, :, None], columns, coupling.shape)
    return ElementLoads(element_id[order], average, coupling)


def _sparse(values: FloatArray, rows: IntArray, columns: IntArray, shape: tuple[int, int]) -> sp.csr_matrix:
    """Matrix of the values that are not zero, at rows and columns that broadcast to their shape."""
    row, column = (np.broadcast_to(index, values.shape)[values != 0.0] for index in (rows, columns))
    return sp.coo_matrix((values[values != 0.0], (row, column)), shape=shape).tocsr()
