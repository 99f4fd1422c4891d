"""Sparse operators of a whole structure: stiffness K and thermal coupling G, with nodal forces f = G T - f_ref."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tedm_cli.fem.bars import bar_matrices
from tedm_cli.fem.solids import hex_matrices
from tedm_cli.fem.structure import Floats, Ints, Structure


@dataclass(frozen=True, eq=False)
class Operators:
    """Assembled operators over all 6 N degrees of freedom, before any constraint.

    stiffness : sparse [6 N, 6 N], N/m (rotations: N·m).
    coupling : sparse [6 N, N], N/K, nodal forces per kelvin on a grid.
    reference_load : [6 N], N, the coupling's forces at the strain-free temperatures.
    expansion_load : [6 N], N, nodal forces of a thermal strain of one in every element.
    """

    stiffness: sp.csr_matrix
    coupling: sp.csr_matrix
    reference_load: Floats
    expansion_load: Floats

    def load(self, temperature: Floats) -> Floats:
        """Nodal thermal forces [6 N, m] of the temperatures [N, m] in K."""
        return np.asarray(self.coupling @ temperature - self.reference_load[:, None])


def assemble(structure: Structure) -> Operators:
    """Stiffness and thermal coupling of all solids and bars.

    Raises
    ------
    PhysicsError
        From the elements (Jacobian, bar axes), with the element ids.
    """
    size, n_grids = 6 * structure.n_grids, structure.n_grids
    reference, expansion = np.zeros(size), np.zeros(size)
    stiffness = sp.csr_matrix((size, size))
    coupling = sp.csr_matrix((size, n_grids))

    hexes = structure.hexes
    if n_hex := len(hexes.element_id):
        dof = (6 * hexes.connectivity[:, :, None] + np.arange(3)).reshape(-1, 24)
        k, g = np.empty((n_hex, 24, 24)), np.empty((n_hex, 24, 8))
        for part in hex_matrices(structure.position, hexes):
            k[part.elements], g[part.elements] = part.stiffness, part.coupling
            np.add.at(expansion, dof[part.elements], part.expansion_load)
        np.add.at(reference, dof, g.sum(axis=2) * hexes.reference_temperature[:, None])
        stiffness = _scatter(k, dof, dof, (size, size))
        coupling = _scatter(g, dof, hexes.connectivity, (size, n_grids))

    bars = structure.bars
    if len(bars.element_id):
        matrices = bar_matrices(structure.position, bars)
        dof = (6 * bars.connectivity[:, :, None] + np.arange(6)).reshape(-1, 12)
        np.add.at(expansion, dof, matrices.expansion_load)
        np.add.at(reference, dof, matrices.coupling.sum(axis=2) * bars.reference_temperature[:, None])
        stiffness = stiffness + _scatter(matrices.stiffness, dof, dof, (size, size))
        coupling = coupling + _scatter(matrices.coupling, dof, bars.connectivity, (size, n_grids))

    if structure.initial_temperature is not None:
        reference = coupling @ structure.initial_temperature
    return Operators(stiffness, coupling, reference, expansion)


def _scatter(element: Floats, rows: Ints, columns: Ints, shape: tuple[int, int]) -> sp.csr_matrix:
    """Sum element matrices [e, r, c] into a sparse matrix at rows [e, r] and columns [e, c]."""
    row = np.broadcast_to(rows.astype(np.int32)[:, :, None], element.shape).reshape(-1)
    column = np.broadcast_to(columns.astype(np.int32)[:, None, :], element.shape).reshape(-1)
    return sp.csr_matrix((element.reshape(-1), (row, column)), shape=shape)
