"""Noise-shaping filters: state spaces whose response to white noise has the spectra of the temperature model.

White noise w of one-sided PSD 1/Hz (two-sided 1/2, E[w(t) w(t')] = δ(t - t')/2) through x' = a x + b w, u = c x + d w
makes u of one-sided PSD |c (2πif - a)⁻¹ b + d|². Filters are cascades of first- and second-order sections in the form
x' = ω [[0, 1], [-1, -2ζ]] x + ω [0, 1]ᵀ u, whose entries are all of the size of the corner, in rad/s.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy

from tedm_cli.arrays import AnyArray, FloatArray
from tedm_cli.errors import PhysicsError
from tedm_cli.noise.shaping.common_phase import common_phase
from tedm_cli.noise.shaping.rational_fit import LARGEST_ORDER, Roots, minimum_phase
from tedm_cli.noise.temperature import ShapedSpectrum, Spectrum, TabulatedSpectrum, WhiteSpectrum

_PER_DECADE = 40  # frequencies at which a filter is fitted


@dataclass(frozen=True, eq=False)
class ShapingFilter:
    """A stable filter with one white input and q outputs, which are in phase with each other at every frequency.

    Parameters
    ----------
    a : [n, n], rad/s, lower block triangular; b : [n], rad/s; c : [q, n]; d : [q].
    deviation : [q], largest relative deviation of an output's amplitude spectral density (for q > 1 of amplitude and
        phase together) from its spectrum; 0 where the filter is exact at all frequencies.
    """

    a: FloatArray
    b: FloatArray
    c: FloatArray
    d: FloatArray
    deviation: FloatArray

    def state_response(self, frequency_hz: FloatArray) -> AnyArray:
        """(2πif - a)⁻¹ b [n, F]."""
        n = len(self.b)
        resolvent = 2j * np.pi * frequency_hz[:, None, None] * np.eye(n) - self.a
        response: AnyArray = np.linalg.solve(resolvent, np.broadcast_to(self.b[:, None], (len(frequency_hz), n, 1)))
        return response[:, :, 0].T

    def response(self, frequency_hz: FloatArray) -> AnyArray:
        """c (2πif - a)⁻¹ b + d [q, F]."""
        response: AnyArray = self.c @ self.state_response(frequency_hz) + self.d[:, None]
        return response

    def covariance(self) -> FloatArray:
        """Covariance [n, n] of the stationary state, from Lyapunov's equation a P + P aᵀ + b bᵀ/2 = 0."""
        if not len(self.b):
            return np.zeros((0, 0))
        covariance: FloatArray = scipy.linalg.solve_continuous_lyapunov(self.a, -0.5 * np.outer(self.b, self.b))
        return 0.5 * (covariance + covariance.T)


def shaping_filter(spectra: tuple[Spectrum, ...], band_hz: tuple[float, float], tolerance: float) -> ShapingFilter:
    """Filter with one output for each of the spectra, fully correlated as the outputs of one white input are.

    A single spectrum has minimum phase: white noise takes no state, a low-pass of whole order n takes n and is exact
    (Butterworth's), any other has a rational fit between the two frequencies of `band_hz`. Several spectra have
    filters of one common phase, since cross-spectra of the temperature model are real; see `common_phase`.

    Raises
    ------
    PhysicsError : the tolerance is not reached; the message has what was.
    """
    if len(spectra) == 1:
        (spectrum,) = spectra
        if isinstance(spectrum, WhiteSpectrum):
            return _cascade(spectrum.level_K, Roots((), ()), Roots((), ()), 0.0)
        if isinstance(spectrum, ShapedSpectrum) and float(spectrum.order).is_integer():
            return _butterworth(spectrum)
    frequency = _grid(spectra, band_hz)
    amplitude = np.stack([s.amplitude(frequency) for s in spectra])
    if len(spectra) == 1:
        fit = minimum_phase(frequency, amplitude[0], tolerance)
        _reached(fit.error, tolerance, spectra, f"{LARGEST_ORDER} states")
        return _cascade(fit.gain, fit.zeros, fit.poles, fit.error)
    a, b, c, d, deviation = common_phase(frequency, amplitude, tolerance)
    _reached(float(deviation.max()), tolerance, spectra, f"{len(b)} states")
    return ShapingFilter(a, b, c, d, deviation)


