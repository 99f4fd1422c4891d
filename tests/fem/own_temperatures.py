"""Temperatures of elements for the tests of their loads."""

from __future__ import annotations

import numpy as np

from tedm_cli.fem.static import StaticSolution
from tedm_cli.fem.structure import ElementTemperatures, LoadCase

GRADIENT = 200.0  # K/m


def own(element_id, mean=0.0, gradient=0.0) -> ElementTemperatures:
    """Temperatures of elements; `mean` for all or [m, 2], `gradient` along the normal or [m, 2, 2]."""
    m = len(element_id)
    across = np.zeros((m, 2, 2))
    if np.ndim(gradient) < 3:
        across[:, :, 0] = np.broadcast_to(np.asarray(gradient, float).reshape(-1, 1), (m, 2))
    else:
        across[:] = gradient
    means = np.broadcast_to(np.asarray(mean, float), (m, 2)).copy()
    return ElementTemperatures(element_id=np.asarray(element_id), mean=means, gradient=across)


def motions(model, *cases, rest=0.0):
    """Motions [cases, N, 6] of temperatures of elements, with the grids at `rest`; and the solution."""
    solution = StaticSolution(model)
    field = np.broadcast_to(np.asarray(rest, float), model.n_grids).copy()
    loads = [LoadCase(id=k, label="", temperature=field, elements=case) for k, case in enumerate(cases, 1)]
    return np.array([motion for _, motion in solution.solve(loads)]), solution


def part(corners, block):
    return {"quads" if corners == 4 else "trias": block}
