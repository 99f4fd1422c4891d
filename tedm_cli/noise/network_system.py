"""What the noise of a thermal network may ask its network for: gains at any frequency, and the linear system."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from tedm_cli.arrays import ComplexArray, FloatArray
from tedm_cli.noise.temperature import Spectrum


@dataclass(frozen=True, eq=False)
class NetworkSystem:
    """x' = A x + B d, T = C x + D d, with the disturbances d of these spectra.

    a [n, n] in 1/s, b [n, u], c [k, n], d [k, u]; spectra [u].
    """

    a: FloatArray
    b: FloatArray
    c: FloatArray
    d: FloatArray
    spectra: tuple[Spectrum, ...]


class Network(Protocol):
    """The network behind the noise of k columns that u disturbances drive."""

    def driven(self, frequency_hz: FloatArray) -> ComplexArray:
        """Gain times amplitude spectral density of each disturbance, D [k, n, u] in K/√Hz, at any frequencies [n]."""

    def amplitudes(self, frequency_hz: FloatArray) -> FloatArray:
        """Amplitude spectral densities [u, n] of the disturbances, each in its own unit per √Hz."""

    def linear_system(self, where: str) -> NetworkSystem:
        """The linear system; `InputError` that names `where` for a network that is too large."""
