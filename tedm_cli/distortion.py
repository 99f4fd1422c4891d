"""Unit loads to the distortion matrix [D]: per-kelvin scaling and the checks that linear elasticity allows."""

from __future__ import annotations

from typing import Literal

import numpy as np

from tedm_cli.arrays import FloatArray


class RigidFit:
    """Best-fit rigid motion of a cloud of grids, weighted by their mass; the grids may come in parts.

    Minimises sum w |u - t - theta x (p - centre)|^2, whose normal equations need of u no more than sum w u and
    sum w (p - centre) x u.

    Parameters
    ----------
    position : [N,3], m.
    weight : [N], kg.
    centre : [3], m, the point the translation is given at.
    """

    def __init__(self, position: FloatArray, weight: FloatArray, centre: FloatArray) -> None:
        arm = position - centre
        self._weights = np.column_stack([weight, weight[:, None] * arm])
        first = _cross_matrix(self._weights[:, 1:].sum(axis=0))
        second = self._weights[:, 1:].T @ arm
        self._normal = np.block([[weight.sum() * np.eye(3), -first], [first, np.trace(second) * np.eye(3) - second]])

    def moments(self, grids: slice, translation: FloatArray) -> FloatArray:
        """Sums [4,3] of w u and of w (p - centre) times u over some grids, whose `translation` is [n,3], m or m/K."""
        return np.asarray((translation.T @ self._weights[grids]).T)

    def motions(self, moments: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Translations [k,3] at the centre and rotations [k,3] (rad or rad/K), from `moments` [k,4,3] of all grids."""
        twice = moments[:, 1:] - moments[:, 1:].swapaxes(1, 2)
        right = np.column_stack([moments[:, 0], twice[:, 1, 2], twice[:, 2, 0], twice[:, 0, 1]])
        solution = np.linalg.solve(self._normal, right.T).T
        return solution[:, :3], solution[:, 3:]


def _cross_matrix(v: FloatArray) -> FloatArray:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def superposition_residual(total: FloatArray, uniform: FloatArray) -> float:
    """Largest difference between the sum over areas and the uniform load, relative to the largest uniform motion."""
    scale = float(np.abs(uniform).max())
    difference = float(np.abs(total - uniform).max())
    return difference / scale if scale > 0 else difference


def plausible_translation(expansion: FloatArray, position: FloatArray) -> float:
    """Free thermal growth of the whole model, alpha_max x extent (m/K): the scale translations are judged against."""
    alpha = np.abs(expansion[np.isfinite(expansion)])
    extent = float(np.linalg.norm(np.ptp(position, axis=0)))
    return float(alpha.max(initial=0.0)) * extent


#: Half the distance of neighbouring numbers in single precision, over the numbers.
ROUNDING = 2.0**-24
Precision = Literal["single", "double"]
#: What the sum over areas may be off by at a grid, over the sum of the sizes there. Single precision: 16 roundings, of
#: which solvers leave 0.5. Double precision rounds by nothing that matters: what the solution itself may leave.
SUPERPOSITION: dict[Precision, float] = {"single": 16.0 * ROUNDING, "double": 1e-8}
_ANYWHERE = 0.25  # of the same for the grid that moves most, allowed at all others: for what solvers do themselves


def superposition_excess(
    gap: FloatArray, size: FloatArray, floor: float = 0.0, precision: Precision = "single"
) -> FloatArray:
    """Error [n] of the sum over areas at each grid, over what the results' precision allows; above 1 is an error.

    A number of single precision is off by `ROUNDING` of itself, so a sum of k of them by `ROUNDING` of the sum of
    their sizes (N. Higham, Accuracy and Stability of Numerical Algorithms, ch. 4). Allowed are 16 times that, and 4
    times that of the grid that moves most, for the error of the solution itself; of double precision 1e-8 and 2.5e-9.

    Parameters
    ----------
    gap : [n,3], sum over the areas minus the uniform load.
    size : [n], sum over all loads, the uniform one too, of the length of the motion.
    floor : a motion that counts like the largest `size`, where the grids given are not all.
    precision : of the results.
    """
    allowed = SUPERPOSITION[precision] * (size + _ANYWHERE * max(float(size.max(initial=0.0)), floor))
    error = np.linalg.norm(gap, axis=1)
    return np.divide(error, allowed, out=np.where(error > 0.0, np.inf, 0.0), where=allowed > 0.0)
