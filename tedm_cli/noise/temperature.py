"""Temperature noise of the thermal areas: amplitude spectral densities in K/√Hz, square roots of one-sided PSDs.

Published for the LISA Technology Package (Montemurro 2004, section 3.4): 1e-3 K/√Hz outside and 1e-4 K/√Hz inside the
thermal shield at 1 mHz, from low-pass filtered white noise. The order and the corner of that filter were **not**
published. `DEFAULT_ORDER` and `DEFAULT_CORNER_HZ` are an assumption: the corner at the lower end of the measurement
band, where the level is specified, and the lower of the two orders that suit the axes of figures 3.6 and 3.7 (they end
six to seven decades below the level at 1 mHz; from there to 0.1 Hz order 2 falls by 3.9 decades, order 3 by 5.9). They
matter: relative to its value at 1 mHz, the ratio of the read-out noise to its requirement grows up to 9-fold inside the
band for white noise, 3- to 4-fold for order 1, and at most 1.4-fold for order 2, for corners at or below 1 mHz.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tedm_cli.errors import InputError
from tedm_cli.noise.areas import AreaTable

Array = NDArray[np.float64]

OUTSIDE_LEVEL_K = 1e-3
INSIDE_LEVEL_K = 1e-4
REFERENCE_HZ = 1e-3
DEFAULT_ORDER = 2.0
DEFAULT_CORNER_HZ = 1e-3


@dataclass(frozen=True)
class ShapedSpectrum:
    """Low-pass spectrum of given level at a reference frequency.

    A(f) = A0 sqrt[(1 + (f0/fc)^2n) / (1 + (f/fc)^2n)]

    Parameters
    ----------
    level_K : A0, K/√Hz at `reference_hz`.
    reference_hz, corner_hz : f0 and fc, Hz.
    order : n, the order of the low-pass filter (slope f^-n far above the corner).
    """

    level_K: float
    reference_hz: float = REFERENCE_HZ
    corner_hz: float = DEFAULT_CORNER_HZ
    order: float = DEFAULT_ORDER

    def __post_init__(self) -> None:
        _check_level(self.level_K)
        for key in ("reference_hz", "corner_hz", "order"):
            value = getattr(self, key)
            if not (np.isfinite(value) and value > 0.0):
                raise InputError(f"{key} is {value:g}, not positive", where="temperature spectrum")

    def amplitude(self, frequency_hz: Array) -> Array:
        """Amplitude spectral density [F] in K/√Hz at `frequency_hz` [F]."""
        exponent = 2.0 * self.order
        top = 1.0 + (self.reference_hz / self.corner_hz) ** exponent
        amplitude: Array = self.level_K * np.sqrt(top / (1.0 + (frequency_hz / self.corner_hz) ** exponent))
        return amplitude


@dataclass(frozen=True)
class WhiteSpectrum:
    """The same amplitude spectral density `level_K`, K/√Hz, at every frequency."""

    level_K: float

    def __post_init__(self) -> None:
        _check_level(self.level_K)

    def amplitude(self, frequency_hz: Array) -> Array:
        """Amplitude spectral density [F] in K/√Hz at `frequency_hz` [F]."""
        return np.full(np.shape(frequency_hz), self.level_K)


Spectrum = ShapedSpectrum | WhiteSpectrum


@dataclass(frozen=True, eq=False)
class TemperatureModel:
    """Amplitude spectral density of every thermal area as a scale times one of a few distinct shapes.

    Parameters
    ----------
    scale : [k], K/√Hz.
    shape_index : [k], the shape of each area.
    shapes : the s distinct spectra, each of level 1.
    """

    scale: Array
    shape_index: NDArray[np.intp]
    shapes: tuple[Spectrum, ...]

    @classmethod
    def from_spectra(cls, spectra: Sequence[Spectrum]) -> TemperatureModel:
        """Model of k areas from one spectrum each; spectra that differ in level only share a shape."""
        shapes: dict[Spectrum, int] = {}
        index = [shapes.setdefault(replace(spectrum, level_K=1.0), len(shapes)) for spectrum in spectra]
        scale = np.array([spectrum.level_K for spectrum in spectra])
        return cls(scale, np.array(index, dtype=np.intp), tuple(shapes))

    @classmethod
    def by_shield(cls, areas: AreaTable, *, outside: Spectrum, inside: Spectrum) -> TemperatureModel:
        """Model with one spectrum outside and one inside the thermal shield."""
        return cls.from_spectra([outside if shield == "outside" else inside for shield in areas.shield])

    def shape_values(self, frequency_hz: Array) -> Array:
        """The distinct shapes [s, F] at `frequency_hz` [F]."""
        return np.stack([shape.amplitude(frequency_hz) for shape in self.shapes])

    def amplitudes(self, frequency_hz: Array) -> Array:
        """Amplitude spectral density [k, F] of every area, K/√Hz."""
        amplitude: Array = self.scale[:, None] * self.shape_values(frequency_hz)[self.shape_index]
        return amplitude

    def distinct(self, frequency_hz: Array) -> tuple[NDArray[np.intp], Array]:
        """Areas of equal spectrum: the set [k] each area is in, and one amplitude spectral density per set [q, F]."""
        keys = np.stack([self.shape_index.astype(np.float64), self.scale], axis=1)
        rows, first, index = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        values = rows[:, 1:] * self.shape_values(frequency_hz)[self.shape_index[first]]
        return index.reshape(-1).astype(np.intp), values

    def with_filter(self, order: float, corner_hz: float) -> TemperatureModel:
        """The same levels with every low-pass shape given another order and corner; white shapes stay."""
        shapes = tuple(
            replace(s, order=order, corner_hz=corner_hz) if isinstance(s, ShapedSpectrum) else s for s in self.shapes
        )
        return TemperatureModel(self.scale, self.shape_index, shapes)


def thesis_model(
    areas: AreaTable,
    *,
    outside_K: float = OUTSIDE_LEVEL_K,
    inside_K: float = INSIDE_LEVEL_K,
    reference_hz: float = REFERENCE_HZ,
    order: float = DEFAULT_ORDER,
    corner_hz: float = DEFAULT_CORNER_HZ,
) -> TemperatureModel:
    """Low-pass noise of the published levels in K/√Hz (Montemurro 2004, section 3.4); the filter is an assumption."""
    outside = ShapedSpectrum(outside_K, reference_hz, corner_hz, order)
    return TemperatureModel.by_shield(areas, outside=outside, inside=replace(outside, level_K=inside_K))


def white_model(
    areas: AreaTable, *, outside_K: float = OUTSIDE_LEVEL_K, inside_K: float = INSIDE_LEVEL_K
) -> TemperatureModel:
    """The levels published for 1 mHz, in K/√Hz, held over all frequencies: conservative above 1 mHz."""
    return TemperatureModel.by_shield(areas, outside=WhiteSpectrum(outside_K), inside=WhiteSpectrum(inside_K))


def _check_level(level_K: float) -> None:
    if not (np.isfinite(level_K) and level_K >= 0.0):
        raise InputError(f"level_K is {level_K:g}, not a finite amplitude", where="temperature spectrum")
