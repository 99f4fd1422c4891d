"""Averages of a temperature field over the elements of each thermal node, and the parts that conduction joins."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from tedm_cli.arrays import BoolArray, FloatArray, IntArray

NONE = -1
"""In no node, or in no part."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Volumes:
    """What each grid of each of E elements stands for of its volume.

    node_offset, node_index : ragged connectivity, [E + 1] and [M] rows of N grids.
    volume : [M], integral of the grid's shape function over the element, m³; less than 0 at corners of some.
    """

    node_offset: IntArray
    node_index: IntArray
    volume: FloatArray

    @property
    def element(self) -> IntArray:
        """The element [M] of each place."""
        return np.repeat(np.arange(len(self.node_offset) - 1), np.diff(self.node_offset))


def averages(of: Volumes, row: IntArray, rows: int, grids: int) -> sp.csr_matrix:
    """Averages by volume [rows, grids] of what is given on grids: the exact mean of what elements interpolate.

    Every row sums to one; it is empty where a row has nothing. Rows have a volume in all.

    Parameters
    ----------
    row : [M], of each place, or `NONE`: all places of an element in one row make the average over the element; those of
        a grid, over what is nearest to it.
    """
    taken = row != NONE
    total = np.bincount(row[taken], of.volume[taken], rows)
    weight = of.volume[taken] / total[row[taken]]
    out = sp.coo_matrix((weight, (row[taken], of.node_index[taken])), shape=(rows, grids)).tocsr()
    sums = np.asarray(out.sum(axis=1)).ravel()
    return sp.csr_matrix(sp.diags(1.0 / np.where(sums == 0.0, 1.0, sums)) @ out)  # what rounding left of one


def conducting_parts(conduction: sp.csr_matrix, grids: BoolArray) -> IntArray:
    """Number [N] from 0 on of the part of each grid that conduction joins; `NONE` of those not among `grids` [N].

    Parameters
    ----------
    conduction : K_c [N, N].
    """
    out = np.full(len(grids), NONE)
    rows = np.flatnonzero(grids)
    if rows.size:
        out[rows] = connected_components(conduction[rows][:, rows], directed=False)[1]
    return out
