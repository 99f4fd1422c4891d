"""The noise of a case of the thermal network as a linear system driven by independent unit white noises.

The disturbances are what `state_space.noise_model` makes of them, d = C_f x_f + D_f w; the network follows them without
approximation:

    x' = A x + B d,   ΔT = C x + D d,   y = G ΔT
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from tedm_cli.arrays import ComplexArray, FloatArray
from tedm_cli.errors import InputError
from tedm_cli.noise.correlation import Correlation
from tedm_cli.noise.network import NetworkNoise
from tedm_cli.noise.network_system import NetworkSystem
from tedm_cli.noise.propagation import TemperatureNoise
from tedm_cli.noise.shaping.sampled_filter import covariance_factor, transition
from tedm_cli.noise.shaping.state_space import NoiseModel, StateSpace, noise_model
from tedm_cli.noise.temperature import TemperatureModel


@dataclass(frozen=True, eq=False)
class NetworkModel:
    """The white noises of a case of the thermal network, its `system`, and the outputs' rows G [p, k] per kelvin.

    disturbances : the noise of the disturbances, its outputs.
    """

    disturbances: NoiseModel
    system: NetworkSystem
    gain: FloatArray

    @property
    def state_names(self) -> list[str]:
        """Of the filters, then of the network's diffusive nodes."""
        return [*self.disturbances.state_names, *(f"network_x{i + 1}" for i in range(len(self.system.a)))]

    @property
    def states(self) -> int:
        """Number of states."""
        return len(self.state_names)

    @property
    def noises(self) -> int:
        """Number of white noises."""
        return self.disturbances.noises

    @property
    def direct(self) -> bool:
        """Whether white noise is fed through to outputs: by what follows a disturbance at once."""
        return bool((self.system.d @ self.disturbances.continuous().d).any())

    @property
    def shared(self) -> bool:
        """Whether filters share a white noise."""
        return self.disturbances.shared

    @property
    def deviation(self) -> float:
        """Largest relative deviation of a filter's amplitude from its spectrum."""
        return self.disturbances.deviation

    def psd(self, frequency_hz: FloatArray) -> FloatArray:
        """One-sided PSD [p, F] of the outputs."""
        s = self.system
        columns = self.disturbances.response(frequency_hz)  # [u, m, F]
        rows_c, rows_d = self.gain @ s.c, self.gain @ s.d
        total = np.empty((len(self.gain), len(frequency_hz)))
        for number, f in enumerate(frequency_hz):
            driven: ComplexArray = np.linalg.solve(2j * np.pi * f * np.eye(len(s.a)) - s.a, s.b @ columns[:, :, number])
            y = rows_c @ driven + rows_d @ columns[:, :, number]
            total[:, number] = (y.real**2 + y.imag**2).sum(axis=1)
        return total

    def continuous(self) -> StateSpace:
        """A, B, C, D, driven by white noise of one-sided PSD 1/Hz; states of the filters first."""
        s, filters = self.system, self.disturbances.continuous()
        n, m = len(s.a), len(filters.a)
        a = np.block([[filters.a, np.zeros((m, n))], [s.b @ filters.c, s.a]])
        b = np.concatenate([filters.b, s.b @ filters.d])
        temperature_c, temperature_d = np.concatenate([s.d @ filters.c, s.c], axis=1), s.d @ filters.d
        covariance = scipy.linalg.solve_continuous_lyapunov(a, -0.5 * b @ b.T)
        return StateSpace(
            a,
            b,
            self.gain @ temperature_c,
            self.gain @ temperature_d,
            temperature_c,
            temperature_d,
            covariance_factor(0.5 * (covariance + covariance.T)),
        )

    def discrete(self, rate_hz: float) -> StateSpace:
        """The same at `rate_hz` samples per second, driven by standard normal numbers; see `sampled_filter.sampled`."""
        s, step_s = self.continuous(), 1.0 / rate_hz
        n, k = len(s.a), len(s.temperature_d)
        if not self.direct:
            a, b = transition(s.a, s.b, step_s)
            c_t, d_t = s.temperature_c, np.zeros((k, b.shape[1]))
            return StateSpace(a, b, self.gain @ c_t, self.gain @ d_t, c_t, d_t, s.x0)
        # What feeds through is of disturbances; the last states are their integrals. Means over the step.
        fed = self.disturbances.continuous()
        u, m = len(fed.d), len(fed.a)
        wide = np.zeros((n + n + u, n + n + u))
        wide[:n, :n], wide[n : n + n, :n] = s.a, np.eye(n)
        wide[n + n :, :m] = fed.c
        driven = np.concatenate([s.b, np.zeros((n, s.b.shape[1])), fed.d])
        whole, noise = transition(wide, driven, step_s)
        mean_c = np.concatenate([np.zeros((k, m)), self.system.c], axis=1)
        c_t = (mean_c @ whole[n : n + n, :n] + self.system.d @ whole[n + n :, :n]) / step_s
        d_t = (mean_c @ noise[n : n + n] + self.system.d @ noise[n + n :]) / step_s
        return StateSpace(whole[:n, :n], noise[:n], self.gain @ c_t, self.gain @ d_t, c_t, d_t, s.x0)


def network_model(
    rows: FloatArray, source: NetworkNoise, band_hz: tuple[float, float], tolerance: float, where: str
) -> NetworkModel:
    """The noise of outputs with `rows` [p, k] per kelvin; `where` (a case) is for messages.

    Raises
    ------
    InputError : the network is too large, or there is none behind the noise.
    PhysicsError : a spectrum cannot be realised to the tolerance.
    """
    if source.network is None:
        raise InputError("has gains alone, and no network that has states", where=where)
    system = source.network.linear_system(where)
    temperature = TemperatureModel.from_spectra(system.spectra)
    of = TemperatureNoise(temperature, Correlation.of_factor(source.factor))
    return NetworkModel(noise_model(np.eye(len(system.spectra)), of, band_hz, tolerance, where), system, rows)
