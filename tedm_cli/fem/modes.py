"""Natural frequencies: the lowest modes of K φ = ω² M φ.

Lanczos' method finds the largest 1/(ω² + s) of M φ = (K + s M) φ / (ω² + s) with one factorisation (Ericsson & Ruhe,
Math. Comput. 35, 1980). The shift s is zero where the structure is held. Where it is free it makes K + s M definite,
and the rigid motions, whose number follows from the supports, are left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
import scipy.sparse as sp

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import PhysicsError
from tedm_cli.fem.assembly import assemble
from tedm_cli.fem.constraints import rigid_body_matrix
from tedm_cli.fem.linear import SolverName, factorise
from tedm_cli.fem.reduced import reduced_stiffness
from tedm_cli.fem.stability import free_motions
from tedm_cli.fem.structure import Structure

# Fewer unknowns than this are solved densely: Lanczos needs some more than there are modes.
_DENSE = 200
# Of the largest ratio of a stiffness to a mass: far above rounding, far below any frequency that is asked for.
_SHIFT = 1e-9
# Of the sum of masses times squares: what is left of a motion about a centre of gravity, which has no mass of its own.
_CANCELS = 1e-6
_APART = 1e-8  # relative, of values of one mode in two searches
_MASSLESS = 1e-12  # of the largest 1/(ω² + s), which motions without mass have as rounding


@dataclass(frozen=True, eq=False)
class NaturalModes:
    """The k lowest modes, rigid motions left out.

    frequency_hz : [k], ascending. motion : [k, N, 6], m and rad in the frame of the positions, of modal mass 1 kg.
    effective_mass : [k, 6], kg and kg m², of the translations along and the rotations about the three axes through the
        centre of gravity; over all modes they add up to `mass`, less what the supports carry themselves.
    mass : [6], of the structure as one.
    rigid : names of the rigid motions that nothing holds.
    """

    frequency_hz: FloatArray
    motion: FloatArray
    effective_mass: FloatArray
    mass: FloatArray
    rigid: tuple[str, ...]


def natural_modes(
    structure: Structure, mass: sp.csr_matrix, number: int, *, solver: SolverName = "auto"
) -> NaturalModes:
    """The `number` lowest modes, or all where there are fewer.

    Parameters
    ----------
    mass : sparse [6 N, 6 N], see `tedm_cli.fem.mass`.

    Raises
    ------
    InputError : rigid elements contradict each other.
    PhysicsError : a structure without mass that can move, or one with a mechanism.
    """
    reduced = reduced_stiffness(structure, assemble(structure).stiffness)
    rigid = free_motions(structure, reduced.matrix, reduced.active, reduced.constrained, reduced.measure)
    free = reduced.free
    transform = reduced.transform[:, free]
    stiffness = reduced.matrix[free][:, free]
    moved = (transform.T @ mass @ transform).tocsr()
    heavy = moved.diagonal()
    if not heavy.any():
        raise PhysicsError("no mass can move, so there are no frequencies", hint="give the materials densities")
    shift = 0.0
    if rigid:
        shift = _SHIFT * float((stiffness.diagonal()[heavy > 0.0] / heavy[heavy > 0.0]).max())
    wanted = min(number + len(rigid), int(np.count_nonzero(heavy)))
    try:
        inverse, shape = _largest(moved, (stiffness + shift * moved).tocsr(), wanted, solver)
    except np.linalg.LinAlgError as exc:
        raise _mechanism(rigid) from exc
    some = (inverse > _MASSLESS * inverse[0]) & (inverse > _CANCELS * (heavy @ shape**2))
    square = (1.0 / inverse[some] - shift)[len(rigid) :]
    if square.size and not square[0] > 0.0:
        raise _mechanism(rigid)
    motion = np.asarray(transform @ shape[:, some])[:, len(rigid) :]
    motion /= np.sqrt(np.einsum("ik,ik->k", motion, mass @ motion))
    whole, all_as_one = _as_one(structure.position, mass)
    return NaturalModes(
        frequency_hz=np.sqrt(square) / (2.0 * np.pi),
        motion=motion.T.reshape(len(square), structure.n_grids, 6),
        effective_mass=np.square((mass @ motion).T @ all_as_one),
        mass=whole,
        rigid=tuple(rigid),
    )


def _largest(
    mass: sp.csr_matrix, stiffness: sp.csr_matrix, number: int, solver: SolverName
) -> tuple[FloatArray, FloatArray]:
    """The largest eigenvalues of M φ = μ K φ, falling, and their vectors [n, k]; `LinAlgError` for a singular K."""
    size = mass.shape[0]
    if size <= max(_DENSE, 2 * number):
        dense = mass.toarray(), stiffness.toarray()
        values, vectors = scipy.linalg.eigh(*dense, subset_by_index=(size - number, size - 1))
        return values[::-1], vectors[:, ::-1]
    factors = factorise(stiffness, solver)
    inverse = scipy.sparse.linalg.LinearOperator(
        (size, size), matvec=lambda x: factors.solve(x.reshape(-1, 1))[:, 0], dtype=np.float64
    )
    random = np.random.default_rng(0)  # the same modes in every run
    values, vectors = np.zeros(0), np.zeros((size, 0))
    # Lanczos' method may miss one of several equal frequencies: what it has found is taken out of M, and it looks again
    # until nothing is left that is as large.
    while len(values) < size - 1:
        some = 1 if values.size else number
        left, start = _without(mass, values, vectors), random.standard_normal(size)
        new, shape = scipy.sparse.linalg.eigsh(left, some, M=stiffness, Minv=inverse, which="LA", v0=start)
        least = max((1.0 + _APART) * values.min(initial=np.inf), _MASSLESS * values.max(initial=0.0))
        if values.size and not new[0] > least:
            break
        values, vectors = np.concatenate([values, new]), np.concatenate([vectors, shape], axis=1)
    order = np.argsort(-values)[:number]
    return values[order], vectors[:, order]


def _without(mass: sp.csr_matrix, values: FloatArray, vectors: FloatArray) -> scipy.sparse.linalg.LinearOperator:
    """M without the modes that are known, M φ = μ K φ with φᵀ K φ = 1."""
    kept = values > _MASSLESS * values.max(initial=0.0)  # the others are not in it
    weighed = np.asarray(mass @ vectors[:, kept])

    def product(x: FloatArray) -> FloatArray:
        return np.asarray(mass @ x - weighed @ ((weighed.T @ x) / values[kept]))

    return scipy.sparse.linalg.LinearOperator(mass.shape, matvec=product, dtype=np.float64)


def _mechanism(rigid: list[str]) -> PhysicsError:
    besides = f"; rigid motions that nothing holds: {', '.join(rigid)}" if rigid else ""
    return PhysicsError(
        f"something moves without stiffness and without mass, or is a mechanism{besides}",
        hint="a line of bars has no inertia about its axis; else look for a hinge without stiffness, or for a bar on a"
        " grid of solids, which do not hold its rotation",
    )


def _as_one(position: FloatArray, mass: sp.csr_matrix) -> tuple[FloatArray, FloatArray]:
    """Mass and inertia [6] of a structure as one about its centre of gravity, and these six motions [6 N, 6]."""
    about = rigid_body_matrix(position).reshape(-1, 6)
    first = about.T @ (mass @ about)
    kg = first[0, 0]
    centre = np.array([first[1, 5] - first[2, 4], first[2, 3] - first[0, 5], first[0, 4] - first[1, 3]]) / (2.0 * kg)
    motions = rigid_body_matrix(position - centre).reshape(-1, 6)
    return np.diag(motions.T @ (mass @ motions)).copy(), motions
