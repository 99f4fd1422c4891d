"""Temperature noise as the loop feels it: of areas that are correlated by assumption, or of a thermal network."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import AnyArray, ComplexArray, FloatArray
from tedm_cli.dynamics.signals import N_INPUTS


@dataclass(frozen=True, eq=False)
class _Columns:
    """Accelerations of the test masses and read-outs of one temperature each, coherent.

    Parameters
    ----------
    acceleration : S [12, k] per kelvin, in the order of `signals.STRAY`.
    read_out : N [15, k] per kelvin, in the order of `signals.COORDINATES`; zero for what no bench reads.
    """

    acceleration: FloatArray
    read_out: FloatArray

    @property
    def columns(self) -> FloatArray:
        """V [45, k]: disturbances per kelvin."""
        return np.concatenate([np.zeros((N_INPUTS, self.acceleration.shape[1])), self.read_out, self.acceleration])


@dataclass(frozen=True, eq=False)
class ThermalInput(_Columns):
    """Temperature noise of k areas, whose correlation is the same at all frequencies but for delays.

    Parameters
    ----------
    factor : F [k, m] of the correlation matrix, R = F Fᴴ.
    amplitude : A(f) [k, F], K/√Hz, complex where areas follow later than others.
    """

    factor: AnyArray
    amplitude: AnyArray

    def driven(self, rows: FloatArray, here: slice) -> AnyArray:
        """What the independent fluctuations make of `rows` [r, k] at some frequencies: rows A F [f, r, m]."""
        return np.asarray((rows * self.amplitude[:, here].T[:, None, :]) @ self.factor)

    def returned(self, driven: ComplexArray, here: slice) -> ComplexArray:
        """y (A F)ᴴ [f, n, k] of outputs y [f, n, m] that the fluctuations make."""
        return np.asarray((driven @ self.factor.conj().T) * self.amplitude[:, here].T[:, None, :].conj())


@dataclass(frozen=True, eq=False)
class NetworkInput(_Columns):
    """Temperature noise of k thermal nodes that u disturbances reach by a gain of its own each.

    Parameters
    ----------
    drive : D [k, F, u], K/√Hz: gain times amplitude spectral density of each disturbance.
    disturbances : [u], names. factor : L [u, m], of their correlation R = L Lᵀ.
    """

    drive: ComplexArray
    disturbances: tuple[str, ...]
    factor: FloatArray

    def driven(self, rows: FloatArray, here: slice) -> ComplexArray:
        """What the independent fluctuations make of `rows` [r, k] at some frequencies: rows D L [f, r, m]."""
        return np.asarray(rows @ self._drive(here) @ self.factor)

    def returned(self, driven: ComplexArray, here: slice) -> ComplexArray:
        """y (D L)ᴴ [f, n, k] of outputs y [f, n, m] that the fluctuations make."""
        return np.asarray((driven @ self.factor.T) @ self._drive(here).conj().transpose(0, 2, 1))

    def by_disturbance(self, outputs: ComplexArray, here: slice) -> ComplexArray:
        """What each disturbance makes of outputs with rows [f, n, k] per kelvin: [f, n, u], with its phase."""
        return np.asarray(outputs @ self._drive(here))

    def _drive(self, here: slice) -> ComplexArray:
        """D [f, k, u]."""
        return np.asarray(self.drive[:, here].transpose(1, 0, 2))


AnyThermal = ThermalInput | NetworkInput


@dataclass(frozen=True, eq=False)
class FromDisturbances:
    """What the u disturbances of a thermal network make of one output.

    Parameters
    ----------
    names : [u]. amplitude : [F, u], unit of the output per √Hz, with its phase.
    factor : L [u, m], of their correlation R = L Lᵀ.
    """

    names: tuple[str, ...]
    amplitude: ComplexArray
    factor: FloatArray

    def parts(self) -> FloatArray:
        """Part [F, u] of each in the PSD; negative where it cancels others that it is correlated with."""
        together = (self.amplitude @ self.factor) @ self.factor.T
        return np.asarray((self.amplitude.conj() * together).real)

    def components(self) -> ComplexArray:
        """What each makes of the output by independent fluctuations, [u, m, F]; their sum over u is all of it."""
        return np.asarray(self.amplitude.T[:, None, :] * self.factor[:, :, None])
