"""Noise sources of the loop: independent scalars, each a column over the disturbances with a spectrum of its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePath

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.dynamics.signals import DISTURBANCES
from tedm_cli.errors import InputError


@dataclass(frozen=True)
class PowerLaw:
    """One-sided PSD level² (1 + (corner/f)^slope); white where `corner_hz` is 0."""

    level: float
    corner_hz: float = 0.0
    slope: float = 0.0

    def psd(self, frequency_hz: FloatArray) -> FloatArray:
        """[F], square of the input's unit per Hz."""
        red = (self.corner_hz / frequency_hz) ** self.slope if self.corner_hz > 0.0 else 0.0
        out: FloatArray = self.level**2 * (1.0 + red) * np.ones(len(frequency_hz))
        return out

    def words(self) -> str:
        """Level, corner and slope."""
        if self.corner_hz == 0.0:
            return f"{self.level:g} per sqrt(Hz)"
        return f"{self.level:g} per sqrt(Hz), PSD rising as f^-{self.slope:g} below {self.corner_hz * 1e3:g} mHz"


@dataclass(frozen=True)
class SpectrumTable:
    """Amplitude spectral density through points, straight between them on logarithmic axes; nothing outside.

    Raises
    ------
    InputError : fewer than two points, frequencies that do not increase from above 0, levels not above 0; asked for
        outside the table.
    """

    frequency_hz: tuple[float, ...]
    asd: tuple[float, ...]
    name: str

    def __post_init__(self) -> None:
        f, a = np.array(self.frequency_hz), np.array(self.asd)
        if len(f) < 2 or not (np.diff(f, prepend=0.0) > 0.0).all():
            raise InputError("wants two frequencies or more, increasing from above 0", where=f"spectrum {self.name}")
        if not (np.isfinite(a) & (a > 0.0)).all():
            raise InputError("has a level that is not positive", where=f"spectrum {self.name}")

    def psd(self, frequency_hz: FloatArray) -> FloatArray:
        """[F], square of the input's unit per Hz."""
        low, high = self.frequency_hz[0] * (1.0 - 1e-9), self.frequency_hz[-1] * (1.0 + 1e-9)
        outside = (frequency_hz < low) | (frequency_hz > high)
        if outside.any():
            raise InputError(
                f"holds {self.frequency_hz[0]:g} to {self.frequency_hz[-1]:g} Hz, but"
                f" {frequency_hz[outside][0]:g} Hz is asked for",
                where=f"spectrum {self.name}",
                hint="nothing is assumed outside a table: extend it, or narrow the frequencies",
            )
        log = np.interp(np.log(frequency_hz), np.log(self.frequency_hz), np.log(self.asd))
        out: FloatArray = np.exp(2.0 * log)
        return out

    def words(self) -> str:
        """The table, without its folder, and its range."""
        return f"table {PurePath(self.name).name}, {self.frequency_hz[0]:g} to {self.frequency_hz[-1]:g} Hz"


@dataclass(frozen=True)
class NoiseSource:
    """A scalar noise: what it adds to which disturbances, its spectrum, the group it is told with, where it is from.

    `gains` maps names of `DISTURBANCES` to their gain, unit of the disturbance per unit of the spectrum.
    """

    name: str
    group: str
    gains: Mapping[str, float]
    spectrum: PowerLaw | SpectrumTable
    origin: str = ""


def columns(sources: Sequence[NoiseSource]) -> FloatArray:
    """[45, n]: the `DISTURBANCES` by each source; `InputError` for an unknown name or a source named twice."""
    out = np.zeros((len(DISTURBANCES), len(sources)))
    names = [source.name for source in sources]
    for j, source in enumerate(sources):
        if names.index(source.name) != j:
            raise InputError(f"two noise sources are called {source.name!r}")
        if not source.gains:
            raise InputError(f"noise source {source.name!r} acts on nothing")
        for name, gain in source.gains.items():
            if name not in DISTURBANCES:
                raise InputError(
                    f"noise source {source.name!r} acts on {name!r}, which is no disturbance",
                    hint="w_ and an input, n_ and a coordinate, or s_ and an acceleration: w_SC_Fx, n_TM1_x, s_TM1_a_x",
                )
            out[DISTURBANCES.index(name), j] = gain
    return out


def psd_of(sources: Sequence[NoiseSource], frequency_hz: FloatArray) -> FloatArray:
    """One-sided PSDs [n, F] of the sources."""
    if not sources:
        return np.zeros((0, len(frequency_hz)))
    return np.stack([source.spectrum.psd(frequency_hz) for source in sources])