def _reached(error: float, tolerance: float, spectra: tuple[Spectrum, ...], effort: str) -> None:
    if error > tolerance:
        what = " and ".join(dict.fromkeys(replace(s, level_K=1.0).words() for s in spectra))
        raise PhysicsError(
            f"a filter of up to {effort} comes within {100 * error:.3g} % of it, not {100 * tolerance:.3g} %",
            where=f"temperature spectrum {what}",
            hint="give a larger --tolerance, a narrower [frequency], or a table without ripples",
        )


def _grid(spectra: tuple[Spectrum, ...], band_hz: tuple[float, float]) -> FloatArray:
    """Frequencies [F] of a fit: logarithmic, with both ends and the points of tables between them."""
    low, high = band_hz
    points = max(20, int(np.ceil(_PER_DECADE * np.log10(high / low))))
    inner = [f for s in spectra if isinstance(s, TabulatedSpectrum) for f in s.frequency_hz if low < f < high]
    grid: FloatArray = np.unique(np.concatenate([np.geomspace(low, high, points)[1:-1], inner, [low, high]]))
    return grid


def _butterworth(spectrum: ShapedSpectrum) -> ShapingFilter:
    """Low-pass of whole order n: |H|² = A0² (1 + (f0/fc)^2n) / (1 + (f/fc)^2n), poles on a half circle."""
    n, corner = int(spectrum.order), 2.0 * np.pi * spectrum.corner_hz
    gain = spectrum.level_K * float(np.sqrt(1.0 + (spectrum.reference_hz / spectrum.corner_hz) ** (2 * n)))
    angles = np.pi * (2 * np.arange(n // 2) + 1) / (2 * n)
    poles = Roots(tuple((corner, float(np.sin(angle))) for angle in angles), (corner,) * (n % 2))
    return _cascade(gain, Roots((), ()), poles, 0.0)


def _cascade(gain: float, zeros: Roots, poles: Roots, error: float) -> ShapingFilter:
    """Sections in series, zeros with the poles nearest to them; not more zeros than poles."""
    numerators = _assigned(zeros, poles)
    n = len(poles)
    a, b, c, d, i = np.zeros((n, n)), np.zeros(n), np.zeros(n), 1.0, 0
    for corner, damping in [*poles.pairs, *((w, None) for w in poles.single)]:
        size = 1 if damping is None else 2
        here = slice(i, i + size)
        z0, z1 = numerators.pop(0)  # numerator 1 + z0 s + z1 s²
        if damping is None:
            own = np.array([[-corner]])
            out, direct = np.array([1.0 - z0 * corner]), z0 * corner
        else:
            own = corner * np.array([[0.0, 1.0], [-1.0, -2.0 * damping]])
            direct = z1 * corner**2
            out = np.array([1.0 - direct, z0 * corner - 2.0 * damping * direct])
        a[here, here] = own
        a[i + size - 1, :i] = corner * c[:i]
        b[i + size - 1] = corner * d
        c, d = direct * c, direct * d
        c[here] = out
        i += size
    return ShapingFilter(a, b, gain * c[None, :], np.array([gain * d]), np.array([error]))


def _assigned(zeros: Roots, poles: Roots) -> list[tuple[float, float]]:
    """Coefficients (of s, of s²) of every section's numerator, in the order of the poles' pairs and single roots."""
    corners = [w for w, _ in poles.pairs]
    out = [(0.0, 0.0)] * (len(corners) + len(poles.single))
    free = list(range(len(corners)))
    for w, z in zeros.pairs:
        mine = min(free, key=lambda i: abs(np.log(w / corners[i])))
        free.remove(mine)
        out[mine] = (2.0 * z / w, 1.0 / w**2)
    for w in zeros.single:
        place = len(corners) if poles.single else free[0]
        out[place] = (1.0 / w, 0.0)
    return out
