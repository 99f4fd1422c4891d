"""The thermal network: nodes joined by linear and radiative conductors.

Heat from i to j: GL (T_i - T_j) + σ GR (T_i⁴ - T_j⁴), in W; temperatures in K.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from tedm_cli.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from tedm_cli.errors import InputError

STEFAN_BOLTZMANN = 5.670374419e-8  # W m⁻² K⁻⁴, CODATA 2018
DIFFUSIVE, ARITHMETIC, BOUNDARY = "diffusive", "arithmetic", "boundary"
_SHOWN = 5


@dataclass(frozen=True, eq=False)
class ThermalNetwork:
    """Nodes and conductors.

    Parameters
    ----------
    name : [n], no two the same.
    kind : [n] of str: diffusive, arithmetic (no capacity) or boundary (its temperature is given).
    capacity : [n], J/K; above 0 of diffusive nodes, 0 of arithmetic ones, of no effect at boundaries.
    power : [n], W, constant heat put into the nodes.
    node_a, node_b : [m], rows of the nodes that each conductor joins; several may join the same two.
    linear : [m], GL in W/K, not negative. radiative : [m], GR in m², not negative.
    """

    name: tuple[str, ...]
    kind: AnyArray
    capacity: FloatArray
    power: FloatArray
    node_a: IndexArray
    node_b: IndexArray
    linear: FloatArray
    radiative: FloatArray

    def __len__(self) -> int:
        return len(self.name)

    @cached_property
    def boundary(self) -> BoolArray:
        """[n]: the nodes whose temperature the network does not change."""
        return np.asarray(self.kind == BOUNDARY)

    @cached_property
    def free(self) -> IndexArray:
        """Rows [n_free] of diffusive and arithmetic nodes, ascending."""
        return np.flatnonzero(~self.boundary)

    @cached_property
    def row(self) -> dict[str, int]:
        """Row of each node, by name."""
        return {name: row for row, name in enumerate(self.name)}

    def net_heat(self, temperature_K: FloatArray) -> FloatArray:
        """[n] in W: heat that conductors bring to each node, and its power; 0 at free nodes in a steady state."""
        a, b = temperature_K[self.node_a], temperature_K[self.node_b]
        flow = self.linear * (a - b) + STEFAN_BOLTZMANN * self.radiative * (a**4 - b**4)
        n = len(self)
        arriving = np.bincount(self.node_b, flow, n) - np.bincount(self.node_a, flow, n)
        return np.asarray(self.power + arriving)

    def gross_heat(self, temperature_K: FloatArray) -> FloatArray:
        """[n] in W: the terms that `net_heat` sums, by their sizes; times the rounding of a number, its error."""
        a, b = temperature_K[self.node_a], temperature_K[self.node_b]
        size = self.linear * (abs(a) + abs(b)) + STEFAN_BOLTZMANN * self.radiative * (a**4 + b**4)
        n = len(self)
        return np.asarray(abs(self.power) + np.bincount(self.node_a, size, n) + np.bincount(self.node_b, size, n))

    def conductance(self, temperature_K: FloatArray) -> scipy.sparse.csc_array:
        """K [n, n] in W/K, with net heat falling by K δT: K_ii = Σ (GL + 4 σ GR T_i³), K_ij = -(GL + 4 σ GR T_j³).

        Not symmetric where there is radiation between different temperatures. Columns sum to zero.
        """
        rate = 4.0 * STEFAN_BOLTZMANN * temperature_K**3
        of_a = self.linear + self.radiative * rate[self.node_a]  # by a's temperature
        of_b = self.linear + self.radiative * rate[self.node_b]
        row = np.concatenate([self.node_a, self.node_b, self.node_b, self.node_a])
        column = np.concatenate([self.node_a, self.node_b, self.node_a, self.node_b])
        value = np.concatenate([of_a, of_b, -of_a, -of_b])
        return scipy.sparse.csc_array((value, (row, column)), shape=(len(self), len(self)))

    def require_reached(self, *, where: str) -> None:
        """Refuse a network without boundaries or free nodes, or with nodes that no conductor leads to a boundary from.

        Raises
        ------
        InputError : names them.
        """
        if not self.boundary.any():
            fact = "no node is a boundary, so no temperature follows"
            raise InputError(fact, where=where, hint="give deep space, or what the network is fixed to, as a boundary")
        if not len(self.free):
            raise InputError("all nodes are boundaries, so nothing is to be found", where=where)
        joins = (self.linear > 0.0) | (self.radiative > 0.0)
        ones = np.ones(int(joins.sum()), dtype=np.int8)
        graph = scipy.sparse.coo_array(
            (ones, (self.node_a[joins], self.node_b[joins])), shape=(len(self), len(self))
        ).tocsr()
        _, part = scipy.sparse.csgraph.connected_components(graph, directed=False)
        held = np.isin(part, part[self.boundary])
        if not held.all():
            lost = [self.name[i] for i in np.flatnonzero(~held)]
            more = f" and {len(lost) - _SHOWN} more" if len(lost) > _SHOWN else ""
            nodes = "node" if len(lost) == 1 else "nodes"
            raise InputError(
                f"no conductor leads to a boundary from {nodes} {', '.join(lost[:_SHOWN])}{more}",
                where=where,
                hint="give the conductors that are missing, or leave the nodes out",
            )


def selected(matrix: scipy.sparse.csc_array, rows: IndexArray, columns: IndexArray) -> scipy.sparse.csc_array:
    """The rows and columns of a sparse matrix, in this order."""
    return matrix[:, columns].tocsr()[rows].tocsc()
