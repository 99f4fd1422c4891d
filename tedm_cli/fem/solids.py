"""Stiffness and thermal coupling of isoparametric solids: hexahedra, pentahedra, tetrahedra, linear and quadratic.

Displacements and temperature share the shape functions, as in Nastran (Zienkiewicz & Taylor, The Finite Element Method,
vol. 1, chapters 6 and 9). Gauss rules: hexahedra 2x2x2 (linear) and 3x3x3 (quadratic); pentahedra the same number over
the collapsed triangle and the height; tetrahedra one point (linear) and 2x2x2 collapsed (quadratic). They integrate
stiffness and coupling of undistorted elements exactly.

Linear hexahedra and pentahedra may have incompatible modes q, nine or twelve internal degrees of freedom that bend:
1 - ξ², 1 - η², 1 - ζ² (Wilson et al. 1973), and for pentahedra the products of two area coordinates and 1 - ζ². Their
gradients are taken with the Jacobian at the centre and have mean zero over the element, so that constant strains are
carried exactly whatever the distortion (Taylor, Beresford & Wilson, Int. J. Num. Meth. Eng. 10, 1976). They carry their
share of the thermal load and are condensed out of every element.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import PhysicsError
from tedm_cli.fem.elasticity import ISOTROPIC, PAIRS
from tedm_cli.fem.elements import ElementMatrices, dof_of
from tedm_cli.fem.shapes import Shape, gauss_rule, shape_of
from tedm_cli.fem.structure import SolidBlock

_ENTRIES = 4_000_000  # of the strain matrices held at a time


@dataclass(frozen=True, eq=False)
class SolidRun:
    """What integrals over e elements of a block need, at q Gauss points of n nodes and k incompatible modes.

    elements : their rows of the block.
    functions : [q, n], shape functions.
    weight : [e, q], m³.
    strain : [e, q, 6, 3 n], 1/m, strains by the nodes' displacements.
    mode_strain : [e, q, 6, 3 k], strains by the modes.
    stiffness : [e, 6, 6], Pa.
    expansion : [e, 6], 1/K.
    """

    elements: slice
    functions: FloatArray
    weight: FloatArray
    strain: FloatArray
    mode_strain: FloatArray
    stiffness: FloatArray
    expansion: FloatArray

    def coupled(self, thermal: FloatArray, functions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Loads [e, 3 n, m] on nodes and [e, 3 k, m] on modes by a thermal strain [e, 6] times functions [q, m]."""
        stress = np.matmul(self.stiffness, thermal[:, :, None])[:, None]

        def work(strain: FloatArray) -> FloatArray:
            power = np.matmul(strain.swapaxes(2, 3), stress)[..., 0] * self.weight[..., None]
            return np.asarray(np.matmul(power.swapaxes(1, 2), functions))

        return work(self.strain), work(self.mode_strain)

    def mode_stiffness(self) -> tuple[FloatArray, FloatArray]:
        """Stiffness [e, 3 k, 3 k] of the modes and [e, 3 k, 3 n] between modes and nodes."""
        weighted = self._flat(np.matmul(self.stiffness[:, None], self.mode_strain) * self.weight[..., None, None])
        left = weighted.swapaxes(1, 2)
        return np.matmul(left, self._flat(self.mode_strain)), np.matmul(left, self._flat(self.strain))

    def node_stiffness(self) -> FloatArray:
        """Stiffness [e, 3 n, 3 n] of the nodes, modes held."""
        weighted = self._flat(np.matmul(self.stiffness[:, None], self.strain) * self.weight[..., None, None])
        return np.asarray(np.matmul(weighted.swapaxes(1, 2), self._flat(self.strain)))

    @staticmethod
    def _flat(matrix: FloatArray) -> FloatArray:
        return matrix.reshape(len(matrix), -1, matrix.shape[3])


def block_shape(block: SolidBlock) -> Shape:
    """The isoparametric shape of a block's elements."""
    shape = shape_of(block.card, block.connectivity.shape[1])
    assert shape is not None, block.card
    return shape


def solid_matrices(position: FloatArray, block: SolidBlock) -> Iterator[ElementMatrices]:
    """Element matrices of `block`, some thousand elements at a time.

    Parameters
    ----------
    position : [N, 3], m.
    block : the elements.

    Raises
    ------
    PhysicsError
        If an element's Jacobian is not positive at every integration point; the message lists element ids.
    """
    for run in solid_runs(position, block):
        stiffness = run.node_stiffness()
        coupling, mode_coupling = run.coupled(run.expansion, run.functions)
        expansion, _ = run.coupled(np.broadcast_to(ISOTROPIC, run.expansion.shape), np.ones((len(run.functions), 1)))
        if run.mode_strain.shape[3]:
            modes, cross = run.mode_stiffness()
            # Uniform thermal strain does no work on the modes, whose strains have mean zero: no term in `expansion`.
            softened = np.matmul(cross.swapaxes(1, 2), definite_inverse(modes))
            stiffness -= np.matmul(softened, cross)
            coupling -= np.matmul(softened, mode_coupling)
        grids = block.connectivity[run.elements]
        yield ElementMatrices(
            dof=dof_of(grids, 3),
            grids=grids,
            stiffness=0.5 * (stiffness + stiffness.swapaxes(1, 2)),
            coupling=coupling,
            expansion_load=expansion[..., 0],
            reference_temperature=block.materials.reference_temperature[block.material[run.elements]],
        )


