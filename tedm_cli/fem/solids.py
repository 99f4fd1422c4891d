"""Stiffness and thermal coupling of eight-node isotropic solids.

Displacements and temperature share the trilinear shape functions; both operators are integrated with 2x2x2 Gauss points
(Zienkiewicz & Taylor, The Finite Element Method, vol. 1, chapters 6 and 9). scikit-fem supplies the shape functions,
the isoparametric map and the quadrature; the elements are handled many at a time with one material each.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tedm_cli.errors import PhysicsError
from tedm_cli.fem.elements import ElementMatrices, dof_of
from tedm_cli.fem.structure import Floats, HexBlock, Ints

# Reference coordinates of the eight corners in Nastran's order.
_CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
# The six faces as corner numbers; face 2 m and face 2 m + 1 are opposite.
FACES = np.array([[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 5, 4], [3, 2, 6, 7], [0, 3, 7, 4], [1, 2, 6, 5]])
_BLOCK = 4096


def skfem_order() -> Ints:
    """Position of each Nastran corner among scikit-fem's hexahedron nodes, [8].

    Found from the reference coordinates of scikit-fem's own shape functions, so that a right-handed Nastran numbering
    has a positive Jacobian whatever order the library keeps.
    """
    from skfem import ElementHex1

    where = [int(np.flatnonzero((ElementHex1.doflocs == corner).all(axis=1))[0]) for corner in _CORNERS]
    return np.array(where, dtype=np.int64)


def hex_matrices(position: Floats, block: HexBlock) -> Iterator[ElementMatrices]:
    """Element matrices of `block`, a few thousand elements at a time.

    Parameters
    ----------
    position : [N, 3], m.
    block : the elements.

    Raises
    ------
    PhysicsError
        If an element's Jacobian is not positive at every integration point; the message lists element ids.
    """
    from skfem import Basis, ElementHex1, MeshHex1

    order = skfem_order()
    for start in range(0, len(block.element_id), _BLOCK):
        elements = slice(start, min(start + _BLOCK, len(block.element_id)))
        corners = block.connectivity[elements]
        n = len(corners)
        # Every element gets its own copy of its corners: the basis then needs no numbering beyond the element's.
        nodes = np.empty((8, n), dtype=np.int64)
        nodes[order] = np.arange(8 * n).reshape(n, 8).T
        basis = Basis(MeshHex1(position[corners.reshape(-1)].T.copy(), nodes), ElementHex1(), intorder=3)
        _require_positive(basis.mapping.detDF(basis.X), block.element_id[elements])
        gradient = np.stack([basis.basis[k][0].grad for k in order])  # [8, 3, e, q]
        shape = np.stack([np.broadcast_to(np.asarray(basis.basis[k][0]), basis.dx.shape) for k in order])  # [8, e, q]
        yield _integrate(elements, block, np.moveaxis(gradient, 2, 0), np.moveaxis(shape, 1, 0), basis.dx)


def _require_positive(determinant: Floats, element_id: Ints) -> None:
    bad = element_id[~(determinant > 0.0).all(axis=1)]
    if bad.size:
        some = ", ".join(map(str, bad[:10])) + (" ..." if bad.size > 10 else "")
        raise PhysicsError(
            f"{bad.size} solid element(s) with a Jacobian that is not positive: {some}",
            hint="number the corners counter-clockwise as Nastran asks, and untangle collapsed elements",
        )


def _integrate(elements: slice, block: HexBlock, gradient: Floats, shape: Floats, dx: Floats) -> ElementMatrices:
    """Sum over the Gauss points: gradient [e, 8, 3, q], shape [e, 8, q], dx [e, q]."""
    e, n_q = dx.shape
    young, nu = block.youngs_modulus[elements], block.poisson_ratio[elements]
    lame = young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
    shear = young / (2.0 * (1.0 + nu))
    flat = gradient.reshape(e, 24, n_q)
    # pairs[e, i, a, j, b] = integral of (d_a phi_i)(d_b phi_j): the isotropic stiffness is three contractions of it.
    pairs = (np.matmul(flat * dx[:, None, :], flat.transpose(0, 2, 1))).reshape(e, 8, 3, 8, 3)
    stiffness = lame[:, None, None, None, None] * pairs
    stiffness += shear[:, None, None, None, None] * pairs.transpose(0, 1, 4, 3, 2)
    laplacian = shear[:, None, None] * np.einsum("eiaja->eij", pairs)
    for axis in range(3):
        stiffness[:, :, axis, :, axis] += laplacian
    bulk = (3.0 * lame + 2.0 * shear)[:, None]
    weighted = flat * (bulk * dx)[:, None, :]
    coupling = block.expansion[elements][:, None, None] * np.matmul(weighted, shape.transpose(0, 2, 1))
    return ElementMatrices(
        dof=dof_of(block.connectivity[elements], 3),
        grids=block.connectivity[elements],
        stiffness=stiffness.reshape(e, 24, 24),
        coupling=coupling,
        expansion_load=weighted.sum(axis=2),
        reference_temperature=block.reference_temperature[elements],
    )


def single_layer_elements(block: HexBlock) -> Ints:
    """Ids of the solids that are the only element between two opposite free faces, [.].

    A wall one trilinear element thick carries bending by parasitic shear and is too stiff, by about
    (1 / (1 - nu) + (length / thickness)² / 2) / (1 + nu) (Cook et al., Concepts and Applications of Finite Element
    Analysis, on the bilinear element in bending).
    """
    faces = np.sort(block.connectivity[:, FACES], axis=2).reshape(-1, 4)
    _, inverse, count = np.unique(faces, axis=0, return_inverse=True, return_counts=True)
    free = (count[inverse.reshape(-1)] == 1).reshape(-1, 3, 2)
    return np.asarray(block.element_id[free.all(axis=2).any(axis=1)], dtype=np.int64)
