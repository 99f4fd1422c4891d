"""Division by a tensor of inertia."""

from __future__ import annotations

import numpy as np

from tedm_cli.arrays import FloatArray


def divided_by_inertia(inertia: FloatArray, torque: FloatArray, axis: int = -1) -> FloatArray:
    """``I⁻¹ T`` with I [3, 3] symmetric, for torques whose components run along `axis`.

    Along principal axes each component is divided by its moment, without the others entering by rounding.
    """
    moved = np.moveaxis(torque, axis, -1)
    moments = np.diag(inertia)
    if (inertia == np.diag(moments)).all():
        return np.moveaxis(moved / moments, -1, axis)
    return np.moveaxis(np.linalg.solve(inertia, moved[..., None])[..., 0], -1, axis)
