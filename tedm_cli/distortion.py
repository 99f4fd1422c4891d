"""Unit loads to the distortion matrix [D]: per-kelvin scaling and the checks that linear elasticity allows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def rigid_motion(
    position: FloatArray, translation: FloatArray, weight: FloatArray, centre: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Best-fit rigid motion of a cloud of grids, weighted by their mass.

    Minimises sum w |u - t - theta x (p - centre)|^2.

    Parameters
    ----------
    position, translation : [N,3], m and m (or m/K), one frame.
    weight : [N], kg.
    centre : [3], m, the point the translation is given at.

    Returns
    -------
    (t [3], theta [3]) : translation at `centre` and small rotation (rad or rad/K).
    """
    arm = position - centre
    cross = np.zeros((len(arm), 3, 3))
    cross[:, 0, 1], cross[:, 0, 2] = arm[:, 2], -arm[:, 1]
    cross[:, 1, 0], cross[:, 1, 2] = -arm[:, 2], arm[:, 0]
    cross[:, 2, 0], cross[:, 2, 1] = arm[:, 1], -arm[:, 0]
    basis = np.concatenate([np.tile(np.eye(3), (len(arm), 1, 1)), cross], axis=2)
    normal = np.einsum("n,nai,naj->ij", weight, basis, basis)
    right = np.einsum("n,nai,na->i", weight, basis, translation)
    solution = np.linalg.solve(normal, right)
    return solution[:3], solution[3:]


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
