"""Realisation of the temperature noise in the time domain, as a check of the exact propagation.

Independent white Gaussian series go through the amplitude filter of each spectral shape and are mixed by a factor of
the correlation matrix, R = F Fᴴ, into the temperatures of all areas; those times the sensitivities are the outputs.
Only one block is held in memory. The filters are finite impulse responses applied by overlap and save, fed with noise
from before the first sample, so the series is stationary from its beginning. An area that follows later takes the noise
of whole samples earlier, and the fraction of a sample that is left is in the phase of its filter.

The spectrum is realised between `Plan.low_hz` and `Plan.high_hz` and continues level outside. A filter's response is
the amplitude spectral density smoothed by the transform of its window, Kaiser's with β = 22 over 128 periods of the
lowest frequency: at that frequency a power of f^-4 comes out 0.1 % too large, and this falls with 1/f². The window of
the estimate, four times shorter, smooths as well; `expected_psd` takes that into account.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import scipy

from tedm_cli.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from tedm_cli.errors import InputError
from tedm_cli.noise.propagation import OutputNoise, TemperatureNoise, psd_of_fields
from tedm_cli.noise.spectral_estimate import LOWEST_BIN, Estimate, Welch, Window, kaiser, segment_length, through_window
from tedm_cli.noise.temperature import TemperatureModel

BLOCK_NUMBERS = 1 << 20  # numbers of a block of all series: 8 MB
_FILTER_PERIODS = 128  # of the lowest frequency that a filter is long
_HELD_NUMBERS = 1 << 24  # numbers of past noise that delays may ask for: 134 MB
MOST_NUMBERS = 1 << 28  # numbers held in all: 2.1 GB, of which the sample takes 0.3


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


def temperature_blocks(source: TemperatureNoise, plan: Plan) -> Iterator[FloatArray]:
    """Temperatures [k, B] in K of all areas, block after block, `plan.samples` in all.

    The imaginary part of a complex factor F of the correlation turns phases by a quarter: E[T_i T_j*] =
    A_i A_j (F Fᴴ)_ij at positive frequencies. Delays may have any sign; only their differences matter.

    Raises
    ------
    InputError : the past noise that the delays ask for does not fit into 134 MB.
    """
    return output_blocks(np.eye(len(source.correlation.factor)), source, plan)


def output_blocks(rows: FloatArray, source: TemperatureNoise, plan: Plan) -> Iterator[FloatArray]:
    """Outputs [n_out, B] with sensitivities `rows` [n_out, k], as `temperature_blocks` makes temperatures.

    The temperatures themselves are never held: of many areas and low frequencies they would take most of the memory.
    """
    temperature, correlation = source.temperature, source.correlation
    columns = np.flatnonzero(np.any(correlation.factor != 0.0, axis=0))
    factor = correlation.factor[:, columns]
    lag, fraction = _lags(factor, correlation.delay_s, plan.rate_hz)
    heard, longest = temperature.heard, int(lag.max())
    keys = np.stack([temperature.shape_index, fraction], axis=1)[heard]
    filters, of_heard = np.unique(keys, axis=0, return_inverse=True)
    filter_of = np.full(len(heard), -1)
    filter_of[heard] = of_heard.reshape(-1)
    taps = filter_taps(plan)
    block = max(taps, BLOCK_NUMBERS // len(factor))
    length = scipy.fft.next_fast_len(block + taps, real=True)
    block = length - taps
    held = len(columns) * (longest + taps) + (len(rows) + 2) * length
    require_room(held, len(columns), len(rows), plan)
    in_phase, quadrature = _responses(temperature, plan, filters, taps, length)
    gain = rows * temperature.scale
    rng = np.random.default_rng(plan.seed)
    tails = rng.standard_normal((len(columns), longest + taps))
    at_once = max(1, BLOCK_NUMBERS // length)
    left = plan.samples
    while left > 0:
        wanted = min(block, left)
        out = np.zeros((len(rows), wanted))
        for first in range(0, len(columns), at_once):
            part = slice(first, first + at_once)
            white = np.concatenate([tails[part], rng.standard_normal((len(tails[part]), block))], axis=1)
            tails[part] = white[:, block:]
            for late in np.unique(lag):
                driving = factor[lag == late, part].any(axis=0)
                start = longest - late
                spectrum = scipy.fft.rfft(white[driving, start : start + length], axis=1)
                for number, (even, odd) in enumerate(zip(in_phase, quadrature, strict=True)):
                    index = np.flatnonzero((filter_of == number) & (lag == late))
                    weights = factor[index, part][:, driving]
                    for weight, response in ((weights.real, even), (weights.imag, odd)):
                        used = np.flatnonzero(weight.any(axis=0))
                        if used.size:
                            driven = scipy.fft.irfft(spectrum[used] * response, length, axis=1)[:, taps : taps + wanted]
                            out += (gain[:, index] @ weight[:, used]) @ driven
        yield out
        left -= wanted


def realise(
    rows: FloatArray,
    source: TemperatureNoise,
    plan: Plan,
    advance: Callable[[int], None] = lambda done: None,
) -> Estimate:
    """Estimated one-sided PSDs of outputs with `rows` [n_out, k], from series as `temperature_blocks` makes them.

    `advance` is told of the samples made since its last call. Raises `InputError` for less than a segment, and as
    `temperature_blocks` does.
    """
    return estimated(output_blocks(rows, source, plan), len(rows), plan, advance)


def estimated(blocks: Iterator[FloatArray], outputs: int, plan: Plan, advance: Callable[[int], None]) -> Estimate:
    """Estimated one-sided PSDs of series [outputs, B] that come in blocks; `advance` as in `realise`."""
    welch = Welch(outputs, plan.rate_hz, segment_length(plan.rate_hz, plan.lowest_hz))
    for block in blocks:
        welch.add(block)
        advance(block.shape[1])
    return welch.estimate()


def expected_psd(noise: OutputNoise, plan: Plan, window: Window | None = None) -> FloatArray:
    """Expectation [n_out, F] of what `realise` estimates: the exact PSDs through the window of the estimate.

    `window` is of another estimate from the same series.

    It differs from the exact PSD where that bends within the window's width: by 1.1 % for f^-4 at the lowest frequency,
    falling with 1/f², and everywhere between areas with delays. Two that are τ apart keep a share of about
    exp(-(2π τ σ)² / 2) of their coherence, σ a thirtieth of the lowest frequency, and none beyond a segment.
    """
    carriers = noise.source.carriers

    def psd(f: FloatArray) -> FloatArray:
        shape = noise.temperature.shape_values(held_level(f, plan))[carriers.shape]
        return psd_of_fields(noise.fields, shape * np.exp(-2j * np.pi * carriers.delay_s[:, None] * f))

    if window is None:
        window = Window(plan.rate_hz / segment_length(plan.rate_hz, plan.lowest_hz))
    return through_window(psd, noise.frequency_hz, window, float(np.ptp(carriers.delay_s)))


def filter_taps(plan: Plan) -> int:
    """Samples that the filters are long, an even number."""
    return 2 * (int(np.ceil(_FILTER_PERIODS * plan.rate_hz / plan.lowest_hz)) // 2)


def held_level(frequency_hz: FloatArray, plan: Plan) -> FloatArray:
    """Where the spectra are taken for these frequencies: level outside the band that is realised."""
    return np.clip(frequency_hz, plan.low_hz, plan.high_hz)


def require_room(held: int, columns: int, rows: int, plan: Plan) -> None:
    """Raise `InputError` where what `columns` fluctuations and `rows` outputs take is too much to hold."""
    if held > MOST_NUMBERS:
        raise InputError(
            f"filters of {_FILTER_PERIODS} periods of {plan.lowest_hz:g} Hz at {plan.rate_hz:g} Hz take"
            f" {8e-9 * held:.3g} GB for {columns} independent fluctuations and {rows} outputs; at most"
            f" {8e-9 * MOST_NUMBERS:.3g} GB are held",
            where="realisation",
            hint="raise lowest_hz, or lower rate_hz and [frequency] max_hz; the exact spectra need neither",
        )


def _lags(factor: AnyArray, delay_s: FloatArray, rate_hz: float) -> tuple[IndexArray, FloatArray]:
    """Whole samples [k] that each area is later than the earliest, and the fraction [k] of a sample left."""
    k, columns = factor.shape
    active = factor.any(axis=1)
    if not active.any():
        return np.zeros(k, dtype=np.intp), np.zeros(k)
    later = np.where(active, delay_s - delay_s[active].min(), 0.0) * rate_hz
    allowed = _HELD_NUMBERS // columns
    if later.max() > allowed:
        raise InputError(
            f"an area is {later.max() / rate_hz:g} s later than another, {later.max():,.0f} samples at {rate_hz:g} Hz;"
            f" with {columns} independent fluctuations at most {allowed:,} can be held",
            where="realisation",
            hint="shorten the delays, lower rate_hz, or leave [realisation] out: the exact spectra need neither",
        )
    lag = np.rint(later).astype(np.intp)
    return lag, np.round(later - lag, 9)  # what the product with the rate rounds is no fraction


def _responses(
    temperature: TemperatureModel, plan: Plan, filters: FloatArray, taps: int, length: int
) -> tuple[AnyArray, AnyArray]:
    """Responses [n, length // 2 + 1] of causal filters to unit white samples, and turned by 90°.

    `filters` [n, 2]: the spectral shape of each, and the samples by which it delays beyond `taps` / 2.
    """
    grid = np.fft.rfftfreq(taps, 1.0 / plan.rate_hz)
    shape = temperature.shape_values(held_level(grid, plan)) * np.sqrt(plan.rate_hz / 2.0)
    late = np.exp(-2j * np.pi * filters[:, 1:] * grid / plan.rate_hz)
    window = np.roll(kaiser(taps), taps // 2)
    out = []
    for phase in (1.0, 1.0j):
        response = shape[filters[:, 0].astype(np.intp)] * late * phase
        response[:, [0, -1]] = response[:, [0, -1]].real
        taps_of = scipy.fft.irfft(response, taps, axis=1) * window  # centred on sample 0
        out.append(scipy.fft.rfft(np.roll(taps_of, taps // 2, axis=1), length, axis=1))
    return out[0], out[1]


def resolved(frequency_hz: FloatArray, plan: Plan, window: Window | None = None) -> BoolArray:
    """Where [F] an estimate can be compared to the exact spectrum: clear of the ends of the realised band.

    `window` is of an estimate other than that of `realise`; `lowest_hz` bounds it, since below the filters smooth more.
    """
    lowest, bin_hz = (
        (plan.low_hz, plan.lowest_hz / LOWEST_BIN)
        if window is None
        else (max(plan.low_hz, plan.lowest_hz), window.bin_hz)
    )
    highest = np.minimum(plan.high_hz, plan.rate_hz / 2 - 10.0 * bin_hz)
    inside: BoolArray = (frequency_hz >= lowest) & (frequency_hz <= highest)
    return inside
