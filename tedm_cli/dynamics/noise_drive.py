"""Noise of the loop as a system driven by white noise: shaping filters of its sources, and of the temperatures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray
from tedm_cli.dynamics.loops import StateSpace
from tedm_cli.dynamics.signals import DISTURBANCES
from tedm_cli.dynamics.sources import NoiseSource, PowerLaw, columns
from tedm_cli.noise.shaping.shaping_filter import ShapingFilter, shaping_filter
from tedm_cli.noise.temperature import TabulatedSpectrum, WhiteSpectrum

_FIT_POINTS = 241


@dataclass(frozen=True, eq=False)
class WhiteDriven:
    """Disturbances [45] as a system driven by m white noises of one-sided PSD 1/Hz."""

    system: StateSpace


def noise_drive(sources: Sequence[NoiseSource], band_hz: tuple[float, float], tolerance: float) -> WhiteDriven:
    """Shaping filters of all sources, each within `tolerance` of its spectrum over `band_hz`, level beyond.

    A shape that several sources share is fitted once: a fit takes seconds. Raises `PhysicsError` for a spectrum that no
    filter reaches.
    """
    fitted: dict[bytes, tuple[ShapingFilter, float]] = {}
    filters, levels = [], []
    f = np.geomspace(*band_hz, _FIT_POINTS)
    for source in sources:
        amplitude: FloatArray = np.sqrt(source.spectrum.psd(f))
        shape = np.round(np.log(amplitude / amplitude[-1]), 12).tobytes()
        if shape not in fitted:
            fitted[shape] = _filter(source, f, amplitude, band_hz, tolerance), float(amplitude[-1])
        one, size = fitted[shape]
        filters.append(one)
        levels.append(float(amplitude[-1]) / size)
    gains = columns(sources) * np.array(levels)
    if not filters:
        return WhiteDriven(StateSpace.gain(np.zeros((len(DISTURBANCES), 0))))
    return WhiteDriven(
        StateSpace(
            scipy.linalg.block_diag(*(f.a for f in filters)),
            scipy.linalg.block_diag(*(f.b[:, None] for f in filters)).reshape(-1, len(filters)),
            gains @ scipy.linalg.block_diag(*(f.c for f in filters)),
            gains @ np.diag([float(f.d[0]) for f in filters]),
        )
    )


def _filter(
    source: NoiseSource, f: FloatArray, amplitude: FloatArray, band_hz: tuple[float, float], tolerance: float
) -> ShapingFilter:
    spectrum = source.spectrum
    if isinstance(spectrum, PowerLaw) and (spectrum.corner_hz == 0.0 or spectrum.slope == 0.0):
        return shaping_filter((WhiteSpectrum(float(amplitude[-1])),), band_hz, tolerance)
    return shaping_filter((TabulatedSpectrum.of(f, amplitude, source.name),), band_hz, tolerance)


def together(drives: Sequence[WhiteDriven]) -> WhiteDriven:
    """Independent drives as one."""
    parts = [d.system for d in drives]
    c, d = (np.concatenate([getattr(p, name) for p in parts], axis=1) for name in "cd")
    a, b = (scipy.linalg.block_diag(*(getattr(p, name) for p in parts)) for name in "ab")
    states, inputs = sum(len(p.a) for p in parts), d.shape[1]
    return WhiteDriven(StateSpace(a.reshape(states, states), b.reshape(states, inputs), c, d))
