"""Exact propagation of temperature noise through linear static outputs (no realisation, no estimator bias).

With outputs y = g ΔT and the cross-spectral density C(f) = A(f) R A(f)ᴴ of the temperatures, the one-sided PSD of an
output is S_y(f) = g C(f) gᴴ. Everything here works on a factor R = F Fᴴ, so that S_y = |g A F|² stays non-negative and
keeps its accuracy where the areas of a block cancel; the quadratic form itself would lose twice as many digits.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tedm_cli.arrays import AnyArray, FloatArray, IndexArray
from tedm_cli.noise.correlation import Correlation
from tedm_cli.noise.correlation_check import correlation_factor
from tedm_cli.noise.temperature import TemperatureModel


@dataclass(frozen=True, eq=False)
class Carriers:
    """The c distinct functions of frequency that the areas follow: a spectral shape, turned by a delay.

    Parameters
    ----------
    index : [k], the carrier of each area; -1 of those without a spectrum, which are silent.
    shape : [c], index into the shapes of the temperature model; delay_s : [c], s.
    """

    temperature: TemperatureModel
    index: IndexArray
    shape: IndexArray
    delay_s: FloatArray

    @classmethod
    def of(cls, temperature: TemperatureModel, delay_s: FloatArray | None = None) -> Carriers:
        """Carriers of areas with delays [k] in s; none by default."""
        if delay_s is None or not delay_s.any():
            number = len(temperature.shapes)
            return cls(temperature, temperature.shape_index, np.arange(number), np.zeros(number))
        heard = temperature.heard
        keys = np.stack([temperature.shape_index[heard].astype(np.float64), delay_s[heard]], axis=1)
        distinct, of_heard = np.unique(keys, axis=0, return_inverse=True)
        index = np.full(len(heard), -1, dtype=np.intp)
        index[heard] = of_heard.reshape(-1)
        return cls(temperature, index, distinct[:, 0].astype(np.intp), distinct[:, 1])

    def values(self, frequency_hz: FloatArray) -> AnyArray:
        """Shape times exp(-2πi f τ) [c, F]; real where nothing is delayed."""
        shape: AnyArray = self.temperature.shape_values(frequency_hz)[self.shape]
        if not self.delay_s.any():
            return shape
        turned: AnyArray = shape * np.exp(-2j * np.pi * self.delay_s[:, None] * frequency_hz)
        return turned

    def rows(self, rows: FloatArray, factor: AnyArray) -> AnyArray:
        """Rows g [n_out, k] carried through level and correlation factor F [k, m], split by carrier: [n_out, c, m].

        Multiplied by `values` at a frequency and summed over c they are g A(f) D(f) F, D the phases of the delays.
        """
        parts = []
        for carrier in range(len(self.shape)):
            index = np.flatnonzero(self.index == carrier)
            # Row by row: what comes of an output is the same to the last bit whichever others there are.
            scaled = np.ascontiguousarray(rows[:, index] * self.temperature.scale[index])
            parts.append((scaled[:, None] @ factor[index])[:, 0])
        return np.stack(parts, axis=1)


@dataclass(frozen=True, eq=False)
class TemperatureNoise:
    """The temperature noise of k thermal areas: how large it is, and how it is correlated between them."""

    temperature: TemperatureModel
    correlation: Correlation

    @cached_property
    def carriers(self) -> Carriers:
        """The functions of frequency that the areas follow."""
        return Carriers.of(self.temperature, self.correlation.delay_s)

    def fields(self, rows: FloatArray) -> AnyArray:
        """Outputs with `rows` [n_out, k] per kelvin, split by carrier: [n_out, c, m], see `Carriers.rows`."""
        return self.carriers.rows(rows, self.correlation.factor)

    def psd(self, rows: FloatArray, frequency_hz: FloatArray) -> FloatArray:
        """One-sided PSD [n_out, F] of outputs with `rows` [n_out, k]."""
        return OutputNoise(rows, self, frequency_hz).psd()


@dataclass(frozen=True, eq=False)
class OutputNoise:
    """The noise that temperatures make of linear static outputs, at F frequencies.

    Parameters
    ----------
    rows : g [n_out, k], unit of the output per kelvin.
    source : the noise of the k temperatures.
    frequency_hz : [F].
    """

    rows: FloatArray
    source: TemperatureNoise
    frequency_hz: FloatArray

    @property
    def temperature(self) -> TemperatureModel:
        """Amplitudes of the temperatures."""
        return self.source.temperature

    @property
    def correlation(self) -> Correlation:
        """Correlation of the temperatures."""
        return self.source.correlation

    def of(self, rows: FloatArray) -> OutputNoise:
        """Of other outputs, with `rows` [n, k]."""
        return OutputNoise(rows, self.source, self.frequency_hz)

    def at(self, frequency_hz: FloatArray) -> OutputNoise:
        """At other frequencies [n]."""
        return OutputNoise(self.rows, self.source, frequency_hz)

    @cached_property
    def fields(self) -> AnyArray:
        """The rows split by carrier: [n_out, c, m]."""
        return self.source.fields(self.rows)

    @cached_property
    def carrier_values(self) -> AnyArray:
        """The carriers [c, F] at the frequencies."""
        return self.source.carriers.values(self.frequency_hz)

    def psd(self) -> FloatArray:
        """One-sided PSD [n_out, F], (unit of the output)²/Hz.

        Costs k m once and c² per frequency, c the number of distinct shapes and delays.
        """
        return psd_of_fields(self.fields, self.carrier_values)

    def cross_spectra(self) -> AnyArray:
        """One-sided cross-spectral densities Z C(f) Zᴴ of the outputs, [F, n_out, n_out], by their units; Hermitian.

        Real where no correlation and no delay is complex. The diagonal is `psd`.
        """
        fields, values = self.fields, self.carrier_values
        if len(values) == 1:
            one = fields[:, 0] @ fields[:, 0].conj().T
            return np.asarray((values[0].real ** 2 + values[0].imag ** 2)[:, None, None] * one)
        summed = [np.tensordot(values[:, f], fields, axes=(0, 1)) for f in range(values.shape[1])]
        return np.stack([y @ y.conj().T for y in summed])


def psd_of_fields(fields: AnyArray, values: AnyArray) -> FloatArray:
    """PSD [n_out, F] of the sum over carriers of `fields` [n_out, c, m] times `values` [c, F]."""
    # |Σ_a v_a y_a|² over m components equals |T v|², T the triangular factor of the [m, c] matrix of the y_a.
    triangle = np.linalg.qr(fields.transpose(0, 2, 1), mode="r")
    summed = triangle @ values
    psd: FloatArray = np.sum(summed.real**2 + summed.imag**2, axis=1)
    return psd


def output_psd(
    rows: FloatArray, temperature: TemperatureModel, correlation: AnyArray, frequency_hz: FloatArray
) -> FloatArray:
    """One-sided PSD [n_out, F] of outputs with `rows` [n_out, k] for a correlation matrix R [k, k].

    R may be complex Hermitian (phase shifts between areas); silent areas have zero rows. Raises `PhysicsError` where R
    is not a correlation matrix.
    """
    return TemperatureNoise(temperature, Correlation.of_factor(correlation_factor(correlation))).psd(rows, frequency_hz)
