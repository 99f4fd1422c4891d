"""A thermal network of two nodes, known as a linear system."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.noise.correlation_check import correlation_factor
from tedm_cli.noise.network import NetworkNoise
from tedm_cli.noise.network_system import NetworkSystem
from tedm_cli.noise.temperature import ShapedSpectrum, Spectrum

BAND = (1e-4, 1e-1)
F = np.geomspace(*BAND, 41)
R = np.array([[1.0, 0.6], [0.6, 1.0]])
SPECTRA = (ShapedSpectrum(1e-3, order=2.0), ShapedSpectrum(3e-3, order=1.0))
ROWS = np.array([[1.0, -0.7, 0.2], [0.0, 0.3, -1.1]])


@dataclass(frozen=True, eq=False)
class Known:
    """A network that is known as a system."""

    of: NetworkSystem

    def driven(self, frequency_hz: np.ndarray) -> np.ndarray:
        s = self.of
        by_state = 2j * np.pi * frequency_hz[:, None, None] * np.eye(len(s.a)) - s.a
        gain = s.c @ np.linalg.solve(by_state, s.b[None]) + s.d
        return gain.transpose(1, 0, 2) * self.amplitudes(frequency_hz).T

    def amplitudes(self, frequency_hz: np.ndarray) -> np.ndarray:
        return np.stack([s.amplitude(frequency_hz) for s in self.of.spectra])

    def linear_system(self, where: str) -> NetworkSystem:
        return self.of


def network(spectra: tuple[Spectrum, Spectrum] = SPECTRA, *, correlated: bool, fed: bool) -> NetworkNoise:
    """Two nodes in a ladder and a third column: a boundary where `fed`, else the mean of both."""
    a = 2 * np.pi * np.array([[-2e-3, 1e-3], [5e-4, -7e-4]])
    b = 2 * np.pi * np.array([[1e-3, 0.0], [0.0, 2e-4]])
    c = np.array([[1.0, 0.0], [0.0, 1.0], [0.5, 0.5]])
    d = np.zeros((3, 2))
    if fed:
        c[2], d[2] = 0.0, [1.0, 0.0]
    correlation = R if correlated else np.eye(2)
    known = Known(NetworkSystem(a, b, c, d, spectra))
    factor = correlation_factor(correlation)
    return NetworkNoise(
        known.driven(F), F, ("one", "other"), factor, (np.arange(3),), np.zeros(factor.shape[1], int),
        np.zeros(3, dtype=bool), "network", known,
    )  # fmt: skip
