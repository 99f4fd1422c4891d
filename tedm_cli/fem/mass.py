"""The mass matrix of elements and concentrated masses, in the frame of the positions.

Solids have the consistent matrix, ∫ ρ Nᵢ Nⱼ dV with their shape functions. Plates and lines are lumped: each grid has
an equal share (weighted by the density there), which hangs on the grid by the rigid arm of an offset. MYSTRAN does the
same; other Nastrans lump solids as well unless PARAM,COUPMASS is set. Rotations have inertia by arms and by the inertia
of concentrated masses alone: bars and plates have none about their own middle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.fem.constraints import rigid_body_matrix
from tedm_cli.fem.measure import blocks, whole_rule
from tedm_cli.fem.shapes import Shape


@dataclass(frozen=True, eq=False, kw_only=True)
class MassBlock:
    """Elements of one shape with E elements of n nodes.

    shape : of solids; None of all others, whose grids have equal shares.
    connectivity : [E, n], rows of the grids. mass : [E], kg.
    weight : [E, n], density at the nodes over its mean. lever : [E, n, 3], m, from the grids to the mass.
    """

    shape: Shape | None
    connectivity: IntArray
    mass: FloatArray
    weight: FloatArray
    lever: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class PointInertia:
    """Concentrated masses: rows [C] of their grids, kg [C], levers [C, 3] (m) and inertia [C, 3, 3] (kg m²) about their
    centres of gravity."""

    node: IntArray
    mass: FloatArray
    lever: FloatArray
    inertia: FloatArray


def mass_matrix(position: FloatArray, elements: Sequence[MassBlock], points: PointInertia) -> sp.csr_matrix:
    """Sparse [6 N, 6 N], kg (rotations: kg m²), of grids at `position` [N, 3] m.

    What hangs on a grid by a lever l moves by u + theta x l.
    """
    grids = len(position)
    node, kg, lever, inertia = [points.node], [points.mass], [points.lever], [points.inertia]
    spread = sp.csr_matrix((grids, grids))
    for block in elements:
        if block.shape is not None:
            spread += _consistent(position, block, block.shape)
            continue
        share = block.mass[:, None] * block.weight / block.weight.sum(axis=1, keepdims=True)
        node.append(block.connectivity.ravel())
        kg.append(share.ravel())
        lever.append(block.lever.reshape(-1, 3))
        inertia.append(np.zeros((share.size, 3, 3)))
    hung = _hung(np.concatenate(node), np.concatenate(kg), np.concatenate(lever), np.concatenate(inertia), 6 * grids)
    entries = spread.tocoo()
    row, column = (6 * index.astype(np.int64)[:, None] + np.arange(3) for index in (entries.row, entries.col))
    alike = np.repeat(entries.data, 3)
    return hung + sp.csr_matrix((alike, (row.ravel(), column.ravel())), shape=hung.shape)


def weight_per_acceleration(mass: sp.csr_matrix) -> FloatArray:
    """Forces and moments [6 N, 3] on the grids per m/s² along the three axes."""
    along = np.tile(np.eye(6)[:, :3], (mass.shape[0] // 6, 1))
    return np.asarray(mass @ along)


def _consistent(position: FloatArray, block: MassBlock, shape: Shape) -> sp.csr_matrix:
    """Sparse [N, N] of solids, kg, the same in all three directions."""
    total = sp.csr_matrix((len(position), len(position)))
    for part in blocks(len(block.mass)):
        at = block.connectivity[part]
        values, measure = whole_rule(shape, position[at])
        density = measure * (block.weight[part] @ values.T)
        density *= (block.mass[part] / density.sum(axis=1))[:, None]
        shared = np.einsum("eq,qi,qj->eij", density, values, values, optimize=True)
        rows, columns = (np.broadcast_to(index, shared.shape).ravel() for index in (at[:, :, None], at[:, None, :]))
        total += sp.csr_matrix((shared.ravel(), (rows, columns)), shape=total.shape)
    return total


def _hung(node: IntArray, kg: FloatArray, lever: FloatArray, inertia: FloatArray, size: int) -> sp.csr_matrix:
    """Sparse of bodies on arms from grids; entries that are zero are left out."""
    arm = rigid_body_matrix(lever)[:, :3]
    matrix = arm.transpose(0, 2, 1) @ (kg[:, None, None] * arm)
    matrix[:, 3:, 3:] += inertia
    kept = np.nonzero(matrix)
    first = 6 * node[kept[0]]
    return sp.csr_matrix((matrix[kept], (first + kept[1], first + kept[2])), shape=(size, size))
