"""The noise of all outputs of a case as a linear system driven by independent unit white noises.

    x' = A x + B w,  y = C x + D w,  ΔT = C_T x + D_T w,  y = G ΔT

with one shaping filter per white noise w_j and the spectral shapes it drives. w_j has the one-sided PSD 1/Hz: the
two-sided PSD, and the intensity of E[w(t) w(t')] = I δ(t - t') / 2, is 1/2. For R = F Fᵀ the temperatures are
ΔT_i = level_i Σ_j F_ij (filter of area i's shape) w_j.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import ComplexArray, FloatArray
from tedm_cli.errors import InputError
from tedm_cli.noise.correlation import Correlation
from tedm_cli.noise.correlation_check import correlation_factor
from tedm_cli.noise.propagation import TemperatureNoise
from tedm_cli.noise.shaping.sampled_filter import SampledFilter, covariance_factor, sampled
from tedm_cli.noise.shaping.shaping_filter import ShapingFilter, shaping_filter

_HINT = "leave the delays out, or propagate the case with run-case, which is exact"


@dataclass(frozen=True, eq=False)
class NoiseInput:
    """One white noise: its filter, and the weights [k, q] with which the filter's outputs heat the areas."""

    filter: ShapingFilter
    weight: FloatArray
    shapes: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class StateSpace:
    """Matrices of a system with n states, m inputs, p outputs and k areas.

    a [n, n], b [n, m], c [p, n], d [p, m]; temperature_c [k, n] and temperature_d [k, m] in K; x0 [n, n] a factor
    of the stationary covariance of x. Continuous: time in s, inputs white noise of one-sided PSD 1/Hz. Sampled: inputs
    are independent standard normal numbers, and x is advanced by one sample.
    """

    a: FloatArray
    b: FloatArray
    c: FloatArray
    d: FloatArray
    temperature_c: FloatArray
    temperature_d: FloatArray
    x0: FloatArray


@dataclass(frozen=True, eq=False)
class NoiseModel:
    """The white noises of a case, and the outputs' rows G [p, k] per kelvin."""

    inputs: tuple[NoiseInput, ...]
    gain: FloatArray

    @property
    def state_names(self) -> list[str]:
        """Of the filters, by their white noise."""
        return [f"w{j + 1}_x{i + 1}" for j, one in enumerate(self.inputs) for i in range(len(one.filter.b))]

    @property
    def states(self) -> int:
        """Number of states."""
        return len(self.state_names)

    @property
    def noises(self) -> int:
        """Number of white noises."""
        return len(self.inputs)

    @property
    def direct(self) -> bool:
        """Whether white noise is fed through to outputs."""
        return any(i.filter.d.any() for i in self.inputs)

    @property
    def shared(self) -> bool:
        """Whether filters share a white noise."""
        return any(len(i.shapes) > 1 for i in self.inputs)

    @property
    def deviation(self) -> float:
        """Largest relative deviation of a filter's amplitude from its spectrum."""
        return max((float(i.filter.deviation.max()) for i in self.inputs), default=0.0)

    def psd(self, frequency_hz: FloatArray) -> FloatArray:
        """One-sided PSD [p, F] of the outputs."""
        return np.asarray((np.abs(self.response(frequency_hz)) ** 2).sum(axis=1))

    def response(self, frequency_hz: FloatArray) -> ComplexArray:
        """Outputs [p, m, F] of each white noise, unit of the output per √Hz, with their phases."""
        out: ComplexArray = np.empty((len(self.gain), self.noises, len(frequency_hz)), dtype=np.complex128)
        responses: dict[int, ComplexArray] = {}
        for number, i in enumerate(self.inputs):
            if id(i.filter) not in responses:
                responses[id(i.filter)] = i.filter.response(frequency_hz)
            out[:, number] = (self.gain @ i.weight) @ responses[id(i.filter)]
        return out

    def continuous(self) -> StateSpace:
        """A, B, C, D, driven by white noise of one-sided PSD 1/Hz."""
        parts = [SampledFilter(i.filter.a, i.filter.b[:, None], i.filter.c, i.filter.d[:, None]) for i in self.inputs]
        return self._assembled(parts)

    def discrete(self, rate_hz: float) -> StateSpace:
        """The same at `rate_hz` samples per second, driven by standard normal numbers; see `sampled`."""
        made: dict[int, SampledFilter] = {}
        for i in self.inputs:
            if id(i.filter) not in made:
                made[id(i.filter)] = sampled(i.filter, 1.0 / rate_hz)
        return self._assembled([made[id(i.filter)] for i in self.inputs])

    def _assembled(self, parts: list[SampledFilter]) -> StateSpace:
        n, m, k = self.states, sum(p.b.shape[1] for p in parts), self.gain.shape[1]
        a, b, x0 = np.zeros((n, n)), np.zeros((n, m)), np.zeros((n, n))
        c, d = np.zeros((k, n)), np.zeros((k, m))
        y_c, y_d = np.zeros((len(self.gain), n)), np.zeros((len(self.gain), m))
        row = column = 0
        for i, part in zip(self.inputs, parts, strict=True):
            x, w = slice(row, row + len(part.a)), slice(column, column + part.b.shape[1])
            a[x, x], b[x, w] = part.a, part.b
            c[:, x], d[:, w] = i.weight @ part.c, i.weight @ part.d
            rows = self.gain @ i.weight  # areas of one noise cancel here, before the filter's rounding
            y_c[:, x], y_d[:, w] = rows @ part.c, rows @ part.d
            x0[x, x] = covariance_factor(i.filter.covariance())
            row, column = x.stop, w.stop
        return StateSpace(a, b, y_c, y_d, c, d, x0)


