"""Sampled form of a noise-shaping filter, exact in distribution: transition matrix and factor of the noise covariance.

Van Loan, Computing Integrals Involving the Matrix Exponential, IEEE Trans. Automatic Control 23 (1978), over a step so
short that the exponential is harmless, then doubled on the factor: the covariance over 2h is Q + Φ Q Φᵀ, and its factor
is the triangle of [Φ L, L]. It never loses its sign, however far corner and sampling are apart.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray
from tedm_cli.noise.shaping.shaping_filter import ShapingFilter


@dataclass(frozen=True, eq=False)
class SampledFilter:
    """x[k+1] = a x[k] + b e[k], u[k] = c x[k] + d e[k], e independent standard normal numbers.

    a [n, n], b [n, m], c [q, n], d [q, m]; the stationary covariance of x is that of the continuous filter.
    """

    a: FloatArray
    b: FloatArray
    c: FloatArray
    d: FloatArray


def sampled(continuous: ShapingFilter, step_s: float) -> SampledFilter:
    """The filter at samples `step_s` apart.

    Without direct feed (d = 0) the outputs are those of the continuous filter at the samples. White noise has no value
    at a time: with direct feed the outputs are means over the step that follows the sample, x[k] is the state at its
    start. That leaves a white spectrum as it is and takes sinc²(f step) off the power of a steep one.
    """
    a, b, c, d = continuous.a, continuous.b, continuous.c, continuous.d
    n, q = len(b), len(d)
    if not d.any():
        step, noise = transition(a, b, step_s)
        return SampledFilter(step, noise, c, np.zeros((q, noise.shape[1])))
    wide = np.block([[a, np.zeros((n, q))], [c, np.zeros((q, q))]])  # the last states are integrals of the outputs
    step, noise = transition(wide, np.append(b, d), step_s)
    return SampledFilter(step[:n, :n], noise[:n], step[n:, :n] / step_s, noise[n:] / step_s)


def transition(a: FloatArray, b: FloatArray, step_s: float) -> tuple[FloatArray, FloatArray]:
    """Φ = exp(a h) [n, n], and lower L [n, n] with L Lᵀ = ½ ∫ exp(a t) b bᵀ exp(aᵀ t) dt from 0 to h = `step_s`.

    `b` is [n], or [n, m] of m independent white noises.
    """
    n = len(b)
    b = b.reshape(n, -1)
    if not n:
        return np.zeros((0, 0)), np.zeros((0, 0))
    doublings = max(0, int(np.ceil(np.log2(max(1e-300, float(np.abs(a).sum(axis=0).max()) * step_s)))))
    h = step_s / 2.0**doublings
    block = np.block([[-a, 0.5 * b @ b.T], [np.zeros((n, n)), a.T]])
    exponential = scipy.linalg.expm(block * h)
    phi = exponential[n:, n:].T
    covariance = phi @ exponential[:n, n:]
    # a state far down the cascade receives next to nothing within h; one that no noise reaches has rounding of any sign
    reached = np.diag(covariance) > 0.0
    scale = np.sqrt(np.where(reached, np.diag(covariance), 1.0))
    correlation = 0.5 * (covariance + covariance.T) / np.outer(scale, scale)
    values, vectors = np.linalg.eigh(np.clip(correlation, -1.0, 1.0))
    factor = lower_factor(np.where(reached, scale, 0.0)[:, None] * vectors * np.sqrt(np.maximum(values, 0.0)))
    for _ in range(doublings):
        factor = lower_factor(np.hstack([phi @ factor, factor]))
        phi = phi @ phi
    return phi, factor


def covariance_factor(covariance: FloatArray) -> FloatArray:
    """Lower triangular factor [n, n] of a covariance [n, n]."""
    if not len(covariance):
        return covariance
    scale = np.sqrt(np.diag(covariance))
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    return lower_factor(scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0)))


def lower_factor(factor: FloatArray) -> FloatArray:
    """Lower triangular L [r, min(r, m)] with L Lᵀ = F Fᵀ for F [r, m]."""
    lower: FloatArray = np.transpose(np.linalg.qr(factor.T, mode="r"))
    return lower
