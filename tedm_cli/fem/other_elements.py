"""Displacements that the same mesh would have with other elements: what a choice of elements decides.

A stiffness that is close to the factorised one needs no factors of its own: conjugate gradients, preconditioned with
the factors at hand, find its displacements in a few iterations. They are found for sums of the load cases with random
signs; squares of sums with random signs have the sums of squares as expectation (Hutchinson, Commun. Stat. Simul.
Comput. 18, 1989).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tedm_cli.arrays import FloatArray
from tedm_cli.fem.assembly import assemble, direct_stiffness
from tedm_cli.fem.element_loads import element_loads
from tedm_cli.fem.factors import Factorisation
from tedm_cli.fem.structure import Structure

_SUMS = 2
_ITERATIONS = 200


@dataclass(frozen=True, eq=False, kw_only=True)
class BatchLoads:
    """Loads of m cases side by side.

    temperature : [N, m], K, zero of cases without. amount : [m], one of cases with temperatures, else zero.
    own : [5 L, m], as in `ElementLoads.own`. force : [6 N, m], of forces and accelerations. held : [6 N, m], the motion
    that the supports alone make of all grids, those of rigid elements included. None where no case has any.
    """

    temperature: FloatArray
    amount: FloatArray
    own: FloatArray | None
    force: FloatArray | None
    held: FloatArray | None


@dataclass(eq=False)
class RandomSums:
    """Sums of load cases with random signs.

    unknown : [n, 2], their solutions.
    temperature : [N, 2], K.
    amount : [2], how often the strain-free temperatures are contained.
    own : [5 L, 2], temperatures of elements (`ElementLoads.own`); None as long as no case has any.
    force, held : [6 N, 2], forces that do not depend on the elements, and motions that the supports alone make; None as
        long as no case has any.
    """

    unknown: FloatArray
    temperature: FloatArray
    amount: FloatArray
    random: np.random.Generator
    own: FloatArray | None = None
    force: FloatArray | None = None
    held: FloatArray | None = None

    @classmethod
    def none(cls, n_unknowns: int, n_grids: int) -> RandomSums:
        """Sums of no load case yet."""
        return cls(np.zeros((n_unknowns, _SUMS)), np.zeros((n_grids, _SUMS)), np.zeros(_SUMS), np.random.default_rng(0))

    def add(self, unknown: FloatArray, loads: BatchLoads) -> None:
        """Add m load cases with solutions [n, m]."""
        sign = self.random.choice([-1.0, 1.0], size=(unknown.shape[1], _SUMS))
        self.unknown += unknown @ sign
        self.temperature += loads.temperature @ sign
        self.amount += loads.amount @ sign
        self.own = _added(self.own, loads.own, sign)
        self.force = _added(self.force, loads.force, sign)
        self.held = _added(self.held, loads.held, sign)


def _added(total: FloatArray | None, part: FloatArray | None, sign: FloatArray) -> FloatArray | None:
    if part is None:
        return total
    signed = part @ sign
    return signed if total is None else total + signed


def displacements_with(
    other: Structure, transform: sp.csr_matrix, factors: Factorisation, sums: RandomSums, tolerance: float
) -> tuple[FloatArray, FloatArray]:
    """Motions [2 N, 3, 2] of the solved sums: as they are, and as they are with the elements of `other`.

    Rows are the translations (m) and the rotations (rad) of one grid after the other.

    Parameters
    ----------
    other : the structure with other elements on the same grids, with stiffness wherever the factorised one has it.
    transform : sparse [6 N, n], all degrees of freedom by the unknowns.
    factors : the factorised stiffness [n, n] of the structure as it is.
    sums : of the solved load cases.
    tolerance : energy norm of the error over that of the load.
    """
    operators = assemble(other)
    force = operators.thermal.forces(sums.temperature, sums.amount)
    if sums.own is not None:
        force += element_loads(other).forces(sums.own)
    if sums.force is not None:
        force += sums.force
    stiffness = operators.stiffness + direct_stiffness(other)
    if sums.held is not None:
        force -= stiffness @ sums.held
    load = transform.T @ force
    unknown = sums.unknown.copy()

    def product(x: FloatArray) -> FloatArray:
        return np.asarray(transform.T @ (stiffness @ (transform @ x)))

    residual = load - product(unknown)
    step = solved = factors.solve(residual)
    power = (residual * solved).sum(axis=0)
    goal = tolerance**2 * (load * factors.solve(load)).sum(axis=0)
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
    still = 0.0 if sums.held is None else sums.held
    before, after = (np.asarray(transform @ x + still).reshape(-1, 3, _SUMS) for x in (sums.unknown, unknown))
    return before, after
