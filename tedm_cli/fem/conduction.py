"""Conduction of heat through the elements of a mesh: the matrix K_c of steady conduction between its grids.

The weak form of -∇·(k ∇T) = q with the elements' own shape functions (Zienkiewicz & Taylor, The Finite Element Method,
vol. 1, chapter 7), which interpolate temperatures here as they do in the thermal strains:

    K_ij = Σ_e ∫ k ∇N_i · ∇N_j dV

Plates conduct along their mid-surface with k times thickness, lines along their axis with k times section; gradients
of both are those within the surface or along the line. Gauss rules are those of the stiffness of solids, or richer:
exact on undistorted elements, and of full rank but for the constant.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.errors import PhysicsError
from tedm_cli.fem.shapes import CARDS, PYRAMID_AS_BRICK, Shape, gauss_rule, measure, shape_of

_ENTRIES = 4_000_000  # of the gradients held at a time


@dataclass(frozen=True, eq=False, kw_only=True)
class ConductingMesh:
    """E elements and the grids that they conduct between.

    position : [N, 3], m.
    element_id : [E]. card : [E], Nastran's names.
    node_offset, node_index : ragged connectivity, [E + 1] and [M] rows of `position`.
    section : [E], thickness of plates (m), cross-section of lines (m²); of solids without meaning.
    conductivity : [E], W/(m K); 0 of those that do not conduct.
    """

    position: FloatArray
    element_id: IntArray
    card: NDArray[np.str_]
    node_offset: IntArray
    node_index: IntArray
    section: FloatArray
    conductivity: FloatArray

    @property
    def conducting(self) -> BoolArray:
        """[E]."""
        return np.asarray(self.conductivity > 0.0)


def has_conduction(card: str, nodes: int) -> bool:
    """Whether a card with so many nodes has a volume to conduct through."""
    return card == "CPYRAM" or shape_of(card, nodes) is not None


def conduction_matrix(mesh: ConductingMesh) -> sp.csr_matrix:
    """The conduction matrix K_c [N, N], W/K: symmetric, positive semidefinite, its rows sum to zero.

    Raises
    ------
    PhysicsError : conducting elements that are tangled or have no extent; ids are listed.
    """
    n = len(mesh.position)
    out = sp.csr_matrix((n, n))
    for shape, rows, at in _groups(mesh):
        parts = [_matrices(mesh, shape, rows[part], at[part]) for part in _slices(shape, len(rows))]
        values = np.concatenate(parts)
        row, column = (np.broadcast_to(index, values.shape).ravel() for index in (at[:, :, None], at[:, None, :]))
        out = out + sp.coo_matrix((values.ravel(), (row, column)), shape=(n, n)).tocsr()
    return out


def conducting_links(n: int, first: IntArray, second: IntArray, conductance: FloatArray) -> sp.csr_matrix:
    """Matrix [n, n] of conductances (W/K) [L] between pairs of grids, as that of the elements."""
    values = np.concatenate([conductance, conductance, -conductance, -conductance])
    row, column = np.concatenate([first, second, first, second]), np.concatenate([first, second, second, first])
    return sp.coo_matrix((values, (row, column)), shape=(n, n)).tocsr()


def _groups(mesh: ConductingMesh) -> Iterator[tuple[Shape, IntArray, IntArray]]:
    """Conducting elements of one shape each: the shape, their rows [e], and rows of their grids [e, n]."""
    counts = np.diff(mesh.node_offset)
    for card in np.unique(mesh.card[mesh.conducting]).tolist():
        of_card = mesh.conducting & (mesh.card == card)
        for count in np.unique(counts[of_card]).tolist():
            rows = np.flatnonzero(of_card & (counts == count))
            at = mesh.node_index[mesh.node_offset[rows][:, None] + np.arange(count)]
            if card == "CPYRAM":
                yield CARDS["CHEXA"][0], rows, at[:, PYRAMID_AS_BRICK]
                continue
            shape = shape_of(card, count)
            assert shape is not None, f"{card} of {count} nodes"
            yield shape, rows, at


def _rule(shape: Shape) -> tuple[FloatArray, FloatArray]:
    """Integration points ξ [q, d] and weights [q]."""
    points, weights = gauss_rule((3 if shape.edges else 2,) * shape.dimension, shape.collapse)
    return shape.to_element(points), weights


def _slices(shape: Shape, count: int) -> Iterator[slice]:
    size = max(1, _ENTRIES // (3 * shape.nodes * len(_rule(shape)[1])))
    for start in range(0, count, size):
        yield slice(start, start + size)


def _matrices(mesh: ConductingMesh, shape: Shape, rows: IntArray, at: IntArray) -> FloatArray:
    """Matrices [e, n, n] of elements of one shape, W/K."""
    points, weights = _rule(shape)
    _, slopes = shape.functions(points)
    jacobian = np.swapaxes(slopes, -1, -2) @ mesh.position[at][:, None]  # [e, q, d, 3] = ∂x/∂ξ
    size = measure(jacobian)
    _refuse_degenerate(size, jacobian, mesh.element_id[rows])
    # the gradient within the element's own line, surface or volume: Jᵀ (J Jᵀ)⁻¹ ∂N/∂ξ
    metric = np.linalg.inv(jacobian @ np.swapaxes(jacobian, -1, -2))
    gradient = slopes @ metric @ jacobian  # [e, q, n, 3]
    per_volume = mesh.conductivity[rows] * (mesh.section[rows] if shape.dimension < 3 else 1.0)
    weighted = gradient * (np.abs(size) * weights * per_volume[:, None])[..., None, None]
    e, q, n, _ = gradient.shape
    flat = np.moveaxis(gradient, 2, 1).reshape(e, n, 3 * q)
    matrix = flat @ np.moveaxis(weighted, 2, 1).reshape(e, n, 3 * q).swapaxes(1, 2)
    return np.asarray(0.5 * (matrix + matrix.swapaxes(1, 2)))


def _refuse_degenerate(size: FloatArray, jacobian: FloatArray, element_id: IntArray) -> None:
    """Elements whose measure [e, q] changes its sign, or is nothing beside the lengths of their edges."""
    dimension = jacobian.shape[-2]
    scale = np.sqrt((jacobian**2).sum(axis=(-1, -2)) / dimension) ** dimension
    sound = (np.abs(size) > 1e-9 * scale).all(axis=1) & ((size > 0.0).all(axis=1) | (size < 0.0).all(axis=1))
    bad = element_id[~sound]
    if bad.size:
        some = _some(bad.tolist())
        raise PhysicsError(
            f"{bad.size} conducting element(s) that are tangled or have no extent: {some}",
            hint="are the grids of the cards in order, and at different places?",
        )


def _some(ids: Sequence[int]) -> str:
    return ", ".join(map(str, ids[:10])) + (" ..." if len(ids) > 10 else "")
