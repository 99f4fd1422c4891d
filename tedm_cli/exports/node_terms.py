"""What each grid contributes to an output: fields of several unit loads at once, contracted with the operator."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.files.blocks import Blocks, node_blocks


def superposed(
    dataset: Blocks, weights: FloatArray, advance: Callable[[int], None] = lambda _: None, per: FloatArray | None = None
) -> FloatArray:
    """Sums [m, n, 3] of the areas' fields in a dataset [k, n, 3], each with `weights` [m, k]; read piece by piece.

    Areas without weight are not read. `per` [k] divides the fields (loads in kelvin); `advance` is called with the
    number of vectors read.
    """
    n = dataset.shape[1]
    out = np.zeros((len(weights), n, 3))
    scaled = weights if per is None else weights / per
    needed = np.flatnonzero(weights.any(axis=0)).tolist()
    for block in node_blocks(n):
        for area in needed:
            field = dataset[area, block]
            for row in np.flatnonzero(scaled[:, area]).tolist():
                out[row, block] += scaled[row, area] * field
            advance(block.stop - block.start)
    return out


def gradient(operator: Blocks, rows: Sequence[tuple[float, int]]) -> FloatArray:
    """-G [n, 3] of a sum of rows of an operator [rows, n, 3], each with its coefficient: what a displacement adds."""
    out = np.zeros(operator.shape[1:])
    for block in node_blocks(len(out)):
        for coefficient, row in rows:
            out[block] -= coefficient * operator[row, block]
    return out
