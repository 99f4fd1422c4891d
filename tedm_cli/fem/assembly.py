"""Sparse operators of a whole structure: stiffness K and thermal coupling G, with nodal forces f = G T - f_ref."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.fem.bars import bar_matrices
from tedm_cli.fem.constraints import to_basic
from tedm_cli.fem.elements import ElementMatrices
from tedm_cli.fem.rods import rod_matrices
from tedm_cli.fem.shells import shell_matrices
from tedm_cli.fem.solids import solid_matrices
from tedm_cli.fem.structure import Structure


@dataclass(frozen=True, eq=False)
class ThermalLoad:
    """Nodal forces of temperatures.

    coupling : sparse [6 N, N], N/K, nodal forces per kelvin on a grid.
    origin : K, from which temperatures are counted: the forces of 0.02 K are not the difference of those of 293.02 and
        293 K, which are thousands of times larger.
    reference : [6 N], N, the coupling's forces at the strain-free temperatures less the origin.
    """

    coupling: sp.csr_matrix
    origin: float
    reference: FloatArray

    def forces(self, temperature: FloatArray, amount: FloatArray | float = 1.0) -> FloatArray:
        """Nodal forces [6 N, m] of m sums of temperatures [N, m] in K.

        `amount` [m] tells how often the strain-free temperatures are to be taken off: once for the temperatures of one
        load case.
        """
        return np.asarray(self.coupling @ (temperature - self.origin * amount) - self.reference[:, None] * amount)


@dataclass(frozen=True, eq=False)
class Operators:
    """Assembled operators over all 6 N degrees of freedom, before any constraint.

    stiffness : sparse [6 N, 6 N], N/m (rotations: N·m).
    thermal : forces of temperatures.
    expansion_load : [6 N], N, nodal forces of a thermal strain of one in every element.
    warming : sparse [E, 6 N], N/K, nodal forces of each element when all of it warms, in the order of `element_ids`.
    """

    stiffness: sp.csr_matrix
    thermal: ThermalLoad
    expansion_load: FloatArray
    warming: sp.csr_matrix


def assemble(structure: Structure) -> Operators:
    """Stiffness and thermal coupling of all elements.

    Raises
    ------
    PhysicsError
        From the elements (Jacobian, bar axes), with the element ids.
    """
    n_grids = structure.n_grids
    reference, expansion = np.zeros(6 * n_grids), np.zeros(6 * n_grids)
    origin = _origin(structure)
    stiffness = _BlockSum((2 * n_grids, 2 * n_grids), (3, 3))
    coupling = _BlockSum((2 * n_grids, n_grids), (3, 1))
    warming = [sp.csr_matrix((0, 6 * n_grids))]
    for part in _element_matrices(structure):
        np.add.at(expansion, part.dof, part.expansion_load)
        force = part.coupling.sum(axis=2)
        np.add.at(reference, part.dof, force * (part.reference_temperature - origin)[:, None])
        first = np.arange(len(force) + 1) * force.shape[1]
        warming.append(sp.csr_matrix((force.reshape(-1), part.dof.reshape(-1), first), (len(force), 6 * n_grids)))
        triples = part.dof[:, ::3] // 3
        stiffness.add(part.stiffness, triples, triples)
        coupling.add(part.coupling, triples, part.grids)
    total = coupling.matrix()
    if structure.initial_temperature is not None:
        reference = total @ (structure.initial_temperature - origin)
    thermal = ThermalLoad(total, origin, reference)
    return Operators(stiffness.matrix(), thermal, expansion, sp.vstack(warming, format="csr"))


def direct_stiffness(structure: Structure) -> sp.csr_matrix:
    """The stiffness that is given as a matrix, sparse [6 N, 6 N], in the frame of the positions."""
    dof, matrix = structure.direct.dof, sp.coo_matrix(structure.direct.matrix)
    whole = sp.csr_matrix((matrix.data, (dof[matrix.row], dof[matrix.col])), shape=(6 * structure.n_grids,) * 2)
    basic = to_basic(structure)
    return (basic @ whole @ basic.T).tocsr()


def element_ids(structure: Structure) -> IntArray:
    """Ids of all elements [E], in the order in which they are assembled."""
    others = (
        structure.bars.element_id,
        structure.rods.element_id,
        structure.quads.element_id,
        structure.trias.element_id,
    )
    return np.concatenate([*(block.element_id for block in structure.solids), *others])


def _origin(structure: Structure) -> float:
    """The strain-free temperature of most elements, or of most grids where they have an initial one."""
    shells = (structure.quads.reference_temperature, structure.trias.reference_temperature)
    free = [b.materials.reference_temperature[b.material] for b in structure.solids]
    free += [structure.bars.reference_temperature, structure.rods.reference_temperature, *shells]
    start = structure.initial_temperature
    value, count = np.unique(np.concatenate(free) if start is None else start, return_counts=True)
    return float(value[count.argmax()]) if value.size else 0.0


def _element_matrices(structure: Structure) -> Iterator[ElementMatrices]:
    for block in structure.solids:
        yield from solid_matrices(structure.position, block)
    for _, part in line_and_shell_matrices(structure):
        yield part


def line_and_shell_matrices(structure: Structure) -> Iterator[tuple[IntArray, ElementMatrices]]:
    """Bars, rods and shells, some thousand at a time, with their ids."""
    if len(structure.bars.element_id):
        yield structure.bars.element_id, bar_matrices(structure.position, structure.bars)
    if len(structure.rods.element_id):
        yield structure.rods.element_id, rod_matrices(structure.position, structure.rods)
    for shells in (structure.quads, structure.trias):
        start = 0
        for part in shell_matrices(structure.position, shells):
            yield shells.element_id[start : start + len(part.dof)], part
            start += len(part.dof)


class _BlockSum:
    """A sparse matrix of dense blocks as a sum of parts.

    Blocks of three by three need a ninth of the indices of single entries. Partial sums of like size are added, as in a
    binary counter, so that every block is copied only log(parts) times and at most twice the result is held.
    """

    def __init__(self, blocks: tuple[int, int], size: tuple[int, int]) -> None:
        self._blocks, self._size = blocks, size
        self._shape = (blocks[0] * size[0], blocks[1] * size[1])
        self._parts: list[sp.bsr_matrix] = []

    def add(self, element: FloatArray, rows: IntArray, columns: IntArray) -> None:
        """Add element matrices [e, r · height, c · width] at block rows [e, r] and block columns [e, c]."""
        (height, width), (e, r), c = self._size, rows.shape, columns.shape[1]
        key = (rows[:, :, None] * self._blocks[1] + columns[:, None, :]).reshape(-1)
        order = np.argsort(key, kind="stable")
        key = key[order]
        first = np.flatnonzero(np.diff(key, prepend=-1))
        blocks = element.reshape(e, r, height, c, width).transpose(0, 1, 3, 2, 4).reshape(-1, height, width)
        data = np.add.reduceat(blocks[order], first, axis=0)
        row, column = np.divmod(key[first], self._blocks[1])
        pointer = np.searchsorted(row, np.arange(self._blocks[0] + 1))
        part = sp.bsr_matrix((data, column.astype(np.int32), pointer.astype(np.int32)), shape=self._shape)
        while self._parts and self._parts[-1].data.size <= 2 * part.data.size:
            part = self._parts.pop() + part
        self._parts.append(part)

    def matrix(self) -> sp.csr_matrix:
        """The sum; nothing is left to add to."""
        total = sp.bsr_matrix(self._shape, blocksize=self._size)
        while self._parts:
            total = self._parts.pop() + total
        return total.tocsr()
