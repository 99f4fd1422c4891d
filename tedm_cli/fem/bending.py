"""Would bubble functions change the displacements? A judgement of linear solids in bending.

Linear hexahedra and pentahedra without bubble functions are too stiff in bending where few of them lie through a wall
(Cook et al., Concepts and Applications of Finite Element Analysis, on the bilinear element in bending), and nothing in
their own solution tells by how much: a locked wall carries smooth stresses. The same mesh with bubble functions does.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from tedm_cli.fem.factors import Factorisation
from tedm_cli.fem.other_elements import RandomSums, displacements_with
from tedm_cli.fem.solids import block_shape
from tedm_cli.fem.structure import SolidBlock, Structure

_TOLERANCE = 1e-3  # the change is wanted to a few digits


def can_lock(block: SolidBlock) -> bool:
    """Whether bubble functions would make a difference to the elements."""
    return not block.bubble and not block_shape(block).edges and block.card != "CTETRA"


def bending_change(
    structure: Structure, transform: sp.csr_matrix, factors: Factorisation, sums: RandomSums
) -> float | None:
    """Change of the displacements if all linear hexahedra and pentahedra had bubble functions.

    Parameters as of `displacements_with`.

    Returns
    -------
    Root mean square over load cases and grids, over that of the changed displacements; None if no element has anything
    to gain.
    """
    if not any(can_lock(block) for block in structure.solids):
        return None
    softer = replace(structure, solids=tuple(replace(b, bubble=True) if can_lock(b) else b for b in structure.solids))
    before, after = (motion[::2] for motion in displacements_with(softer, transform, factors, sums, _TOLERANCE))
    return float(np.linalg.norm(after - before) / (np.linalg.norm(after) or 1.0))