def solid_runs(position: FloatArray, block: SolidBlock) -> Iterator[SolidRun]:
    """Strain matrices of `block`, some thousand elements at a time; raises as `solid_matrices`."""
    shape = block_shape(block)
    xi, weights = gauss_points(shape)
    functions, slopes = shape.functions(xi)
    modes = _mode_slopes(shape, xi, weights) if block.bubble and not shape.edges else np.zeros((len(xi), 0, 3))
    centre_slopes = shape.functions(_centre(shape)[None])[1][0]
    size = max(1, _ENTRIES // (18 * len(xi) * shape.nodes))
    for start in range(0, len(block.element_id), size):
        elements = slice(start, min(start + size, len(block.element_id)))
        nodes = position[block.connectivity[elements]]
        jacobian = np.matmul(slopes.swapaxes(1, 2), nodes[:, None])  # [e, q, d, 3] = ∂x/∂ξ
        determinant, cofactors = _cofactors(jacobian)
        centre_determinant, centre_cofactors = _cofactors(np.matmul(centre_slopes.T, nodes))
        _require_positive(np.column_stack([determinant, centre_determinant]), block.element_id[elements])
        # (j0 / j) J0⁻ᵀ, with J0⁻ᵀ the cofactors over j0
        mode_gradient = np.matmul(modes, centre_cofactors[:, None]) / determinant[..., None, None]
        material = block.material[elements]
        yield SolidRun(
            elements=elements,
            functions=functions,
            weight=determinant * weights,
            strain=_strain(np.matmul(slopes, cofactors) / determinant[..., None, None]),
            mode_strain=_strain(mode_gradient),
            stiffness=block.materials.stiffness[material],
            expansion=block.materials.expansion[material],
        )


def gauss_points(shape: Shape) -> tuple[FloatArray, FloatArray]:
    """Integration points ξ [q, 3] of a solid and their weights [q]."""
    count = 3 if shape.edges else 2
    if shape.family == "tetrahedron":
        count -= 1
    points, weights = gauss_rule((count,) * 3, shape.collapse)
    return shape.to_element(points), weights


def _centre(shape: Shape) -> FloatArray:
    return np.asarray(shape.reference_nodes()[: shape.corners].mean(axis=0))


def _mode_slopes(shape: Shape, xi: FloatArray, weights: FloatArray) -> FloatArray:
    """Derivatives [q, k, 3] of the incompatible modes by ξ, with mean zero over the reference element."""
    if shape.family == "tetrahedron":
        return np.zeros((len(xi), 0, 3))
    if shape.family == "hexahedron":
        slopes = np.zeros((len(xi), 3, 3))
        for axis in range(3):
            slopes[:, axis, axis] = 4.0 - 8.0 * xi[:, axis]  # of 4 t (1 - t)
    else:
        slopes = np.zeros((len(xi), 4, 3))
        area = np.column_stack([1.0 - xi[:, 0] - xi[:, 1], xi[:, :2]])
        gradient = np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
        for mode, (a, b) in enumerate(((0, 1), (1, 2), (2, 0))):
            slopes[:, mode, :2] = 4.0 * (area[:, a, None] * gradient[b] + area[:, b, None] * gradient[a])
        slopes[:, 3, 2] = 4.0 - 8.0 * xi[:, 2]
    return np.asarray(slopes - np.einsum("q,qkd->kd", weights / weights.sum(), slopes))


def definite_inverse(matrix: FloatArray) -> FloatArray:
    """Inverses of positive definite matrices [e, m, m], m small, by Gauss-Jordan elimination of all at once.

    LAPACK, called once per small matrix, spends its time on starting and stopping threads.
    """
    work = np.ascontiguousarray(np.moveaxis(matrix, 0, 2))
    for k in range(len(work)):
        pivot = 1.0 / work[k, k]
        row = work[k] * pivot
        column = work[:, k].copy()
        column[k] = 0.0
        work -= column[:, None] * row[None]
        work[:, k] = -column * pivot
        work[k] = row
        work[k, k] = pivot
    return np.ascontiguousarray(np.moveaxis(work, 2, 0))


def _cofactors(jacobian: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Determinants [...] and matrices of cofactors, det J times J⁻ᵀ, of J [..., 3, 3]."""
    out = np.empty_like(jacobian)
    for i in range(3):
        (a, b, c), (d, e, f) = (np.moveaxis(jacobian[..., (i + k) % 3, :], -1, 0) for k in (1, 2))
        out[..., i, 0], out[..., i, 1], out[..., i, 2] = b * f - c * e, c * d - a * f, a * e - b * d
    return np.asarray((jacobian[..., 0, :] * out[..., 0, :]).sum(axis=-1)), out


def _strain(gradient: FloatArray) -> FloatArray:
    """Strains [e, q, 6, 3 n] (engineering shear) of functions with gradients [e, q, n, 3]."""
    out = np.zeros((*gradient.shape[:2], 6, 3 * gradient.shape[2]))
    for row, (a, b) in enumerate(PAIRS):
        out[:, :, row, a::3] = gradient[..., b]
        out[:, :, row, b::3] = gradient[..., a]
    return out


def _require_positive(determinant: FloatArray, element_id: IntArray) -> None:
    bad = element_id[~(determinant > 0.0).all(axis=1)]
    if bad.size:
        some = ", ".join(map(str, bad[:10])) + (" ..." if bad.size > 10 else "")
        raise PhysicsError(
            f"{bad.size} solid element(s) with a Jacobian that is not positive: {some}",
            hint="number the corners counter-clockwise as Nastran asks, and untangle collapsed elements",
        )
