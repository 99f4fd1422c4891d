"""Filters of one common phase: several amplitudes from one white input, fully coherent with real cross-spectra.

Filters of minimum phase that differ in size differ in phase as well, and their outputs would not be as correlated as
the temperature model has them. Here all outputs have the phase of the all-pass Π (p_j - s)/(p_j + s) over n real
poles: each is that all-pass times a real even function of s, Σ r_j / (1 - s²/p_j²), which leaves a causal function with
every pole twice. It is found by linear least squares in the Takenaka-Malmquist basis of those poles (Heuberger, Van den
Hof and Wahlberg, Modelling and Identification with Rational Orthogonal Basis Functions, 2005).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Matrix = NDArray[Any]

LARGEST = 32  # poles, each of them twice
_BEYOND = (0.0, 1.0, 2.0)  # nepers that the poles reach beyond the band


def common_phase(frequency_hz: Array, amplitude: Array, tolerance: float) -> tuple[Array, Array, Array, Array, Array]:
    """State space a [n, n], b [n], c [q, n], d [q] for `amplitude` [q, F], and the deviation [q] of each output.

    The deviation is the largest relative one of amplitude and phase together. Poles are added until it is within the
    tolerance; where 32 do not suffice the closest is returned.
    """
    low, high = np.log(2.0 * np.pi * frequency_hz[[0, -1]])
    best: tuple[Array, Array, Array, Array, Array] | None = None
    for number in range(1, LARGEST + 1):
        for beyond in _BEYOND:
            poles = np.exp(np.linspace(low - beyond, high + beyond, number + 2)[1:-1])
            tried = _fitted(poles, frequency_hz, amplitude)
            if best is None or tried[4].max() < best[4].max():
                best = tried
        if best is not None and best[4].max() <= tolerance:
            break
    assert best is not None
    return best


def _fitted(poles: Array, frequency_hz: Array, amplitude: Array) -> tuple[Array, Array, Array, Array, Array]:
    s = 2j * np.pi * frequency_hz
    twice = np.repeat(poles, 2)
    root = np.sqrt(2.0 * twice)
    # x_k' = -p_k x_k + √(2 p_k) u_k, u_(k+1) = u_k - √(2 p_k) x_k: a + aᵀ = -b bᵀ, so the stationary covariance is 1/2.
    a: Array = -np.tril(np.outer(root, root), -1) - np.diag(twice)
    basis, passed = np.ones((len(twice) + 1, len(s)), dtype=complex), np.ones(len(s), dtype=complex)
    for k, p in enumerate(twice):
        basis[k + 1] = root[k] / (s + p) * passed
        passed = passed * (s - p) / (s + p)
    phase = np.prod((poles[:, None] - s) / (poles[:, None] + s), axis=0)
    coefficients = []
    for size in amplitude:
        weighted = basis / size
        found = np.linalg.lstsq(
            np.concatenate([weighted.real, weighted.imag], axis=1).T,
            np.concatenate([phase.real, phase.imag]),
            rcond=None,
        )[0]
        coefficients.append(found)
    c: Array = np.array(coefficients)
    off: Array = np.abs(c @ basis / (amplitude * phase) - 1.0).max(axis=1)
    return a, root, c[:, 1:], c[:, 0], off
