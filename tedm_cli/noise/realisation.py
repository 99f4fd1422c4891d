"""Realisation of the temperature noise in the time domain, as a check of the exact propagation.

Independent white Gaussian series go through the amplitude filter of each spectral shape and are mixed by a factor of
the correlation matrix, R = F Fᴴ, into the temperatures of all areas; those times the sensitivities are the outputs.
Nothing is held but a block. The filters are finite impulse responses applied by overlap and save, fed with noise from
before the first sample, so the series is stationary from its beginning.

The spectrum is realised between `Plan.low_hz` and `Plan.high_hz` and continues level outside. A filter's response is
the amplitude spectral density smoothed by the transform of its window, Kaiser's with β = 22 over 128 periods of the
lowest frequency: at that frequency a power of f^-4 comes out 0.1 % too large, and the estimate's own window adds 1.1 %;
both errors fall with 1/f².
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from tedm_cli.noise.spectral_estimate import LOWEST_BIN, Estimate, Welch, kaiser, segment_length
from tedm_cli.noise.temperature import TemperatureModel

Array = NDArray[np.float64]
Matrix = NDArray[Any]  # real or complex

_BLOCK_NUMBERS = 1 << 20  # numbers of a block of all series: 8 MB
_FILTER_PERIODS = 128  # of the lowest frequency that a filter is long


@dataclass(frozen=True)
class Plan:
    """What to realise.

    Parameters
    ----------
    rate_hz : samples per second.
    samples : of the series.
    seed : of the random numbers; the same seed gives the same series.
    low_hz, high_hz : the spectra are held level below and above.
    lowest_hz : lowest frequency of the estimate.
    """

    rate_hz: float
    samples: int
    seed: int
    low_hz: float
    high_hz: float
    lowest_hz: float


def temperature_blocks(temperature: TemperatureModel, factor: Matrix, plan: Plan) -> Iterator[Array]:
    """Temperatures [k, B] in K of all areas, block after block, `plan.samples` in all.

    Parameters
    ----------
    factor : F [k, m]. The imaginary part of a complex one turns phases by a quarter: E[T_i T_j*] = A_i A_j (F Fᴴ)_ij
        at positive frequencies.
    """
    columns = np.flatnonzero(np.any(factor != 0.0, axis=0))
    factor = factor[:, columns]
    taps = 2 * (int(np.ceil(_FILTER_PERIODS * plan.rate_hz / plan.lowest_hz)) // 2)
    block = max(taps, _BLOCK_NUMBERS // len(factor))
    length = fft.next_fast_len(block + taps, real=True)
    block = length - taps
    in_phase, quadrature = _responses(temperature, plan, taps, length)
    rng = np.random.default_rng(plan.seed)
    tails = rng.standard_normal((len(columns), taps))
    at_once = max(1, _BLOCK_NUMBERS // length)
    left = plan.samples
    while left > 0:
        wanted = min(block, left)
        out = np.zeros((len(factor), wanted))
        for first in range(0, len(columns), at_once):
            part = slice(first, first + at_once)
            white = np.concatenate([tails[part], rng.standard_normal((len(tails[part]), block))], axis=1)
            tails[part] = white[:, block:]
            spectrum = fft.rfft(white, axis=1)
            for shape, (even, odd) in enumerate(zip(in_phase, quadrature, strict=True)):
                index = np.flatnonzero(temperature.shape_index == shape)
                for weight, response in ((factor[index, part].real, even), (factor[index, part].imag, odd)):
                    used = np.flatnonzero(weight.any(axis=0))
                    if used.size:
                        driven = fft.irfft(spectrum[used] * response, length, axis=1)[:, taps : taps + wanted]
                        out[index] += temperature.scale[index, None] * (weight[:, used] @ driven)
        yield out
        left -= wanted


def realise(
    rows: Array,
    temperature: TemperatureModel,
    factor: Matrix,
    plan: Plan,
    advance: Callable[[int], None] = lambda done: None,
) -> Estimate:
    """Estimated one-sided PSDs of outputs with `rows` [n_out, k], from series as `temperature_blocks` makes them.

    `advance` is told of the samples made since its last call. Raises `InputError` for less than a segment.
    """
    welch = Welch(len(rows), plan.rate_hz, segment_length(plan.rate_hz, plan.lowest_hz))
    for block in temperature_blocks(temperature, factor, plan):
        welch.add(rows @ block)
        advance(block.shape[1])
    return welch.estimate()


def _responses(temperature: TemperatureModel, plan: Plan, taps: int, length: int) -> tuple[Matrix, Matrix]:
    """Responses [s, length // 2 + 1] of the causal filters of all shapes to unit white samples, and turned by 90°."""
    grid = np.fft.rfftfreq(taps, 1.0 / plan.rate_hz)
    shape = temperature.shape_values(np.clip(grid, plan.low_hz, plan.high_hz)) * np.sqrt(plan.rate_hz / 2.0)
    window = np.roll(kaiser(taps), taps // 2)
    out = []
    for phase in (1.0, 1.0j):
        response = shape * phase
        response[:, [0, -1]] = response[:, [0, -1]].real
        taps_of = fft.irfft(response, taps, axis=1) * window  # centred on sample 0
        out.append(fft.rfft(np.roll(taps_of, taps // 2, axis=1), length, axis=1))
    return out[0], out[1]


def in_band(frequency_hz: Array, plan: Plan) -> NDArray[np.bool_]:
    """Where [F] an estimate can be compared to the exact spectrum: clear of the ends of the realised band."""
    margin = plan.lowest_hz * 10.0 / LOWEST_BIN
    inside: NDArray[np.bool_] = (frequency_hz >= plan.low_hz) & (
        frequency_hz <= min(plan.high_hz, plan.rate_hz / 2 - margin)
    )
    return inside
