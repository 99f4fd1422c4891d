"""Rational functions of minimum phase whose size follows a given amplitude spectral density.

The size of H(s) = g Π q_z(s) / Π q_p(s), with q = 1 + 2ζ s/ω + (s/ω)² or 1 + s/ω, is fitted on logarithmic axes over
log ω and log ζ. Every such H has its poles and zeros in the left half plane, whatever the values.
Starting values are the straight-line approximation of Bode's diagrams (Network Analysis and Feedback Amplifier Design,
1945): a staircase of whole slopes that follows the slope of the target. Lawson's reweighting takes the least squares
towards the least largest error; then roots are taken away as long as the tolerance is kept, or added
where the fit is worst.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from tedm_cli.arrays import FloatArray

LARGEST_ORDER = 24
_ROUNDS = 8  # of Lawson's reweighting
_HOPELESS = 6.0  # a least-squares fit this many tolerances off is not reweighted
_BEYOND = 4.0  # corners stay within e^±4 of the band
_DAMPING = (0.02, 50.0)
_STEEPEST = 6  # slope at the low end that roots below the band are taken for
_WORTH = 0.98  # a pole and a zero more must better the error by 2 %
_STEPS = np.geomspace(2.0, 0.03, 24)  # errors of the staircase, nepers


@dataclass(frozen=True)
class Roots:
    """Roots in the left half plane: pairs (ω, ζ) and real ones (ω), ω in rad/s, positive."""

    pairs: tuple[tuple[float, float], ...]
    single: tuple[float, ...]

    def __len__(self) -> int:
        return 2 * len(self.pairs) + len(self.single)

    def split(self) -> tuple[list[float], list[tuple[float, float]]]:
        """All real roots, those of overdamped pairs included, ascending, and the pairs that are complex."""
        real, pairs = list(self.single), []
        for w, z in self.pairs:
            if z >= 1.0:
                far = z + np.sqrt(z * z - 1.0)
                real += [w * far, w / far]
            else:
                pairs.append((w, z))
        return sorted(real), pairs


@dataclass(frozen=True)
class Rational:
    """H(s) of unit g at s = 0 times `gain`; `error` is its largest relative deviation in size from the target."""

    gain: float
    zeros: Roots
    poles: Roots
    error: float

    def size(self, frequency_hz: FloatArray) -> FloatArray:
        """|H| [F]."""
        counts = (len(self.zeros.pairs), len(self.zeros.single)), (len(self.poles.pairs), len(self.poles.single))
        flat = [v for r in (self.zeros, self.poles) for v in (*(x for pair in r.pairs for x in pair), *r.single)]
        size: FloatArray = np.exp(_log_size(np.log([self.gain, *flat]), 2.0 * np.pi * frequency_hz, *counts)[0])
        return size


def minimum_phase(frequency_hz: FloatArray, amplitude: FloatArray, tolerance: float) -> Rational:
    """Stable rational function of few poles with | |H(2πif)| / `amplitude` [F] - 1 | <= `tolerance`.

    It is proper, and strictly so where the amplitude falls at the end of the band. Where none of up to 24 poles is
    found the closest one is returned; its `error` says so.
    """
    found: Rational | None = None
    for poles, zeros in _staircases(np.log(frequency_hz), np.log(amplitude)):
        tried = _fit(frequency_hz, amplitude, _paired(poles), _paired(zeros), tolerance)
        if found is None or tried.error < found.error:
            found = tried
        if found.error <= tolerance:
            break
    assert found is not None  # a staircase without steps is always there
    while found.error > tolerance and len(found.poles) < LARGEST_ORDER:
        tried = min(
            (_fit(frequency_hz, amplitude, p, z, tolerance) for p, z in _more(found, frequency_hz, amplitude)),
            key=lambda r: r.error,
        )
        if tried.error > _WORTH * found.error:
            break
        found = tried
    return _pruned(found, frequency_hz, amplitude, tolerance) if found.error <= tolerance else found


def _excess(x: FloatArray, y: FloatArray) -> int:
    """Least number of poles more than zeros: one where y falls at its end, for a finite variance."""
    outward = max(-6, -len(x))
    return int((y[-1] - y[outward]) / (x[-1] - x[outward]) < -0.5)


def _more(found: Rational, frequency_hz: FloatArray, amplitude: FloatArray) -> Iterator[tuple[Roots, Roots]]:
    """Poles and zeros with one more of each where the size is furthest off, or beside it."""
    p, pp = found.poles.split()
    z, zz = found.zeros.split()
    error = np.log(found.size(frequency_hz) / amplitude)
    worst = 2.0 * np.pi * float(frequency_hz[np.argmax(np.abs(error))])
    for width in (1.1, 1.6):
        for up in (width, 1.0 / width):
            yield _paired([*p, worst * up], pp), _paired([*z, worst / up], zz)


def _staircases(x: FloatArray, y: FloatArray) -> Iterator[tuple[list[float], list[float]]]:
    """Poles and zeros, rad/s, of straight-line approximations of y(x) with ever more roots."""
    seen: set[tuple[int, int]] = set()
    excess = _excess(x, y)
    inward = min(5, len(x) - 1)
    first = int(np.clip(round((y[inward] - y[0]) / (x[inward] - x[0])), -_STEEPEST, _STEEPEST))
    for step in (np.inf, *_STEPS):
        below = [float(np.exp(x[0])) / 5.0] * abs(first)
        poles, zeros = (below, []) if first < 0 else ([], below)
        slope, error = first, 0.0
        for i in range(1, len(x)):
            error += slope * (x[i] - x[i - 1]) - (y[i] - y[i - 1])
            if error > step:
                poles, slope = [*poles, float(np.exp(x[i]))], slope - 1
            elif error < -step:
                zeros, slope = [*zeros, float(np.exp(x[i]))], slope + 1
        poles += [5.0 * float(np.exp(x[-1]))] * (len(zeros) + excess - len(poles))
        if len(poles) <= LARGEST_ORDER and (len(poles), len(zeros)) not in seen:
            seen.add((len(poles), len(zeros)))
            yield [2.0 * np.pi * f for f in poles], [2.0 * np.pi * f for f in zeros]


def _paired(real: list[float], pairs: list[tuple[float, float]] | None = None) -> Roots:
    """Real roots as overdamped pairs of neighbours, so that a fit can make them complex."""
    real = sorted(real)
    even = len(real) - len(real) % 2
    made = [
        (float(np.sqrt(a * b)), float((a + b) / (2.0 * np.sqrt(a * b))))
        for a, b in zip(real[:even:2], real[1:even:2], strict=True)
    ]
    return Roots((*(pairs or ()), *made), tuple(real[even:]))


def _log_size(
    theta: FloatArray, omega: FloatArray, zeros: tuple[int, int], poles: tuple[int, int]
) -> tuple[FloatArray, FloatArray]:
    """log |H| [F] and its derivative [F, θ] by θ = log g, then log ω, log ζ of pairs and log ω of single roots."""
    size, slope = np.full(len(omega), theta[0]), np.ones((len(omega), len(theta)))
    i = 1
    for sign, (pairs, single) in ((0.5, zeros), (-0.5, poles)):
        for _ in range(pairs):
            r, z2 = (omega / np.exp(theta[i])) ** 2, np.exp(2.0 * theta[i + 1])
            q = (1.0 - r) ** 2 + 4.0 * z2 * r
            size += sign * np.log(q)
            slope[:, i] = -sign * 4.0 * r * (r - 1.0 + 2.0 * z2) / q
            slope[:, i + 1] = sign * 8.0 * z2 * r / q
            i += 2
        for _ in range(single):
            r = (omega / np.exp(theta[i])) ** 2
            size += sign * np.log1p(r)
            slope[:, i] = -sign * 2.0 * r / (1.0 + r)
            i += 1
    return size, slope


def _fit(frequency_hz: FloatArray, amplitude: FloatArray, poles: Roots, zeros: Roots, tolerance: float) -> Rational:
    omega, target = 2.0 * np.pi * frequency_hz, np.log(amplitude)
    counts = (len(zeros.pairs), len(zeros.single)), (len(poles.pairs), len(poles.single))
    edge = (np.log(omega[0]) - _BEYOND, np.log(omega[-1]) + _BEYOND)
    damping = (np.log(_DAMPING[0]), np.log(_DAMPING[1]))
    start, bounds = [0.0], [(-np.inf, np.inf)]
    for roots in (zeros, poles):
        for w, z in roots.pairs:
            start, bounds = [*start, np.log(w), np.log(z)], [*bounds, edge, damping]
        for w in roots.single:
            start, bounds = [*start, np.log(w)], [*bounds, edge]
    low, high = np.array(bounds).T
    theta = np.clip(np.array(start), low + 1e-9, high - 1e-9)
    theta[0] = float(np.mean(target - _log_size(theta, omega, *counts)[0]))
    weight, best, least = np.ones(len(omega)), theta, np.inf
    for _ in range(_ROUNDS):

        def off(t: FloatArray, w: FloatArray = weight) -> FloatArray:
            weighted: FloatArray = (_log_size(t, omega, *counts)[0] - target) * w
            return weighted

        def slope(t: FloatArray, w: FloatArray = weight) -> FloatArray:
            weighted: FloatArray = _log_size(t, omega, *counts)[1] * w[:, None]
            return weighted

        theta = least_squares(off, theta, slope, (low, high), max_nfev=80).x
        error = _log_size(theta, omega, *counts)[0] - target
        largest = float(np.abs(np.expm1(error)).max())
        if largest < least:
            best, least = theta, largest
        if least <= tolerance or largest > _HOPELESS * tolerance:
            break
        weight = weight * np.sqrt(np.abs(error) / np.abs(error).max() + 0.03)
        weight /= np.sqrt(np.mean(weight**2))
    return _rational(best, *counts, least)


def _rational(theta: FloatArray, zeros: tuple[int, int], poles: tuple[int, int], error: float) -> Rational:
    values = np.exp(theta).tolist()
    i, found = 1, []
    for pairs, single in (zeros, poles):
        both = values[i : i + 2 * pairs]
        i += 2 * pairs
        found.append(Roots(tuple(zip(both[::2], both[1::2], strict=True)), tuple(values[i : i + single])))
        i += single
    return Rational(values[0], found[0], found[1], error)


def _pruned(found: Rational, frequency_hz: FloatArray, amplitude: FloatArray, tolerance: float) -> Rational:
    """Without the roots that are not needed."""
    excess, again = _excess(np.log(frequency_hz), np.log(amplitude)), True
    while again:
        again = False
        for poles, zeros in _fewer(found.poles, found.zeros, excess):
            tried = _fit(frequency_hz, amplitude, poles, zeros, tolerance)
            if tried.error <= tolerance:
                found, again = tried, True
                break
    return found


def _fewer(poles: Roots, zeros: Roots, excess: int) -> Iterator[tuple[Roots, Roots]]:
    """Functions with a pole less, still `excess` more than zeros: without roots that nearly cancel, or at the ends."""
    p, pp = poles.split()
    z, zz = zeros.split()
    near = sorted((abs(np.log(a / b)), i, j) for i, a in enumerate(p) for j, b in enumerate(z))
    for _, i, j in near[:2]:
        yield _paired(p[:i] + p[i + 1 :], pp), _paired(z[:j] + z[j + 1 :], zz)
    near = sorted((abs(np.log(a[0] / b[0])), i, j) for i, a in enumerate(pp) for j, b in enumerate(zz))
    for _, i, j in near[:2]:
        yield _paired(p, pp[:i] + pp[i + 1 :]), _paired(z, zz[:j] + zz[j + 1 :])
    if len(poles) > len(zeros) + excess:
        yield from ((_paired(end, pp), _paired(z, zz)) for end in (p[1:], p[:-1]) if p)
