"""Sparse operators of a whole structure: stiffness K and thermal coupling G, with nodal forces f = G T - f_ref."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tedm_cli.fem.bars import bar_matrices
from tedm_cli.fem.elements import ElementMatrices
from tedm_cli.fem.rods import rod_matrices
from tedm_cli.fem.shells import shell_matrices
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
    """Stiffness and thermal coupling of all elements.

    Raises
    ------
    PhysicsError
        From the elements (Jacobian, bar axes), with the element ids.
    """
    size, n_grids = 6 * structure.n_grids, structure.n_grids
    reference, expansion = np.zeros(size), np.zeros(size)
    stiffness = sp.csr_matrix((size, size))
    coupling = sp.csr_matrix((size, n_grids))
    for part in _element_matrices(structure):
        np.add.at(expansion, part.dof, part.expansion_load)
        np.add.at(reference, part.dof, part.coupling.sum(axis=2) * part.reference_temperature[:, None])
        stiffness = stiffness + _scatter(part.stiffness, part.dof, part.dof, (size, size))
        coupling = coupling + _scatter(part.coupling, part.dof, part.grids, (size, n_grids))
    if structure.initial_temperature is not None:
        reference = coupling @ structure.initial_temperature
    return Operators(stiffness, coupling, reference, expansion)


def _element_matrices(structure: Structure) -> Iterator[ElementMatrices]:
    yield from hex_matrices(structure.position, structure.hexes)
    if len(structure.bars.element_id):
        yield bar_matrices(structure.position, structure.bars)
    if len(structure.rods.element_id):
        yield rod_matrices(structure.position, structure.rods)
    for shells in (structure.quads, structure.trias):
        yield from shell_matrices(structure.position, shells)


def _scatter(element: Floats, rows: Ints, columns: Ints, shape: tuple[int, int]) -> sp.csr_matrix:
    """Sum element matrices [e, r, c] into a sparse matrix at rows [e, r] and columns [e, c]."""
    row = np.broadcast_to(rows.astype(np.int32)[:, :, None], element.shape).reshape(-1)
    column = np.broadcast_to(columns.astype(np.int32)[:, None, :], element.shape).reshape(-1)
    return sp.csr_matrix((element.reshape(-1), (row, column)), shape=shape)
