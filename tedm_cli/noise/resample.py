"""A time series on other, regular stamps, block by block. What is linear in the samples may be done before or after."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.quantities import SAMPLES

_LARGEST_FACTOR = 1000
_SAME_RATIO = 1e-8  # any ratio is near one of whole numbers: this near it is meant
_HALF_TAPS = 24  # on each side of the centre, in samples of the slower of the two rates
_KAISER_BETA = 12.0  # 118 dB of attenuation, over a transition of 0.32 of the lower Nyquist frequency
_PASS = 0.82  # cut-off over the lower Nyquist frequency, such that the stop band begins below it
_MOST_MADE = 1 << 18  # samples that are made at once


def pieces(
    time_s: FloatArray, values: FloatArray, first_s: float, step_s: float | None, where: str
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Stamps [B] and values [B, n] of a block in pieces of which none makes more samples than are held, however fine.

    `first_s`: stamp of the first sample of the series; `step_s`: of the series to be made, None: not resampled.

    Raises
    ------
    ConfigError : the step makes too many samples of the series so far, or between two of its rows.
    """
    if step_s is None:
        yield time_s, values
        return
    number = np.floor((time_s - first_s) / step_s)
    fact = SAMPLES.fact(int(number[-1]) + 1)
    gap = float(np.diff(number).max(initial=0.0))
    if not fact and gap > _MOST_MADE:
        fact = f"{gap:,.0f} samples between two rows; at most {_MOST_MADE:,}"
    if fact:
        raise ConfigError([("resample_s", f"steps of {step_s:g} s make too many samples: {fact}")], where=where)
    for rows in np.split(np.arange(len(time_s)), np.flatnonzero(np.diff(number // _MOST_MADE)) + 1):
        yield time_s[rows], values[rows]


class LinearResampler:
    """Straight lines between the samples, at first stamp + n `step_s`. No anti-alias filter: only for finer steps.

    Interpolation attenuates: by 1 - (π f Δ)²/6 where the samples are Δ apart.
    """

    def __init__(self, step_s: float) -> None:
        self._step = step_s
        self._first = np.nan
        self._made = 0
        self._time: FloatArray = np.empty(0)
        self._held: FloatArray = np.empty((0, 0))

    def push(self, time_s: FloatArray, values: FloatArray) -> FloatArray:
        """Values [m, n] on the new stamps that stamps [B] in s and `values` [B, n] allow for."""
        if not len(time_s):
            return values[:0]
        if not self._time.size:
            self._first, self._time, self._held = float(time_s[0]), time_s[:0], values[:0]
        time = np.concatenate([self._time, time_s])
        held = np.concatenate([self._held, values])
        count = int(np.floor((time[-1] - self._first) / self._step * (1.0 + 1e-12))) + 1
        wanted = np.minimum(self._first + self._step * np.arange(self._made, count), time[-1])
        self._made = count
        right = np.clip(np.searchsorted(time, wanted), 1, max(len(time) - 1, 1))
        if len(time) == 1:
            out = held.repeat(len(wanted), axis=0)
        else:
            weight = ((wanted - time[right - 1]) / (time[right] - time[right - 1]))[:, None]
            out = (1.0 - weight) * held[right - 1] + weight * held[right]
        self._time, self._held = time[-1:], held[-1:]
        return out


class PolyphaseResampler:
    """A regular series at another rate through one low-pass filter (Kaiser window, 118 dB) that keeps aliases out.

    The pass band reaches 0.66 of the lower of the two Nyquist frequencies. Where the filter would reach over the ends
    of the series no sample is made: it begins and ends 24 samples of the slower rate later and earlier.

    Raises
    ------
    InputError : the steps are not in the ratio of two whole numbers up to 1000.
    """

    passes = 0.66  # of the lower Nyquist frequency

    def __init__(self, from_s: float, to_s: float) -> None:
        ratio = Fraction(from_s / to_s).limit_denominator(_LARGEST_FACTOR)
        if ratio.numerator > _LARGEST_FACTOR or not ratio or abs(float(ratio) * to_s / from_s - 1.0) > _SAME_RATIO:
            raise InputError(
                f"steps of {from_s:.9g} and {to_s:.9g} s are not in the ratio of two whole numbers up to"
                f" {_LARGEST_FACTOR}",
                where="resampling",
                hint='take a step that is, or method = "linear" and a finer step',
            )
        self._up, self._down = ratio.numerator, ratio.denominator
        slow = max(self._up, self._down)
        self._half = _HALF_TAPS * slow
        taps = scipy.signal.firwin(2 * self._half + 1, _PASS / slow, window=("kaiser", _KAISER_BETA))
        self._taps: FloatArray = taps * self._up
        self._held: FloatArray = np.empty((0, 0))
        self._offset = 0  # input samples before those held
        self._made = -(-self._half // self._down)  # output samples before this one would reach over the beginning

    @property
    def first(self) -> int:
        """Which sample of the new step, counted from the first stamp, is the first that is made."""
        return -(-self._half // self._down)

    def push(self, time_s: FloatArray, values: FloatArray) -> FloatArray:
        """Values [m, n] at the new rate that `values` [B, n] (at the next stamps [B]) allow for."""
        held = np.concatenate([self._held, values]) if self._held.size else values
        total = self._offset + len(held)
        # Output n sits at n·down on the fine grid; its filter reaches from n·down - half to n·down + half.
        stop = max(self._made, ((total - 1) * self._up - self._half) // self._down + 1)
        if stop == self._made:
            self._held = held
            return values[:0]
        places = np.arange(self._made, stop) * self._down + self._half - self._offset * self._up
        shift = -int(places[0]) % self._down  # brings the places onto those that upfirdn keeps
        taps = np.concatenate([np.zeros(shift), self._taps])
        out = scipy.signal.upfirdn(taps, held, self._up, self._down, axis=0)[(places + shift) // self._down]
        self._made = stop
        keep = max(0, (stop * self._down - self._half) // self._up - self._offset)
        self._held, self._offset = held[keep:].copy(), self._offset + keep
        return np.ascontiguousarray(out)
