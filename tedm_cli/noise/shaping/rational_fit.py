"""Rational functions of minimum phase whose size follows a given amplitude spectral density.

The size of H(s) = g Π q_z(s) / Π q_p(s), with q = 1 + 2ζ s/ω + (s/ω)² for a pair of roots or 1 + s/ω for a single one,
is fitted to the target on logarithmic axes. The parameters are log g, log ω and log ζ: whatever their values, ω and ζ
are positive, so every such H has its poles and zeros in the left half plane (`Form` puts them into one vector).

The search for few roots (`minimum_phase`) has three steps:

1. Starting values are the straight-line approximation of Bode's diagrams (Network Analysis and Feedback Amplifier
   Design, 1945): a staircase of whole slopes that follows the slope of the target. Coarse staircases come first; the
   first whose fit is within the tolerance is taken.
2. Where none is, a pole and a zero are added where the fit is worst, as long as that helps.
3. Where one is, roots are taken away again as long as the tolerance is kept.

Each fit (`_fit`) is one of least squares that Lawson's reweighting takes towards the least largest error.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray

LARGEST_ORDER = 24  # poles at most

# The fit.
_ROUNDS = 8  # of Lawson's reweighting at most
_EVALUATIONS = 80  # of each least-squares fit
_HOPELESS = 6.0  # a fit this many tolerances off is given up: reweighting gains less than that
_LEAST_WEIGHT = 0.03  # share of the largest error that is added to all, so that no frequency is ever forgotten
_BEYOND = 4.0  # corners stay within e^±4, under two decades, of the band: further out they only change its gain
_DAMPING = (0.02, 50.0)  # ζ of pairs: from a resonance of 28 dB to two real roots four decades apart
_INSIDE = 1e-9  # starting values are this far inside the bounds, as the solver asks for

# The starting values.
_STEPS = np.geomspace(2.0, 0.03, 24)  # largest errors of the staircases, nepers: from a factor of 7 to 3 %
_STEEPEST = 6  # steepest slope at the low end of the band, f^±6, that is made by roots below it
_OUTSIDE = 5.0  # roots that are to act outside the band start at this factor from its end

# More and fewer roots.
_WORTH = 0.98  # a pole and a zero more must better the error by 2 %
_APART = (1.1, 1.6)  # factors between the frequency of the worst error and a new root on either side of it
_CLOSEST = 2  # of the pairs of a pole and a zero that nearly cancel, as many are tried without


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
class Form:
    """How many roots H has, and with that what each of its parameters is.

    The vector θ [1 + number of roots] is log g, then for the zeros log ω and log ζ of each pair and log ω of each
    single root, then the same for the poles. `zeros` and `poles` are (number of pairs, number of single roots).
    """

    zeros: tuple[int, int]
    poles: tuple[int, int]

    @classmethod
    def of(cls, zeros: Roots, poles: Roots) -> Form:
        """Form of a function with these roots."""
        return cls((len(zeros.pairs), len(zeros.single)), (len(poles.pairs), len(poles.single)))

    @staticmethod
    def parameters(gain: float, zeros: Roots, poles: Roots) -> FloatArray:
        """θ of the function with this gain and these roots."""
        values = [gain]
        for roots in (zeros, poles):
            values += [v for pair in roots.pairs for v in pair]
            values += roots.single
        return np.asarray(np.log(values))

    def rational(self, theta: FloatArray, error: float) -> Rational:
        """The function with the parameters θ; `error` is what it is known to be off."""
        values = np.exp(theta).tolist()
        start, roots = 1, []
        for pairs, single in (self.zeros, self.poles):
            middle = start + 2 * pairs
            end = middle + single
            of_pairs = tuple(zip(values[start:middle:2], values[start + 1 : middle : 2], strict=True))
            roots.append(Roots(of_pairs, tuple(values[middle:end])))
            start = end
        return Rational(values[0], roots[0], roots[1], error)

    def bounds(self, omega: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest θ of a fit over the angular frequencies `omega` [F]; the gain is free."""
        corner = (np.log(omega[0]) - _BEYOND, np.log(omega[-1]) + _BEYOND)
        damping = (np.log(_DAMPING[0]), np.log(_DAMPING[1]))
        limits = [(-np.inf, np.inf)]
        for pairs, single in (self.zeros, self.poles):
            limits += [corner, damping] * pairs + [corner] * single
        low, high = np.array(limits).T
        return low, high

    def log_size(self, theta: FloatArray, omega: FloatArray) -> tuple[FloatArray, FloatArray]:
        """log |H| [F] at `omega` [F], rad/s, and its derivative [F, θ]."""
        size, slope = np.full(len(omega), theta[0]), np.ones((len(omega), len(theta)))
        i = 1
        for sign, (pairs, single) in ((0.5, self.zeros), (-0.5, self.poles)):  # log |q| is half of log |q|²
            for _ in range(pairs):
                # |q|² = (1 - r)² + 4 ζ² r with r = (f/f_0)²
                r, z2 = (omega / np.exp(theta[i])) ** 2, np.exp(2.0 * theta[i + 1])
                q = (1.0 - r) ** 2 + 4.0 * z2 * r
                size += sign * np.log(q)
                slope[:, i] = -sign * 4.0 * r * (r - 1.0 + 2.0 * z2) / q
                slope[:, i + 1] = sign * 8.0 * z2 * r / q
                i += 2
            for _ in range(single):
                # |q|² = 1 + r
                r = (omega / np.exp(theta[i])) ** 2
                size += sign * np.log1p(r)
                slope[:, i] = -sign * 2.0 * r / (1.0 + r)
                i += 1
        return size, slope


