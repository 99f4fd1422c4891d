"""Exact propagation of temperature noise through linear static outputs (no realisation, no estimator bias).

With outputs y = g ΔT and the cross-spectral density C(f) = A(f) R A(f)ᴴ of the temperatures, the one-sided PSD of an
output is S_y(f) = g C(f) gᴴ. Everything here works on a factor R = F Fᴴ, so that S_y = |g A F|² stays non-negative and
keeps its accuracy where the areas of a block cancel; the quadratic form itself would lose twice as many digits.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tedm_cli.arrays import AnyArray, BoolArray, FloatArray, IndexArray
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

    def outputs(self, rows: FloatArray, frequency_hz: FloatArray) -> OutputNoise:
        """The noise of outputs with `rows` [n_out, k] at the frequencies [F]."""
        return OutputNoise(rows, self, frequency_hz)

    @property
    def active(self) -> BoolArray:
        """[k]: the areas that have noise."""
        return self.correlation.active

    @property
    def blocks(self) -> tuple[IndexArray, ...]:
        """Areas of each block; different blocks are uncorrelated."""
        return self.correlation.blocks

    @property
    def gradient(self) -> BoolArray:
        """[k]: the areas whose temperature is a gradient."""
        return self.temperature.gradient

    def distinct(self, frequency_hz: FloatArray) -> tuple[IndexArray, FloatArray]:
        """The spectrum [k] that each area has, and these [q, F]; see `TemperatureModel.distinct`."""
        return self.temperature.distinct(frequency_hz)

    def correlation_at(self, frequency_hz: float) -> Correlation:
        """The correlation, which is the same at all frequencies but for its delays."""
        return self.correlation

    def words(self) -> str:
        """The temperature model in words."""
        return self.temperature.words()


@dataclass(frozen=True, eq=False)
class Sizes:
    """Sums [n_out, F] of contributions h_i = g_i A_i(f) of the columns with noise.

    total : of all |h_i|; positive, negative : of those of one sign, with it; largest : the largest |h_i|.
    """

    total: FloatArray
    positive: FloatArray
    negative: FloatArray
    largest: FloatArray


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

    def components(self) -> AnyArray:
        """What the outputs are made of [n_out, m', F]: their sums of products over m' are the cross-spectra."""
        # Sums of squares over the m components are kept by the triangular factor of [m, n_out c].
        number, c, m = self.fields.shape
        triangle = np.asarray(np.linalg.qr(self.fields.reshape(number * c, m).T, mode="r"))
        fields = triangle.T.reshape(number, c, -1)
        return np.array([of.T @ self.carrier_values for of in fields])

    def terms(self) -> AnyArray:
        """What each area makes of the only output at the only frequency [k, m]; their sum over k is the output."""
        value = self.carrier_values[self.source.carriers.index, 0]
        return np.asarray((self.rows[0] * self.temperature.scale * value)[:, None] * self.correlation.factor)

    def in_phase(self) -> FloatArray:
        """PSD [n_out, F] if all areas shared one fluctuation, each with its own amplitude and none later."""
        together = Carriers.of(self.temperature)  # without delays
        shapes = together.values(self.frequency_hz)
        return psd_of_fields(together.rows(self.rows, np.ones((self.rows.shape[1], 1))), shapes)

    def area_powers(self) -> FloatArray:
        """Part [n_out, k] of each area in the PSD at one frequency, or in the power over F of them."""
        carriers, weight = self.source.carriers, self._products()
        power = np.zeros(self.rows.shape)
        for carrier in range(len(carriers.shape)):
            index = np.flatnonzero(carriers.index == carrier)
            partner = np.tensordot(self.fields, weight[carrier].conj(), axes=(1, 0))  # [n_out, m]
            cross = np.real(partner.conj() @ self.correlation.factor[index].T)
            power[:, index] = self.rows[:, index] * self.temperature.scale[index] * cross
        return power

    def path_powers(self) -> FloatArray:
        """Part [p] of each of the p outputs in their sum, at one frequency, or in the power over F of them."""
        partner = np.einsum("ab,bm->am", self._products().conj(), self.fields.sum(axis=0))
        power: FloatArray = np.real(np.einsum("pam,am->p", self.fields, partner.conj()))
        return power

    def sizes(self) -> Sizes:
        """Sums and largest of the sizes of all contributions of active areas."""
        temperature = self.temperature
        shape = temperature.shape_values(self.frequency_hz)
        # Shapes are never negative, so sums of sizes and of one sign need one term per shape.
        h = np.where(self.source.active, self.rows * temperature.scale, 0.0)
        member = np.eye(len(temperature.shapes))[temperature.shape_index]
        total = (np.abs(h) @ member) @ shape
        largest = np.zeros_like(total)
        for s in range(len(shape)):
            of_shape = np.abs(h[:, temperature.shape_index == s]).max(axis=1, initial=0.0)
            np.maximum(largest, of_shape[:, None] * shape[s], out=largest)
        return Sizes(total, (np.maximum(h, 0.0) @ member) @ shape, (np.minimum(h, 0.0) @ member) @ shape, largest)

    def block_amplitudes(self) -> tuple[FloatArray, FloatArray]:
        """Sum and largest [n_out, F] of the amplitudes √S_b of the blocks."""
        fields, values = self.fields, self.carrier_values
        column_block = self.correlation.column_block
        width = np.bincount(column_block)
        total = np.zeros((len(fields), len(self.frequency_hz)))
        largest = np.zeros_like(total)
        single = np.flatnonzero(width[column_block] == 1)  # columns that are all of their block
        for o in range(len(fields)) if single.size else ():  # one output at a time: [blocks, F] is the largest array
            amplitude = np.abs(fields[o][:, single].T @ values)
            total[o] += amplitude.sum(axis=0)
            np.maximum(largest[o], amplitude.max(axis=0), out=largest[o])
        for b in np.flatnonzero(width > 1):
            amplitude = np.sqrt(psd_of_fields(fields[:, :, column_block == b], values))
            total += amplitude
            np.maximum(largest, amplitude, out=largest)
        return total, largest

    def amplitude_contributions(self, frequency_hz: FloatArray) -> FloatArray:
        """Signed h_i = g_i A_i(f) [n_out, k], unit of the output per √Hz, each at its own `frequency_hz` [n_out]."""
        amplitude: FloatArray = self.rows * self.temperature.amplitudes(frequency_hz).T
        return np.asarray(amplitude * self.source.active)

    def _products(self) -> AnyArray:
        """v_a v_b* [c, c] of the carriers at one frequency, integrated over several."""
        value = self.carrier_values
        if len(self.frequency_hz) == 1:
            return np.outer(value[:, 0], value[:, 0].conj())
        products: AnyArray = (value * trapezoid(self.frequency_hz)) @ value.conj().T
        return products


def trapezoid(frequency_hz: FloatArray) -> FloatArray:
    """Weights [F] of the trapezoidal rule, by which an integral is one product of matrices; 1 for one frequency."""
    if len(frequency_hz) == 1:
        return np.ones(1)
    step = np.diff(frequency_hz)
    return np.asarray(0.5 * (np.append(step, 0.0) + np.append(0.0, step)))


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
