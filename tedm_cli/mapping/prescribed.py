"""Temperatures of grids from averages that are prescribed: of all fields with them, the one that conduction chooses.

The method of prescribed average temperatures (PAT; ESA STM-285, SINAS):

    minimise ½ Tᵀ K_c T   subject to   A T = τ:     [K_c Aᵀ; A 0] [T; μ] = [f; τ],   f = 0,   T = P τ

Its Euler equation is steady conduction with a source that is even over each thermal node: μ is what flows out of it.
For an output with sensitivities s to the temperatures of grids, sᵀ P is the μ of f = s and τ = 0, since the matrix is
symmetric: one solution for each output, whatever the number of nodes.

The matrix is neither definite nor, with averages over thousands of grids, sparse. So K_c is held at one grid of each
connected part, which makes it positive definite, and the n equations of μ are what is left (Benzi, Golub & Liesen, Acta
Numerica 14, 2005, section 5). With X = K_g⁻¹ Aᵀ, S = A X, in each part, whose rows of A sum to one,

    S μ = y - τ + c 1,   1ᵀ μ = 1ᵀ f,   T = K_g⁻¹ (f - Aᵀ μ) + c 1,   y = A K_g⁻¹ f

where what is held takes no heat, because the sources of a part sum to zero.

A node whose elements are in several parts that nothing joins has its temperature as average in each of them. The
literal average over all would let one piece be too warm where another is too cold.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
import scipy.sparse as sp

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.fem.linear import SolverName, factorise
from tedm_cli.mapping.averages import NONE

_BLOCK = 64  # right-hand sides at a time
_REFINEMENTS = 2
# Of a squared average that those before it leave of it; two averages over the same grids leave some 1e-16.
_DEPENDENT = 1e-12


class DependentAverages(Exception):
    """Averages that follow from others, and so cannot be prescribed.

    rows : of the matrix of averages, of the first part where there are any.
    """

    def __init__(self, rows: IntArray) -> None:
        super().__init__()
        self.rows = rows


@dataclass(frozen=True, eq=False)
class _Part:
    """A connected part: rows [m] of its averages, its grids, S factorised, w = S⁻¹ 1 [m] and its sum."""

    rows: IntArray
    grids: IntArray
    factors: Any
    w: FloatArray
    total: float

    def solve(self, y: FloatArray) -> FloatArray:
        return np.asarray(scipy.linalg.cho_solve(self.factors, y))


class PrescribedAverages:
    """The map P [N, n] from n averages to temperatures of N grids, as solutions: it is never held.

    Parameters
    ----------
    conduction : K_c [N, N], W/K.
    averages : A [n, N], each row within one connected part, summing to one.
    part : [N], of each grid, `NONE` of those that are not mapped; every part has a row of A.

    Raises
    ------
    DependentAverages : rows of A that others fix.
    PhysicsError : the library that factorises gives up.
    """

    def __init__(
        self, conduction: sp.csr_matrix, averages: sp.csr_matrix, part: IntArray, solver: SolverName = "auto"
    ) -> None:
        self.mapped = np.flatnonzero(part != NONE)
        self.grids, self.nodes = len(part), averages.shape[0]
        self._k = conduction[self.mapped][:, self.mapped].tocsr()
        self._a = averages[:, self.mapped].tocsr()
        self._part = part[self.mapped]
        self._row_part = self._part[self._a.indices[self._a.indptr[:-1]]]
        refuse_dependent(self._a, self._row_part)
        diagonal = self._k.diagonal()
        held = np.zeros(len(self.mapped))
        order = np.lexsort((diagonal, self._part))
        strongest = order[np.flatnonzero(np.diff(self._part[order], append=self._part.max(initial=-1) + 1))]
        held[strongest] = diagonal[strongest]
        lone = held == 0.0  # a grid without conduction is a part of its own
        held[strongest] = np.where(lone[strongest], 1.0, held[strongest])
        self._factors = factorise(sp.csr_matrix(self._k + sp.diags(held)), solver)
        self.solver = self._factors.name
        self._parts = list(self._reduced())

    def _reduced(self) -> Iterator[_Part]:
        """The equations of μ of every part."""
        n = self.nodes
        s = np.empty((n, n))
        for start in range(0, n, _BLOCK):
            columns = slice(start, min(start + _BLOCK, n))
            s[:, columns] = self._a @ self._factors.solve(np.asarray(self._a[columns].T.toarray()))
        for number in np.unique(self._row_part):
            rows = np.flatnonzero(self._row_part == number)
            mine = s[np.ix_(rows, rows)]
            mine = 0.5 * (mine + mine.T)
            factors = scipy.linalg.cho_factor(mine, lower=True)
            w = np.asarray(scipy.linalg.cho_solve(factors, np.ones(len(rows))))
            yield _Part(rows, np.flatnonzero(self._part == number), factors, w, float(w.sum()))

    def temperatures(self, average: FloatArray) -> FloatArray:
        """P τ: temperatures [N, m] of the grids for m sets of averages [n, m]; NaN of grids that are not mapped."""
        out = np.full((self.grids, average.shape[1]), np.nan)
        for start in range(0, average.shape[1], _BLOCK):
            some = slice(start, start + _BLOCK)
            tau = average[:, some]
            # what is common to a part is kept to the last digit
            level = np.stack([tau[self._row_part == p].mean(axis=0) for p in range(len(self._parts))])
            source = np.zeros((len(self.mapped), tau.shape[1]))
            field, _ = self._solve(source, tau - level[self._row_part])
            out[self.mapped, some] = field + level[self._part]
        return out

    def sensitivities(self, s: FloatArray) -> FloatArray:
        """sᵀ P [r, n] of r outputs with sensitivities s [r, N] to the temperatures of the grids."""
        out = np.empty((len(s), self.nodes))
        for start in range(0, len(s), _BLOCK):
            some = slice(start, start + _BLOCK)
            source = np.ascontiguousarray(s[some][:, self.mapped].T)
            out[some] = self._solve(source, np.zeros((self.nodes, source.shape[1])))[1].T
        return out

    def _solve(self, f: FloatArray, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        """T and μ of sources f [·, m] and averages [n, m], refined."""
        field, mu = self._once(f, tau)
        for _ in range(_REFINEMENTS):
            more, more_mu = self._once(f - self._k @ field - self._a.T @ mu, tau - self._a @ field)
            field, mu = field + more, mu + more_mu
        return field, mu

    def _once(self, f: FloatArray, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        y = self._a @ self._factors.solve(f)
        mu = np.empty_like(tau)
        level = np.empty((len(self._parts), tau.shape[1]))
        for number, part in enumerate(self._parts):
            off = y[part.rows] - tau[part.rows]
            common = off.mean(axis=0)  # is in c, and would cancel in μ
            found = part.solve(off - common)
            heat = f[part.grids].sum(axis=0)
            c = (heat - found.sum(axis=0)) / part.total
            mu[part.rows] = found + part.w[:, None] * c
            level[number] = c - common
        return self._factors.solve(f - self._a.T @ mu) + level[self._part], mu


def refuse_dependent(averages: sp.csr_matrix, part: IntArray) -> None:
    """`DependentAverages` where rows [n, N] of averages, each of a part [n], follow from others (pivoted Cholesky)."""
    length = np.sqrt(np.asarray(averages.multiply(averages).sum(axis=1)).ravel())
    scaled = sp.csr_matrix(sp.diags(1.0 / length) @ averages)
    for number in np.unique(part):
        rows = np.flatnonzero(part == number)
        mine = scaled[rows]
        gram = np.asfortranarray((mine @ mine.T).toarray())
        _, pivot, rank, _ = scipy.linalg.lapack.dpstrf(gram, tol=_DEPENDENT, lower=1)
        if rank < len(rows):
            raise DependentAverages(rows[np.sort(pivot[rank:] - 1)])