@dataclass(frozen=True)
class Rational:
    """H(s) of unit g at s = 0 times `gain`; `error` is its largest relative deviation in size from the target."""

    gain: float
    zeros: Roots
    poles: Roots
    error: float

    def size(self, frequency_hz: FloatArray) -> FloatArray:
        """|H| [F]."""
        theta = Form.parameters(self.gain, self.zeros, self.poles)
        size: FloatArray = np.exp(Form.of(self.zeros, self.poles).log_size(theta, 2.0 * np.pi * frequency_hz)[0])
        return size


@dataclass(frozen=True, eq=False)
class _Target:
    """What is to be fitted: `amplitude` [F] at `frequency_hz` [F], ascending, to a relative `tolerance`."""

    frequency_hz: FloatArray
    amplitude: FloatArray
    tolerance: float

    @cached_property
    def omega(self) -> FloatArray:
        """Angular frequency [F], rad/s."""
        return np.asarray(2.0 * np.pi * self.frequency_hz)

    @cached_property
    def log_frequency(self) -> FloatArray:
        return np.asarray(np.log(self.frequency_hz))

    @cached_property
    def log_amplitude(self) -> FloatArray:
        return np.asarray(np.log(self.amplitude))

    def mean_slope(self, first: int, last: int) -> float:
        """Slope on logarithmic axes between two of the points."""
        rise = self.log_amplitude[last] - self.log_amplitude[first]
        return float(rise / (self.log_frequency[last] - self.log_frequency[first]))

    @cached_property
    def excess(self) -> int:
        """Least number of poles more than zeros: one where the amplitude falls at its end, for a finite variance."""
        inward = max(-6, -len(self.frequency_hz))
        return int(self.mean_slope(inward, -1) < -0.5)


def minimum_phase(frequency_hz: FloatArray, amplitude: FloatArray, tolerance: float) -> Rational:
    """Stable rational function of few poles with | |H(2πif)| / `amplitude` [F] - 1 | <= `tolerance`.

    It is proper, and strictly so where the amplitude falls at the end of the band. Where none of up to 24 poles is
    found the closest one is returned; its `error` says so.
    """
    target = _Target(frequency_hz, amplitude, tolerance)
    best: Rational | None = None
    for poles, zeros in _staircases(target):
        tried = _fit(target, _paired(poles), _paired(zeros))
        if best is None or tried.error < best.error:
            best = tried
        if best.error <= tolerance:
            break
    assert best is not None  # a staircase without steps is always there
    while best.error > tolerance and len(best.poles) < LARGEST_ORDER:
        tried = min((_fit(target, p, z) for p, z in _more(best, target)), key=lambda r: r.error)
        if tried.error > _WORTH * best.error:
            break
        best = tried
    return _pruned(best, target) if best.error <= tolerance else best