def noise_model(
    rows: FloatArray, source: TemperatureNoise, band_hz: tuple[float, float], tolerance: float, where: str
) -> NoiseModel:
    """The noise of outputs with `rows` [p, k] per kelvin; `where` (a case) is for messages.

    Raises
    ------
    InputError : areas that share noise follow with different delays, or R is complex: neither is a state space.
    PhysicsError : a spectrum cannot be realised to the tolerance.
    """
    temperature, correlation = source.temperature, source.correlation
    factor = _real_factor(correlation, where)
    silent = temperature.scale == 0.0
    filters: dict[tuple[int, ...], ShapingFilter] = {}
    inputs = []
    for column in factor.T:
        driven = np.flatnonzero((column != 0.0) & ~silent)
        if not driven.size:
            continue
        delays = np.unique(correlation.delay_s[driven])
        if len(delays) > 1:
            fact = (
                f"areas that share noise follow each other by {delays[-1] - delays[0]:g} s; a delay has no state space"
            )
            raise InputError(fact, where=where, hint=_HINT)
        used, local = np.unique(temperature.shape_index[driven], return_inverse=True)
        shapes = tuple(int(s) for s in used)
        if shapes not in filters:
            spectra = tuple(temperature.shapes[s] for s in shapes)
            filters[shapes] = shaping_filter(spectra, band_hz, tolerance)
        weight = np.zeros((len(column), len(shapes)))
        weight[driven, local] = temperature.scale[driven] * column[driven]
        inputs.append(NoiseInput(filters[shapes], weight, shapes))
    return NoiseModel(tuple(inputs), rows)


def _real_factor(correlation: Correlation, where: str) -> FloatArray:
    """F [k, m] of a real R."""
    if not np.iscomplexobj(correlation.factor):
        return correlation.factor
    matrix = correlation.matrix()
    if np.abs(matrix.imag).max() > 1e-12:
        raise InputError(
            "its correlation is complex: a phase shift that is the same at all frequencies has no state space",
            where=where,
            hint="give a real matrix, or propagate the case with run-case, which is exact",
        )
    real: FloatArray = correlation_factor(matrix.real)
    return real
