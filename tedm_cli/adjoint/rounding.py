"""How far sums over areas may be off because the solutions of the adjoint are rounded."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.adjoint.areas import Warmed
from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.fem.adjoint import ThermalForces

_BATCH = 16  # areas whose forces are held at a time


def sizes_of_terms(forces: ThermalForces, own: BoolArray, areas: Sequence[Warmed], motion: FloatArray) -> FloatArray:
    """Sums of |f_n| |λ_n| over the grids n, [r, k], of the forces f of each area and the solutions λ [6 N, r].

    The sensitivity is the sum of f_n · λ_n; a relative error of each λ_n changes it by that share of this at most.
    `own` [L]: elements with temperatures of their own in some area.
    """
    n_grids, count = forces.coupling.shape[1], len(own)
    size = _by_three(motion)
    out = np.empty((motion.shape[1], len(areas)))
    for first in range(0, len(areas), _BATCH):
        some = areas[first : first + _BATCH]
        grid, element = np.zeros((n_grids, len(some))), np.zeros((count, 5, len(some)))
        for column, area in enumerate(some):
            grid[area.grid, column] = 1.0
            if area.gradient is None:
                element[area.element, 0, column] = 1.0
            else:
                element[area.element, 1:, column] = np.tile(area.gradient, 2)
        element[own, 0] -= (forces.loads.average @ grid)[own]
        force = forces.coupling @ grid + forces.loads.forces(element.reshape(5 * count, len(some)))
        out[:, first : first + len(some)] = (_by_three(force).T @ size).T
    return out


def _by_three(values: FloatArray) -> FloatArray:
    """Sizes [2 N, m] of translations and rotations, or forces and moments, of values [6 N, m]."""
    return np.asarray(np.linalg.norm(values.reshape(-1, 3, values.shape[1]), axis=1))
