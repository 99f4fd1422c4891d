"""Stiffness of the solids against scikit-fem, which has shape functions, maps and quadrature of its own."""

from __future__ import annotations

import numpy as np
import pytest
from fem_models import NU, YOUNG, solid_mesh, solids, structure
from scipy.spatial import cKDTree
from skfem import (
    Basis,
    ElementHex1,
    ElementHexS2,
    ElementTetP1,
    ElementTetP2,
    ElementVector,
    MeshHex,
    MeshTet,
)
from skfem.models.elasticity import lame_parameters, linear_elasticity

from tedm_cli.fem.assembly import assemble

# scikit-fem's order of the hexahedron's corners, as rows of Nastran's
PEERS = {
    ("CHEXA", 8): (MeshHex, ElementHex1, [0, 3, 4, 1, 7, 2, 5, 6]),
    ("CHEXA", 20): (MeshHex, ElementHexS2, [0, 3, 4, 1, 7, 2, 5, 6]),
    ("CTETRA", 4): (MeshTet, ElementTetP1, range(4)),
    ("CTETRA", 10): (MeshTet, ElementTetP2, range(4)),
}


@pytest.mark.parametrize(("card", "nodes"), PEERS)
def test_fem_stiffness_equals_that_of_scikit_fem(card, nodes):
    """Forces of random motions on a distorted mesh; quadratic hexahedra on a regular one, where both are exact."""
    mesh_type, element, order = PEERS[card, nodes]
    distortion = 0.0 if nodes == 20 else 0.3
    position, connectivity = solid_mesh(card, nodes, (2, 2, 2), (0.3, 0.2, 0.25), distortion)
    corners = connectivity[:, list(order)]
    grids = np.unique(corners)
    mesh = mesh_type(position[grids].T.copy(), np.searchsorted(grids, corners).T.copy())
    basis = Basis(mesh, ElementVector(element()), intorder=3 if nodes < 9 else 5)
    peer = linear_elasticity(*lame_parameters(YOUNG, NU)).assemble(basis)
    where = cKDTree(position).query(basis.doflocs.T)
    assert where[0].max() < 1e-9
    component = np.empty(peer.shape[0], dtype=int)
    for axis in range(3):
        component[basis.get_dofs(elements=np.arange(mesh.t.shape[1])).all(f"u^{axis + 1}")] = axis
    ours = assemble(structure(position, solids=(solids(card, connectivity),))).stiffness
    dof = 6 * where[1] + component
    motion = np.random.default_rng(2).standard_normal((len(dof), 4))
    forces, wanted = ours[dof][:, dof] @ motion, peer @ motion
    assert np.abs(forces - wanted).max() < 1e-12 * np.abs(wanted).max()
