"""Outer search: sizes and places of blocks within their boxes, with the programme of the masses inside.

The field of a block depends on its mass linearly, on its place and size not. So places and sizes are searched by
differential evolution (Storn and Price 1997) from a random start, then polished by the simplex of Nelder and Mead, and
for each of them the masses are those of the linear programme.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray
from tedm_cli.balance.programme import Programme, least_mass, least_ratio

_PENALTY = 10.0  # total masses of all boxes that a ratio of 1 above what is met costs


@dataclass(frozen=True, eq=False)
class Found:
    """The best of what was searched: parameters [p] in their bounds, its objective, and how often it was evaluated."""

    parameter: FloatArray
    objective: float
    evaluations: int


def objective_of(programme: Programme, largest_kg: float) -> float:
    """Total mass where all can be met, kg; above `largest_kg` where not, by how far the worst ratio is from it."""
    found = least_mass(programme)
    if found is not None:
        return found.mass_kg(programme)
    cap = np.full(len(programme.rest), programme.met)
    ratio = least_ratio(programme, cap, programme.reached).ratio
    return largest_kg * (1.0 + _PENALTY * max(ratio - programme.met, 0.0))


def searched(
    objective: Callable[[FloatArray], float],
    low: FloatArray,
    high: FloatArray,
    *,
    seed: int,
    generations: int = 30,
    population: int = 8,
    advance: Callable[[int], None] = lambda _: None,
) -> Found:
    """The least objective of parameters between bounds [p], from a start that the seed draws.

    Parameters
    ----------
    generations, population : of the evolution; the population has so many members for each parameter.
    advance : called with the number of evaluations done since the last call.
    """
    count = 0

    def counted(x: FloatArray) -> float:
        nonlocal count
        count += 1
        advance(1)
        return objective(np.clip(x, low, high))

    found = scipy.optimize.differential_evolution(
        counted,
        list(zip(low, high, strict=True)),
        maxiter=generations,
        popsize=population,
        rng=np.random.default_rng(seed),
        tol=1e-6,
        polish=False,
    )
    width = np.maximum(high - low, 1e-30)
    polished = scipy.optimize.minimize(
        lambda x: counted(low + x * width),
        (found.x - low) / width,
        method="Nelder-Mead",
        options={"xatol": 1e-5, "fatol": 1e-9, "maxfev": 30 * len(low)},
    )
    best = np.clip(low + polished.x * width, low, high) if polished.fun < found.fun else found.x
    return Found(np.asarray(best), float(min(polished.fun, found.fun)), count)
