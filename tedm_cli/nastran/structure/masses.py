"""The masses of a model as a matrix on its grids, for accelerations and natural frequencies."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from tedm_cli.fem.mass import MassBlock, PointInertia, mass_matrix
from tedm_cli.fem.shapes import shape_of
from tedm_cli.nastran.geometry import ModelGeometry


def model_mass(geometry: ModelGeometry) -> sp.csr_matrix:
    """Mass matrix [6 N, 6 N] of a model, kg and kg m², basic frame: see `tedm_cli.fem.mass`."""
    e, c = geometry.elements, geometry.concentrated
    counts = np.diff(e.node_offset)
    kinds, kind_of = np.unique([f"{card}:{n}" for card, n in zip(e.type, counts, strict=True)], return_inverse=True)
    found = []
    for number, kind in enumerate(kinds.tolist()):
        card, nodes = kind.split(":")
        members = np.flatnonzero((kind_of == number) & (e.mass_kg != 0.0))
        at = e.node_offset[members][:, None] + np.arange(int(nodes))
        shape = shape_of(card, int(nodes))
        found.append(
            MassBlock(
                shape=shape if shape is not None and shape.dimension == 3 else None,
                connectivity=e.node_index[at],
                mass=e.mass_kg[members],
                weight=e.weight[at],
                lever=e.lever[at],
            )
        )
    points = PointInertia(node=c.node, mass=c.kg, lever=c.lever, inertia=c.inertia)
    return mass_matrix(geometry.position_m, found, points)
