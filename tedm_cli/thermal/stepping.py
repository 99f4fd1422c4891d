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
_RADAU = ((5.0 / 12.0, -1.0 / 12.0), (3.0 / 4.0, 1.0 / 4.0))  # stages at 1/3 and 1 of a step


@dataclass(frozen=True, eq=False)
class Stepped:
    """A network in time.

    temperature_K : [n_free, T], deviations from the steady state. error_K : [n_free], estimate of the largest error of
    each node over the series; rounding alone, told as 0, where the exponential was taken.
    """

    temperature_K: FloatArray
    error_K: FloatArray


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


def stepped(network: LinearNetwork, disturbance: FloatArray, step_s: float) -> Stepped:
    """Temperatures from disturbances u [u, T], K or W, `step_s` apart; it begins in the steady state of the first."""
    reduced = eliminated(network)
    start = factorised(reduced.conductance).solve(reduced.disturbed @ disturbance[:, 0])
    if len(reduced.rows) <= SMALL:
        x = _exact(reduced, disturbance, step_s, start)
        return Stepped(reduced.all_nodes(x, disturbance), np.zeros(len(network.name)))
    coarse, fine = (_implicit(reduced, disturbance, step_s, start, pieces) for pieces in (1, 2))
    found = reduced.all_nodes(fine, disturbance)
    off = np.abs(found - reduced.all_nodes(coarse, disturbance)).max(axis=1)
    return Stepped(found, off / 7.0)  # of a third order, halved steps have an eighth of the error


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


def _exact(reduced: ReducedNetwork, u: FloatArray, step_s: float, start: FloatArray) -> FloatArray:
    """x_{k+1} = Φ x_k + Γ0 u_k + Γ1 u_{k+1}, by the exponential of the network with two integrators of u behind it."""
    n, m = reduced.disturbed.shape
    whole = np.zeros((n + 2 * m, n + 2 * m))
    whole[:n, :n] = -reduced.conductance.toarray() / reduced.capacity[:, None] * step_s
    whole[:n, n : n + m] = reduced.disturbed / reduced.capacity[:, None] * step_s
    whole[n : n + m, n + m :] = np.eye(m)
    exponential = scipy.linalg.expm(whole)
    phi, gamma, ramp = exponential[:n, :n], exponential[:n, n : n + m], exponential[:n, n + m :]
    out = np.empty((n, u.shape[1]))
    out[:, 0] = start
    driven = (gamma - ramp) @ u[:, :-1] + ramp @ u[:, 1:]
    for k in range(u.shape[1] - 1):
        out[:, k + 1] = phi @ out[:, k] + driven[:, k]
    return out


def _implicit(reduced: ReducedNetwork, u: FloatArray, step_s: float, start: FloatArray, pieces: int) -> FloatArray:
    """The same by `pieces` steps of Radau's method between samples: both stages by one factorisation for all steps."""
    h = step_s / pieces
    n = len(start)
    C, K, B = scipy.sparse.diags_array(reduced.capacity), reduced.conductance, reduced.disturbed
    (a, b), (c, d) = _RADAU
    both = scipy.sparse.block_array([[C + h * a * K, h * b * K], [h * c * K, C + h * d * K]]).tocsc()
    lu = scipy.sparse.linalg.splu(both)
    out = np.empty((n, u.shape[1]))
    out[:, 0] = x = start
    for k in range(u.shape[1] - 1):
        for piece in range(pieces):
            early, late = ((piece + part) / pieces for part in (1.0 / 3.0, 1.0))
            heat = [B @ (u[:, k] + part * (u[:, k + 1] - u[:, k])) - K @ x for part in (early, late)]
            slope = lu.solve(np.concatenate(heat))
            x = x + h * (c * slope[:n] + d * slope[n:])
        out[:, k + 1] = x
    return out
