"""Exact propagation of temperature noise through linear static outputs (no realisation, no estimator bias).

With outputs y = g ΔT and the cross-spectral density C(f) = A(f) R A(f)ᴴ of the temperatures, the one-sided PSD of an
output is S_y(f) = g C(f) gᴴ. Everything here works on a factor R = F Fᴴ, so that S_y = |g A F|² stays non-negative and
keeps its accuracy where the areas of a block cancel; the quadratic form itself would lose twice as many digits.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tedm_cli.noise.correlation import correlation_factor
from tedm_cli.noise.temperature import TemperatureModel

Array = NDArray[np.float64]
Matrix = NDArray[Any]  # real or complex


def shape_rows(rows: Array, temperature: TemperatureModel, factor: Matrix) -> Matrix:
    """Rows g [n_out, k] carried through scale and correlation factor F [k, m], split by shape: [n_out, s, m].

    Multiplied by the shapes at a frequency and summed over s they are g A(f) F.
    """
    parts = []
    for shape in range(len(temperature.shapes)):
        index = np.flatnonzero(temperature.shape_index == shape)
        parts.append((rows[:, index] * temperature.scale[index]) @ factor[index])
    return np.stack(parts, axis=1)


def output_psd_from_factor(rows: Array, temperature: TemperatureModel, factor: Matrix, frequency_hz: Array) -> Array:
    """One-sided PSD [n_out, F] of outputs with `rows` [n_out, k] for R = F Fᴴ given by `factor` F [k, m].

    Unit: (unit of the output)²/Hz, for rows per kelvin. Costs k m once and s² per frequency, s the number of shapes.
    """
    # |Σ_a shape_a y_a|² over m components equals |T shape|², T the triangular factor of the [m, s] matrix of the y_a.
    triangle = np.linalg.qr(shape_rows(rows, temperature, factor).transpose(0, 2, 1), mode="r")
    fields = triangle @ temperature.shape_values(frequency_hz)
    psd: Array = np.sum(fields.real**2 + fields.imag**2, axis=1)
    return psd


def output_psd(rows: Array, temperature: TemperatureModel, correlation: Matrix, frequency_hz: Array) -> Array:
    """One-sided PSD [n_out, F] of outputs with `rows` [n_out, k] for a correlation matrix R [k, k].

    R may be complex Hermitian (phase shifts between areas); silent areas have zero rows. Raises `PhysicsError` where R
    is not a correlation matrix.
    """
    return output_psd_from_factor(rows, temperature, correlation_factor(correlation), frequency_hz)
