"""Welch's estimate of steep spectra, accumulated block by block, with its confidence interval.

Spectra fall by decades here, so the window must not leak: the side lobes of Kaiser's with β = 22 are 17 decades down in
power, where Hann's fall with distance only. Equivalent degrees of freedom of overlapping segments: Percival and Walden,
*Spectral Analysis for Physical Applications*, 1993, p. 292.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError

KAISER_BETA = 22.0
LOWEST_BIN = 32  # of the lowest frequency wanted: the window's main lobe is 7 bins wide on either side
HOPS = 4  # segments overlap by 3/4: at this β they share little then


@dataclass(frozen=True, eq=False)
class Estimate:
    """One-sided PSDs of n series.

    Parameters
    ----------
    frequency_hz : [F].
    psd : [n, F], unit²/Hz.
    degrees_of_freedom : [F], equivalent ones of each value: psd times these over its expectation is χ² distributed.
    """

    frequency_hz: FloatArray
    psd: FloatArray
    degrees_of_freedom: FloatArray

    def interval(self, confidence: float) -> tuple[FloatArray, FloatArray]:
        """Factors [F] on a PSD between which, with this probability, the expectation of its estimate lies."""
        nu = self.degrees_of_freedom
        # quantiles of χ² as scipy.stats has them, which takes half a second of every command to load
        low, high = (2.0 * scipy.special.gammaincinv(nu / 2.0, (1.0 + side * confidence) / 2.0) for side in (-1.0, 1.0))
        return nu / high, nu / low


@dataclass(frozen=True, eq=False)
class Window:
    """Kaiser's window that an estimate is made with.

    Parameters
    ----------
    bin_hz : width of a bin, the rate over the samples of a segment; one for all frequencies or [F].
    beta : its shape.
    """

    bin_hz: float | FloatArray
    beta: float = KAISER_BETA


class Welch:
    """Accumulates Welch's estimate of n series from blocks of any length; memory is a segment of each.

    Parameters
    ----------
    n : number of series.
    rate_hz : samples per second.
    segment : samples of a segment, a multiple of `HOPS`.
    window : [segment]; Kaiser's with β = 22 by default.
    """

    def __init__(self, n: int, rate_hz: float, segment: int, window: FloatArray | None = None) -> None:
        self._rate, self.segment, self._hop = rate_hz, segment, segment // HOPS
        self._window: FloatArray = kaiser(segment) if window is None else window
        self._held: FloatArray = np.empty((n, 0))
        self._sum: FloatArray = np.zeros((n, segment // 2 + 1))
        self.segments = 0

    def add(self, block: FloatArray) -> None:
        """Take the next samples [n, B]."""
        self._held = np.concatenate([self._held, block], axis=1)
        start = 0
        while start + self.segment <= self._held.shape[1]:
            spectrum = scipy.fft.rfft(self._held[:, start : start + self.segment] * self._window, axis=1)
            self._sum += spectrum.real**2 + spectrum.imag**2
            self.segments += 1
            start += self._hop
        self._held = self._held[:, start:].copy()

    def estimate(self) -> Estimate:
        """The spectra of what was taken so far, from bin `LOWEST_BIN` to the one below the Nyquist frequency.

        Raises
        ------
        InputError : less than one segment.
        """
        if not self.segments:
            raise InputError(
                f"{self._held.shape[1]:,} samples are less than one segment of {self.segment:,}",
                where="spectral estimate",
                hint="take a longer series, or a higher lowest_hz",
            )
        scale = 2.0 / (self._rate * float(np.sum(self._window**2)) * self.segments)
        part = slice(LOWEST_BIN, self.segment // 2)
        frequency = np.fft.rfftfreq(self.segment, 1.0 / self._rate)[part]
        nu = 2.0 * independent_averages(self.segments, self._window)
        return Estimate(frequency, scale * self._sum[:, part], np.full(len(frequency), nu))


def through_window(
    psd: Callable[[FloatArray], FloatArray], frequency_hz: FloatArray, window: Window, longest_s: float = 0.0
) -> FloatArray:
    """Expectation [n, F] of an estimate from segments with this window, of series whose PSDs [n, F] are `psd`(f).

    The spectrum is averaged over the window's main lobe, (sin z / z)² with z² = (πν)² - β² and ν in bins (Kaiser and
    Schafer, IEEE Trans. ASSP 28, 1980). The sum is exact for cosines in f of periods down to 1 / `longest_s`.
    """
    # Lags beyond a segment are not seen; sampled at 1/q of a bin, they are for q - 1 segments more.
    per_bin = 2 + int(np.ceil(longest_s * np.max(window.bin_hz)))
    steps = int(main_lobe(window.beta) * per_bin)
    offset = np.arange(-steps, steps + 1) / per_bin
    z = np.sqrt((np.pi * offset) ** 2 - window.beta**2 + 0j)
    weight = np.real(np.sin(z) / z) ** 2
    shifted = ((w, frequency_hz + o * window.bin_hz) for w, o in zip(weight, offset, strict=True))
    average: FloatArray = sum(w * psd(f) for w, f in shifted) / weight.sum()
    return average


def main_lobe(beta: float) -> float:
    """Bins that the main lobe of Kaiser's window reaches to either side, rounded up to tenths."""
    return float(np.ceil(10.0 * np.hypot(1.0, beta / np.pi)) / 10.0)


def kaiser(n: int) -> FloatArray:
    """Kaiser's window [n] with β = 22, periodic."""
    window: FloatArray = np.kaiser(n + 1, KAISER_BETA)[:n]
    return window


def segment_length(rate_hz: float, lowest_hz: float) -> int:
    """Samples of a segment whose bin `LOWEST_BIN` is at `lowest_hz`, rounded up to a multiple of `HOPS`."""
    return HOPS * int(np.ceil(LOWEST_BIN * rate_hz / lowest_hz / HOPS))


def longest_segment(samples: int) -> int:
    """Samples of the longest segment of a short series that is averaged at all: half of it; 0 where that is too few."""
    segment = HOPS * (samples // (2 * HOPS))
    return segment if segment // 2 > LOWEST_BIN + 1 else 0


def independent_averages(segments: int, window: FloatArray) -> float:
    """Independent segments with the variance of `segments` that overlap by 3/4."""
    hop = len(window) // HOPS
    lags = np.arange(1, min(HOPS, segments))
    shared = np.array([np.sum(window[: len(window) - m * hop] * window[m * hop :]) for m in lags])
    correlation = (shared / np.sum(window**2)) ** 2
    return float(segments / (1.0 + 2.0 * np.sum((1.0 - lags / segments) * correlation)))


def averages_wanted(tolerance: float, confidence: float) -> float:
    """Independent averages after which a PSD is within ±`tolerance`, relatively, with probability `confidence`.

    Normal approximation of χ²: its relative standard deviation is 1/√averages.
    """
    quantile = float(scipy.special.ndtri(0.5 + confidence / 2.0))
    return (quantile / tolerance) ** 2


def samples_wanted(rate_hz: float, lowest_hz: float, tolerance: float, confidence: float) -> int:
    """Samples of a series for `averages_wanted` at `lowest_hz`, and so at every frequency above it."""
    segment = segment_length(rate_hz, lowest_hz)
    wanted, window = averages_wanted(tolerance, confidence), kaiser(segment)
    gain = independent_averages(10**9, window) / 1e9  # of one more segment
    segments = max(1, int(np.ceil(wanted / gain)))
    while independent_averages(segments, window) < wanted:
        segments += 1
    return segment + (segments - 1) * (segment // HOPS)
