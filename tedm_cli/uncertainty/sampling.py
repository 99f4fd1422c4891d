"""Draws of independent variables that are uniform in (0, 1): for probabilities, and for shares of variance."""

from __future__ import annotations

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray


def latin_hypercube(samples: int, dimensions: int, seed: int) -> FloatArray:
    """A Latin hypercube [samples, dimensions].

    The variance of a mean over it is at most samples / (samples - 1) times that of independent draws, whatever is
    averaged (Owen 1997): standard errors of independent draws are an upper bound.
    """
    if not dimensions:
        return np.zeros((samples, 0))
    engine = scipy.stats.qmc.LatinHypercube(dimensions, rng=np.random.default_rng(seed))
    return np.asarray(engine.random(samples), dtype=np.float64)


def two_sets(power: int, dimensions: int, seed: int) -> tuple[FloatArray, FloatArray]:
    """Two independent sets [2^power, dimensions] of scrambled Sobol' points, for `scipy.stats.sobol_indices`."""
    engine = scipy.stats.qmc.Sobol(2 * dimensions, rng=np.random.default_rng(seed))
    both = np.asarray(engine.random_base2(power), dtype=np.float64)
    return both[:, :dimensions], both[:, dimensions:]
