"""Filters of one common phase: several amplitudes from one white input, fully coherent with real cross-spectra.

Filters of minimum phase that differ in size differ in phase as well, and their outputs would not be as correlated as
the temperature model has them. Here all outputs have the phase of the all-pass Π D(-s)/D(s) over some stable
denominators D: each is that all-pass times a real even function of s, N(s) N(-s) / (D(s) D(-s)), which leaves a causal
function with every pole twice. The poles are those of fits of minimum phase to the roots of the amplitudes; given them,
the filters are a linear least-squares problem in their orthonormal basis (Heuberger, Van den Hof and Wahlberg,
Modelling and Identification with Rational Orthogonal Basis Functions, 2005).
"""

from __future__ import annotations

import numpy as np

from tedm_cli.arrays import AnyArray, FloatArray
from tedm_cli.noise.shaping.rational_fit import Roots, minimum_phase

System = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]

_ROUNDS = 6  # of Lawson's reweighting
_ROOM = 0.3  # part of the tolerance that a fit to the root of an amplitude may take


def common_phase(frequency_hz: FloatArray, amplitude: FloatArray, tolerance: float) -> System:
    """State space a [n, n], b [n], c [q, n], d [q] for `amplitude` [q, F], and the deviation [q] of each output.

    The deviation is the largest relative one of amplitude and phase together. Poles of the amplitude that is furthest
    off are added until all are within the tolerance, or all poles there.
    """
    poles, used = Roots((), ()), set[int]()
    while True:
        system = _fitted(poles, frequency_hz, amplitude, tolerance)
        off = system[4].copy()
        off[list(used)] = 0.0
        worst = int(off.argmax())
        if off[worst] <= tolerance:
            return system
        used.add(worst)
        more = minimum_phase(frequency_hz, np.sqrt(amplitude[worst]), _ROOM * tolerance).poles
        poles = Roots(poles.pairs + more.pairs, poles.single + more.single)


def _fitted(poles: Roots, frequency_hz: FloatArray, amplitude: FloatArray, tolerance: float) -> System:
    s = 2j * np.pi * frequency_hz
    a, b, basis, phase = _basis(poles, s)
    c, off = np.empty((len(amplitude), len(basis))), np.full(len(amplitude), np.inf)
    for q, size in enumerate(amplitude):
        weight = np.ones(len(s))
        for _ in range(_ROUNDS):
            scaled, target = basis * (weight / size), phase * weight
            left = np.concatenate([scaled.real, scaled.imag], axis=1).T
            coefficients = np.linalg.lstsq(left, np.concatenate([target.real, target.imag]), rcond=None)[0]
            error = np.abs(coefficients @ basis / (size * phase) - 1.0)
            if error.max() < off[q]:
                c[q], off[q] = coefficients, error.max()
            if off[q] <= tolerance:
                break
            weight = weight * np.sqrt(error / error.max() + 0.03)
    return a, b, c[:, 1:], c[:, 0], off


def _basis(poles: Roots, s: AnyArray) -> tuple[FloatArray, FloatArray, AnyArray, AnyArray]:
    """All-passes of the poles in series, each twice: a, b, responses [1 + n, F] of input and states, and the phase [F].

    Sections x' = a x + b u pass on u - bᵀ x with a + aᵀ = -b bᵀ, as has the whole: its stationary covariance is 1/2.
    """
    sections: list[tuple[FloatArray, FloatArray, AnyArray]] = []
    for w, z in poles.pairs:
        b = np.array([0.0, 2.0 * np.sqrt(z * w)])
        states = b[1] * np.stack([np.full(len(s), w), s]) / (s * s + 2.0 * z * w * s + w * w)
        sections += [(np.array([[0.0, w], [-w, -2.0 * z * w]]), b, states)] * 2
    for w in poles.single:
        b = np.array([np.sqrt(2.0 * w)])
        sections += [(np.array([[-w]]), b, b[:, None] / (s + w))] * 2
    n = sum(len(b) for _, b, _ in sections)
    b_all = np.concatenate([np.empty(0), *(b for _, b, _ in sections)])
    a = np.zeros((n, n))
    passed, phase, rows, i = np.ones(len(s), dtype=complex), np.ones(len(s), dtype=complex), [np.ones((1, len(s)))], 0
    for number, (own, b, states) in enumerate(sections):
        here = slice(i, i + len(b))
        a[here, here], a[here, :i] = own, -np.outer(b, b_all[:i])
        rows.append(states * passed)
        through = 1.0 - b @ states
        passed = passed * through
        if number % 2 == 0:
            phase = phase * through
        i += len(b)
    return a, b_all, np.concatenate(rows), phase
