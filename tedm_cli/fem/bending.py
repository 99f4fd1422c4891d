"""Would bubble functions change the displacements? A judgement of linear solids in bending.

Linear hexahedra and pentahedra without bubble functions are too stiff in bending where few of them lie through a wall
(Cook et al., Concepts and Applications of Finite Element Analysis, on the bilinear element in bending), and nothing in
their own solution tells by how much: a locked wall carries smooth stresses. The same mesh with bubble functions does.
Its stiffness is close enough to the factorised one for conjugate gradients, preconditioned with those factors, to find
its displacements in a few iterations. They are found for sums of the load cases with random signs; squares of sums with
random signs have the sums of squares as expectation (Hutchinson, Commun. Stat. Simul. Comput. 18, 1989).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from tedm_cli.arrays import FloatArray
from tedm_cli.fem.assembly import assemble
from tedm_cli.fem.linear import Factorisation
from tedm_cli.fem.solids import block_shape
from tedm_cli.fem.structure import SolidBlock, Structure

_SUMS = 2
_TOLERANCE = 1e-3  # of the residual: the change is wanted to a few digits
_ITERATIONS = 200


@dataclass(eq=False)
class RandomSums:
    """Sums of load cases with random signs.

    unknown : [n, 2], their solutions.
    temperature : [N, 2], K.
    amount : [2], how often the strain-free temperatures are contained.
    """

    unknown: FloatArray
    temperature: FloatArray
    amount: FloatArray
    random: np.random.Generator

    @classmethod
    def none(cls, n_unknowns: int, n_grids: int) -> RandomSums:
        """Sums of no load case yet."""
        return cls(np.zeros((n_unknowns, _SUMS)), np.zeros((n_grids, _SUMS)), np.zeros(_SUMS), np.random.default_rng(0))

    def add(self, unknown: FloatArray, temperature: FloatArray) -> None:
        """Add load cases with solutions [n, m] and temperatures [N, m]."""
        sign = self.random.choice([-1.0, 1.0], size=(unknown.shape[1], _SUMS))
        self.unknown += unknown @ sign
        self.temperature += temperature @ sign
        self.amount += sign.sum(axis=0)


def can_lock(block: SolidBlock) -> bool:
    """Whether bubble functions would make a difference to the elements."""
    return not block.bubble and not block_shape(block).edges and block.card != "CTETRA"


def bending_change(
    structure: Structure, transform: sp.csr_matrix, factors: Factorisation, sums: RandomSums
) -> float | None:
    """Change of the displacements if all linear hexahedra and pentahedra had bubble functions.

    Parameters
    ----------
    transform : sparse [6 N, n], all degrees of freedom by the unknowns.
    factors : the factorised stiffness [n, n] of the structure as it is.
    sums : of the solved load cases.

    Returns
    -------
    Root mean square over load cases and grids, over that of the changed displacements; None if no element has anything
    to gain.
    """
    if not any(can_lock(block) for block in structure.solids):
        return None
    softer = assemble(
        replace(structure, solids=tuple(replace(b, bubble=True) if can_lock(b) else b for b in structure.solids))
    )
    load = transform.T @ softer.thermal.forces(sums.temperature, sums.amount)
    unknown = sums.unknown.copy()

    def product(x: FloatArray) -> FloatArray:
        return np.asarray(transform.T @ (softer.stiffness @ (transform @ x)))

    residual = load - product(unknown)
    step = solved = factors.solve(residual)
    power = (residual * solved).sum(axis=0)
    goal = _TOLERANCE**2 * (load * factors.solve(load)).sum(axis=0)
    for _ in range(_ITERATIONS):
        if (power <= goal).all():
            break
        pushed = product(step)
        size = power / np.where(power > 0.0, (step * pushed).sum(axis=0), 1.0)
        unknown += size * step
        residual -= size * pushed
        solved = factors.solve(residual)
        former, power = power, (residual * solved).sum(axis=0)
        step = solved + power / np.where(former > 0.0, former, 1.0) * step
    before, after = (_translations(transform @ x) for x in (sums.unknown, unknown))
    return float(np.linalg.norm(after - before) / (np.linalg.norm(after) or 1.0))


def _translations(motion: FloatArray) -> FloatArray:
    return motion.reshape(-1, 6, motion.shape[1])[:, :3]
