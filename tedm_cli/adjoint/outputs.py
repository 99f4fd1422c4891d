"""The outputs of the chain as nodal forces and moments: y = g u for any displacement u of the structure."""

from __future__ import annotations

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray


def acceleration_outputs(operator: FloatArray, lever_node: IntArray, rotation: FloatArray) -> FloatArray:
    """Accelerations of the test masses by the motions of all grids, the rows of -G (Montemurro 2004, eqs. 8.5 to 8.9).

    Parameters
    ----------
    operator : [r, N, 3], 1/s² or 1/(m s²), rows of G by the displacements of the grids, basic frame.
    lever_node : [L], rows of the grids whose rotations count.
    rotation : [r, L, 3], m/s² or 1/s² per rad, rows of G by these rotations.

    Returns
    -------
    [6 N, r], per m and rad of the degrees of freedom 6 n + component.
    """
    rows, n_grids, _ = operator.shape
    out = np.zeros((n_grids, 6, rows))
    out[:, :3] = -operator.transpose(1, 2, 0)
    out[lever_node, 3:] = -rotation.transpose(1, 2, 0)
    return out.reshape(6 * n_grids, rows)


def read_out_outputs(gain: FloatArray, axes: FloatArray, node: IntArray, n_grids: int) -> FloatArray:
    """Read-outs by the motions of all grids, O⁻¹ P S_BW (Montemurro 2004, eqs. 10.8 to 10.11) at those of the bench.

    Parameters
    ----------
    gain : [r, 6 E], read-out per m and rad of the E elements on the bench at their grids, layout frame.
    axes : [3, 3], the axes of the layout as rows, basic frame.
    node : [E], rows of the grids that carry the elements; one may carry several.

    Returns
    -------
    [6 N, r], as `acceleration_outputs`.
    """
    rows = len(gain)
    by_grid = (gain.reshape(rows, len(node), 2, 3) @ axes).reshape(rows, len(node), 6)
    out = np.zeros((n_grids, 6, rows))
    np.add.at(out, node, by_grid.transpose(1, 2, 0))
    return out.reshape(6 * n_grids, rows)
