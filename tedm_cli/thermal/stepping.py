"""A linear thermal network in time, for disturbances that are straight between their samples.

Arithmetic nodes are eliminated: they follow the others at once. Of up to `SMALL` diffusive nodes a step is exact, by
the matrix exponential; of more it is implicit (Radau IIA of two stages, third order, L-stable) with the error that
halving the steps tells.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray, IndexArray
from tedm_cli.thermal.linear import LinearNetwork
from tedm_cli.thermal.network import selected
from tedm_cli.thermal.solving import factorised

SMALL = 400  # diffusive nodes of which the exponential is taken
_ITERATIONS = 200  # of the largest eigenvalue
_RADAU = ((5.0 / 12.0, -1.0 / 12.0), (3.0 / 4.0, 1.0 / 4.0))  # stages at 1/3 and 1 of a step


@dataclass(frozen=True, eq=False)
class ReducedNetwork:
    """C dx/dt = -K x + B u of diffusive nodes; arithmetic ones are D x + E u.

    rows [d], arithmetic : which of the free nodes these are. capacity [d] : C. conductance : K [d, d]. disturbed : B
    [d, u]. follows : D. directly : E.
    """

    rows: IndexArray
    arithmetic: IndexArray
    capacity: FloatArray
    conductance: scipy.sparse.csc_array
    disturbed: FloatArray
    follows: FloatArray
    directly: FloatArray

    def all_nodes(self, x: FloatArray, u: FloatArray) -> FloatArray:
        """[n_free, T] from diffusive nodes x [d, T] and disturbances u [u, T]."""
        out = np.empty((len(self.rows) + len(self.arithmetic), x.shape[1]))
        out[self.rows] = x
        out[self.arithmetic] = self.follows @ x + self.directly @ u
        return out


class NetworkInTime:
    """A network that is advanced block after block.

    exact : whether steps are, to rounding; else implicit.
    error_K : [n_free], estimate of the largest error of each node so far; 0 where steps are exact.
    """

    def __init__(self, network: LinearNetwork, step_s: float, *, settled: bool = True) -> None:
        """Disturbances come `step_s` apart. It begins in the steady state: `settled`, that of the first of them, or
        without any."""
        self._reduced = eliminated(network)
        self._network, self._settled = network, settled
        self.exact = len(self._reduced.rows) <= SMALL
        self.error_K: FloatArray = np.zeros(len(network.name))
        advances = [_Exact(self._reduced, step_s)] if self.exact else [
            _Implicit(self._reduced, step_s, pieces) for pieces in (2, 1)
        ]  # fmt: skip
        self._advances: list[_Exact | _Implicit] = list(advances)
        self._last: FloatArray | None = None
        self._state: list[FloatArray] = []

    def advance(self, disturbance: FloatArray) -> FloatArray:
        """Temperatures [n_free, T] in K about the steady state at the next disturbances [u, T], K or W."""
        u = disturbance
        begins = self._last is None
        if self._last is None:
            start = np.zeros(len(self._reduced.rows))
            if self._settled:
                start = factorised(self._reduced.conductance).solve(self._reduced.disturbed @ u[:, 0])
            self._state = [start] * len(self._advances)
        else:
            u = np.concatenate([self._last[:, None], u], axis=1)
        found = []
        for number, advance in enumerate(self._advances):
            x = advance(self._state[number], u)
            self._state[number] = x[:, -1].copy()
            found.append(self._reduced.all_nodes(x, u)[:, 0 if begins else 1 :])
        if len(found) > 1:  # of a third order, halved steps have an eighth of the error
            self.error_K = np.maximum(self.error_K, np.abs(found[0] - found[1]).max(axis=1, initial=0.0) / 7.0)
        self._last = u[:, -1].copy()
        return found[0]


def slowest_s(network: LinearNetwork) -> float:
    """Upper bound of the longest time constant, s: the largest eigenvalue of K⁻¹ C, which has no negative entry.

    For any positive vector the largest ratio of its components before and after is such a bound (Collatz, Wielandt).
    """
    reduced = eliminated(network)
    lu = factorised(reduced.conductance)
    x = np.ones(len(reduced.rows))
    bound = np.inf
    for _ in range(_ITERATIONS):
        found = lu.solve(reduced.capacity * x)
        if not (found > 0.0).all():
            break
        bound = min(bound, float((found / x).max()))
        x = found / found.max()
    return bound


def eliminated(network: LinearNetwork) -> ReducedNetwork:
    """The network without its arithmetic nodes, which follow the others at once."""
    arithmetic = np.flatnonzero(network.capacity == 0.0)
    rows = np.flatnonzero(network.capacity > 0.0)
    K = network.conductance
    kept, B = selected(K, rows, rows), network.disturbed[rows]
    if not arithmetic.size:
        none = np.zeros((0, len(rows))), np.zeros((0, B.shape[1]))
        return ReducedNetwork(rows, arithmetic, network.capacity[rows], kept, B, *none)
    inner = factorised(selected(K, arithmetic, arithmetic))
    follows = -inner.solve(selected(K, arithmetic, rows).toarray())
    directly = inner.solve(network.disturbed[arithmetic])
    outer = selected(K, rows, arithmetic)
    reduced = kept + scipy.sparse.csc_array(outer @ follows)
    return ReducedNetwork(
        rows, arithmetic, network.capacity[rows], reduced.tocsc(), B - outer @ directly, follows, directly
    )


class _Exact:
    """x_{k+1} = Φ x_k + Γ0 u_k + Γ1 u_{k+1}, by the exponential of the network with two integrators of u behind it."""

    def __init__(self, reduced: ReducedNetwork, step_s: float) -> None:
        n, m = reduced.disturbed.shape
        whole = np.zeros((n + 2 * m, n + 2 * m))
        whole[:n, :n] = -reduced.conductance.toarray() / reduced.capacity[:, None] * step_s
        whole[:n, n : n + m] = reduced.disturbed / reduced.capacity[:, None] * step_s
        whole[n : n + m, n + m :] = np.eye(m)
        exponential = scipy.linalg.expm(whole)
        self._phi, gamma, self._ramp = exponential[:n, :n], exponential[:n, n : n + m], exponential[:n, n + m :]
        self._held = gamma - self._ramp

    def __call__(self, start: FloatArray, u: FloatArray) -> FloatArray:
        """x [n, T] at the disturbances [u, T], from `start` at the first."""
        x = np.empty((u.shape[1], len(start)))
        x[0] = start
        driven = (self._held @ u[:, :-1] + self._ramp @ u[:, 1:]).T
        for k in range(len(driven)):
            x[k + 1] = self._phi @ x[k] + driven[k]
        return x.T


class _Implicit:
    """The same by `pieces` steps of Radau's method between samples: both stages by one factorisation for all steps."""

    def __init__(self, reduced: ReducedNetwork, step_s: float, pieces: int) -> None:
        self._reduced, self._pieces, self._h = reduced, pieces, step_s / pieces
        C, K, h = scipy.sparse.diags_array(reduced.capacity), reduced.conductance, self._h
        (a, b), (c, d) = _RADAU
        both = scipy.sparse.block_array([[C + h * a * K, h * b * K], [h * c * K, C + h * d * K]]).tocsc()
        self._lu = scipy.sparse.linalg.splu(both)

    def __call__(self, start: FloatArray, u: FloatArray) -> FloatArray:
        """x [n, T] at the disturbances [u, T], from `start` at the first."""
        K, B, n = self._reduced.conductance, self._reduced.disturbed, len(start)
        _, (c, d) = _RADAU
        out = np.empty((n, u.shape[1]))
        out[:, 0] = x = start
        for k in range(u.shape[1] - 1):
            for piece in range(self._pieces):
                early, late = ((piece + part) / self._pieces for part in (1.0 / 3.0, 1.0))
                heat = [B @ (u[:, k] + part * (u[:, k + 1] - u[:, k])) - K @ x for part in (early, late)]
                slope = self._lu.solve(np.concatenate(heat))
                x = x + self._h * (c * slope[:n] + d * slope[n:])
            out[:, k + 1] = x
        return out
