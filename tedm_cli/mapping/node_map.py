"""From temperatures of thermal nodes to those of grids, and back from sensitivities: by conduction, or as they are."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import scipy.sparse as sp

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.fem.linear import SolverName
from tedm_cli.mapping.averages import NONE, Volumes, averages
from tedm_cli.mapping.prescribed import DependentAverages, PrescribedAverages


class NodeMap(Protocol):
    """A linear map P [N, n] from n thermal nodes to N grids."""

    nodes: int

    @property
    def mapped(self) -> BoolArray:
        """Which grids [N] have a temperature."""

    def temperatures(self, tau: FloatArray) -> FloatArray:
        """P τ [N, m] of m sets of temperatures [n, m]; NaN of grids that are not mapped."""

    def sensitivities(self, s: FloatArray) -> FloatArray:
        """sᵀ P [r, n] of r outputs by the temperatures of the grids [r, N]."""


class DependentNodes(Exception):
    """Thermal nodes whose averages others fix, by their numbers."""

    def __init__(self, nodes: IntArray) -> None:
        super().__init__()
        self.nodes = nodes


class ConductedMap:
    """The field with the nodes' temperatures as averages over their elements that conduction chooses.

    several : [k], nodes that are in more than one part: their temperature is the average in each of them.

    Parameters
    ----------
    conduction : K_c [N, N], W/K.
    of : volumes of the elements, at M places.
    place_node : [M], node of each place, or `NONE`. nodes : n, each with a volume in every part that it is in.
    part : [N], of each grid, see `conducting_parts`; `NONE` of those that are to be left out. Parts without an element
        of a node are not allowed.

    Raises
    ------
    DependentNodes : nodes whose averages others fix.
    PhysicsError : the library that factorises gives up.
    """

    def __init__(
        self,
        conduction: sp.csr_matrix,
        of: Volumes,
        place_node: IntArray,
        nodes: int,
        part: IntArray,
        solver: SolverName = "auto",
    ) -> None:
        self.nodes = nodes
        self._part = part
        taken = np.flatnonzero(place_node != NONE)
        both = np.column_stack([place_node[taken], part[of.node_index[taken]]])
        pairs, row = np.unique(both, axis=0, return_inverse=True)
        place_row = np.full(len(place_node), NONE)
        place_row[taken] = row.reshape(-1)
        self.node_of_row = pairs[:, 0]
        self.several = np.flatnonzero(np.bincount(pairs[:, 0], minlength=nodes) > 1)
        self.average = averages(of, place_node, nodes, len(part))
        rows = averages(of, place_row, len(pairs), len(part))
        try:
            self._prescribed = PrescribedAverages(conduction, rows, part, solver)
        except DependentAverages as exc:
            raise DependentNodes(self.node_of_row[exc.rows]) from exc
        self.solver = self._prescribed.solver

    @property
    def mapped(self) -> BoolArray:
        return np.asarray(self._part != NONE)

    def temperatures(self, tau: FloatArray) -> FloatArray:
        return self._prescribed.temperatures(tau[self.node_of_row])

    def sensitivities(self, s: FloatArray) -> FloatArray:
        out = np.zeros((len(s), self.nodes))
        np.add.at(out.T, self.node_of_row, self._prescribed.sensitivities(s).T)
        return out


class WeightedMap:
    """The weighted means of nodes on all grids of an area.

    Parameters
    ----------
    weights : sparse [N, n]; rows sum to one, or are empty where a grid is in none of the areas.
    """

    def __init__(self, weights: sp.csr_matrix) -> None:
        self.weights = weights
        self.nodes = weights.shape[1]

    @property
    def mapped(self) -> BoolArray:
        return np.asarray(np.diff(self.weights.indptr) > 0)

    def temperatures(self, tau: FloatArray) -> FloatArray:
        out = np.asarray(self.weights @ tau)
        out[~self.mapped] = np.nan
        return out

    def sensitivities(self, s: FloatArray) -> FloatArray:
        return np.asarray((self.weights.T @ s.T).T)