def _staircases(target: _Target) -> Iterator[tuple[list[float], list[float]]]:
    """Poles and zeros, rad/s, of straight-line approximations of the target with ever more roots.

    A staircase starts with the whole slope nearest to the target's. Along the band its error from the target grows
    until it is as large as the step; there a pole makes its slope smaller by one, or a zero larger.
    """
    x, y = target.log_frequency, target.log_amplitude
    lowest, highest = float(np.exp(x[0])), float(np.exp(x[-1]))
    inward = min(5, len(x) - 1)
    first = int(np.clip(round(target.mean_slope(0, inward)), -_STEEPEST, _STEEPEST))
    seen: set[tuple[int, int]] = set()
    for step in (np.inf, *_STEPS):
        below = [lowest / _OUTSIDE] * abs(first)
        poles, zeros = (below, []) if first < 0 else ([], below)
        slope, error = first, 0.0
        for i in range(1, len(x)):
            error += slope * (x[i] - x[i - 1]) - (y[i] - y[i - 1])
            if error > step:
                poles, slope = [*poles, float(np.exp(x[i]))], slope - 1
            elif error < -step:
                zeros, slope = [*zeros, float(np.exp(x[i]))], slope + 1
        poles += [_OUTSIDE * highest] * (len(zeros) + target.excess - len(poles))
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


def _fit(target: _Target, poles: Roots, zeros: Roots) -> Rational:
    """The function of least largest error that is found from these roots, with as many of them.

    Lawson's reweighting: where the error of a fit is large its weight grows for the next one. Since the errors need not
    fall from one to the next, the best of all fits is kept.
    """
    omega, wanted = target.omega, target.log_amplitude
    form = Form.of(zeros, poles)
    low, high = form.bounds(omega)
    theta = np.clip(Form.parameters(1.0, zeros, poles), low + _INSIDE, high - _INSIDE)
    theta[0] = float(np.mean(wanted - form.log_size(theta, omega)[0]))
    weight, best, least = np.ones(len(omega)), theta, np.inf
    for _ in range(_ROUNDS):

        def off(t: FloatArray, w: FloatArray = weight) -> FloatArray:
            weighted: FloatArray = (form.log_size(t, omega)[0] - wanted) * w
            return weighted

        def slope(t: FloatArray, w: FloatArray = weight) -> FloatArray:
            weighted: FloatArray = form.log_size(t, omega)[1] * w[:, None]
            return weighted

        theta = scipy.optimize.least_squares(off, theta, slope, (low, high), max_nfev=_EVALUATIONS).x
        error = form.log_size(theta, omega)[0] - wanted
        largest = float(np.abs(np.expm1(error)).max())
        if largest < least:
            best, least = theta, largest
        if least <= target.tolerance or largest > _HOPELESS * target.tolerance:
            break
        weight = weight * np.sqrt(np.abs(error) / np.abs(error).max() + _LEAST_WEIGHT)
        weight /= np.sqrt(np.mean(weight**2))
    return form.rational(best, least)


def _more(best: Rational, target: _Target) -> Iterator[tuple[Roots, Roots]]:
    """Poles and zeros with one more of each where the size is furthest off, or beside it."""
    p, pp = best.poles.split()
    z, zz = best.zeros.split()
    error = np.log(best.size(target.frequency_hz) / target.amplitude)
    worst = 2.0 * np.pi * float(target.frequency_hz[np.argmax(np.abs(error))])
    for width in _APART:
        for up in (width, 1.0 / width):
            yield _paired([*p, worst * up], pp), _paired([*z, worst / up], zz)


def _pruned(best: Rational, target: _Target) -> Rational:
    """Without the roots that are not needed."""
    again = True
    while again:
        again = False
        for poles, zeros in _fewer(best.poles, best.zeros, target.excess):
            tried = _fit(target, poles, zeros)
            if tried.error <= target.tolerance:
                best, again = tried, True
                break
    return best


def _fewer(poles: Roots, zeros: Roots, excess: int) -> Iterator[tuple[Roots, Roots]]:
    """Functions with a pole less, still `excess` more than zeros: without roots that nearly cancel, or at the ends."""
    p, pp = poles.split()
    z, zz = zeros.split()
    near = sorted((abs(np.log(a / b)), i, j) for i, a in enumerate(p) for j, b in enumerate(z))
    for _, i, j in near[:_CLOSEST]:
        yield _paired(p[:i] + p[i + 1 :], pp), _paired(z[:j] + z[j + 1 :], zz)
    near = sorted((abs(np.log(a[0] / b[0])), i, j) for i, a in enumerate(pp) for j, b in enumerate(zz))
    for _, i, j in near[:_CLOSEST]:
        yield _paired(p, pp[:i] + pp[i + 1 :]), _paired(z, zz[:j] + zz[j + 1 :])
    if len(poles) > len(zeros) + excess:
        yield from ((_paired(end, pp), _paired(z, zz)) for end in (p[1:], p[:-1]) if p)
