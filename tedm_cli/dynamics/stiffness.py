"""Stiffness by source: gravity of all that moves with the spacecraft, electrostatics, and the other test mass."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray
from tedm_cli.dynamics.presets import TOTAL_STIFFNESS_S2


def gravity_stiffness(
    gamma_lin: FloatArray, gamma_ang: FloatArray, omega_lin: FloatArray, omega_ang: FloatArray
) -> FloatArray:
    """[Γ_lin Γ_ang; Ω_lin Ω_ang] [..., 6, 6] of blocks [..., 3, 3], per mass and moment, test mass frame."""
    top = np.concatenate([gamma_lin, gamma_ang], axis=-1)
    return np.concatenate([top, np.concatenate([omega_lin, omega_ang], axis=-1)], axis=-2)


def mutual_stiffness(linearised: FloatArray, gravity_fixed: Sequence[FloatArray]) -> FloatArray:
    """[12, 12]: the linearised gravity less that of the fixed sources on their own test mass."""
    return np.asarray(linearised - scipy.linalg.block_diag(*gravity_fixed))


def electrostatic_to_total(gravity: FloatArray, total: Sequence[float] = TOTAL_STIFFNESS_S2) -> FloatArray:
    """Electrostatic stiffness [2, 6, 6] that brings the diagonal of `gravity` [2, 6, 6] to `total` [6], 1/s².

    Electrostatics moves with its housing, which no file holds: it acts as if the housing stood still in the spacecraft.
    """
    out = np.zeros((2, 6, 6))
    for own, fixed in zip(out, gravity, strict=True):
        own[range(6), range(6)] = np.array(total) - np.diag(fixed)
    return out
