"""Realisation in the time domain of the noise of a thermal network: as `realisation` makes it of correlated areas.

Every independent fluctuation of the disturbances, white, goes through a filter of its own to each output: the gain of
the network with the amplitude spectral densities of the disturbances, phases included. Between the frequencies at which
the network is solved, `PER_DECADE` of them, its gains to an output are a cubic spline of log f; they have no poles near
the frequencies, as all of them are at negative real s. Amplitudes of disturbances are their own everywhere.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import scipy

from tedm_cli.arrays import ComplexArray, FloatArray
from tedm_cli.errors import InputError
from tedm_cli.noise.network import NetworkNoise, NetworkOutputs
from tedm_cli.noise.realisation import BLOCK_NUMBERS, MOST_NUMBERS, Plan, filter_taps, held_level, require_room
from tedm_cli.noise.spectral_estimate import Window, kaiser, segment_length, through_window

PER_DECADE = 60  # frequencies at which the network is solved


@dataclass(frozen=True, eq=False)
class GainsBetween:
    """What the disturbances make of outputs at any frequency of a range, from gains at some.

    spline : of log f, [.., n_out, u] in units of the output per unit of each disturbance. amplitudes : [u, F] of
    frequencies. factor : L [u, m], of the correlation of the disturbances.
    """

    spline: scipy.interpolate.CubicSpline
    amplitudes: Callable[[FloatArray], FloatArray]
    factor: FloatArray

    def fields(self, frequency_hz: FloatArray) -> ComplexArray:
        """Outputs [n_out, F, m] of the independent fluctuations, unit per √Hz."""
        gain = self.spline(np.log(frequency_hz))  # [F, n_out, u]
        driven: ComplexArray = (gain * self.amplitudes(frequency_hz).T[:, None, :]) @ self.factor
        return driven.transpose(1, 0, 2)


def gains_between(rows: FloatArray, source: NetworkNoise, low_hz: float, high_hz: float) -> GainsBetween:
    """Gains to outputs with `rows` [n_out, k] from `low_hz` to `high_hz`.

    Raises `InputError` where nothing solves the network at other frequencies than those that it is known at.
    """
    network = source.network
    if network is None:
        raise InputError("gains of the network are known at some frequencies alone", where="realisation")
    number = 2 + int(np.ceil(PER_DECADE * np.log10(high_hz / low_hz)))
    f = np.geomspace(low_hz, high_hz, number)
    amplitudes = network.amplitudes(f)
    driven = NetworkOutputs(rows, source.at(f), f).by_disturbance.transpose(1, 0, 2)  # [n, n_out, u]
    size = amplitudes.T[:, None, :]
    gain = np.divide(driven, size, out=np.zeros_like(driven), where=size > 0.0)
    return GainsBetween(scipy.interpolate.CubicSpline(np.log(f), gain), network.amplitudes, source.factor)


def network_blocks(rows: FloatArray, source: NetworkNoise, plan: Plan) -> Iterator[FloatArray]:
    """Outputs [n_out, B] with sensitivities `rows` [n_out, k], block after block, `plan.samples` in all.

    Raises
    ------
    InputError : filters that are too much to hold.
    """
    n_out, columns = len(rows), source.factor.shape[1]
    taps = filter_taps(plan)
    block = max(taps, BLOCK_NUMBERS // max(n_out, 1))
    length = scipy.fft.next_fast_len(block + taps, real=True)
    block = length - taps
    require_room(columns * taps + (3 * n_out + 2) * length, columns, n_out, plan)
    gains = gains_between(rows, source, plan.low_hz, plan.high_hz)
    filters = _Filters(gains, plan, taps, length)
    held = [filters.of(m) for m in range(columns)] if n_out * columns * length <= MOST_NUMBERS // 2 else None
    rng = np.random.default_rng(plan.seed)
    tails = rng.standard_normal((columns, taps))
    left = plan.samples
    while left > 0:
        wanted = min(block, left)
        total = np.zeros((n_out, length // 2 + 1), dtype=np.complex128)
        for m in range(columns):
            white = np.concatenate([tails[m], rng.standard_normal(block)])
            tails[m] = white[block:]
            total += (filters.of(m) if held is None else held[m]) * scipy.fft.rfft(white)
        yield scipy.fft.irfft(total, length, axis=1)[:, taps : taps + wanted]
        left -= wanted


@dataclass(frozen=True, eq=False)
class _Filters:
    """Causal filters of `taps` taps to the outputs, as responses of transforms of `length` samples."""

    gains: GainsBetween
    plan: Plan
    taps: int
    length: int

    def of(self, column: int) -> ComplexArray:
        """Responses [n_out, length // 2 + 1] to unit white samples of one fluctuation; they delay by taps / 2."""
        plan, taps = self.plan, self.taps
        one = GainsBetween(self.gains.spline, self.gains.amplitudes, self.gains.factor[:, [column]])
        grid = held_level(np.fft.rfftfreq(taps, 1.0 / plan.rate_hz), plan)
        response = one.fields(grid)[:, :, 0] * np.sqrt(plan.rate_hz / 2.0)
        response[:, [0, -1]] = response[:, [0, -1]].real
        window = np.roll(kaiser(taps), taps // 2)
        of_taps = scipy.fft.irfft(response, taps, axis=1) * window  # centred on sample 0
        return np.asarray(scipy.fft.rfft(np.roll(of_taps, taps // 2, axis=1), self.length, axis=1))


def network_expected(noise: NetworkOutputs, plan: Plan, window: Window | None = None) -> FloatArray:
    """Expectation [n_out, F] of what the realisation's estimate shows, as `realisation.expected_psd`."""
    gains = gains_between(noise.rows, noise.source, plan.low_hz, plan.high_hz)

    def psd(f: FloatArray) -> FloatArray:
        y = gains.fields(held_level(f, plan))
        return np.asarray((y.real**2 + y.imag**2).sum(axis=2))

    if window is None:
        window = Window(plan.rate_hz / segment_length(plan.rate_hz, plan.lowest_hz))
    return through_window(psd, noise.frequency_hz, window)
