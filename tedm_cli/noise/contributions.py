"""Which thermal areas an output's noise comes from.

Area i takes the share h_i Σ_j R_ij h_j / S of the power S = Σ_ij h_i R_ij h_j: its own power where it is uncorrelated,
and a signed part of its block's where it is correlated. A negative share cancels others; those of an output sum to 1.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import trapezoid

from tedm_cli.noise.propagation import shape_rows
from tedm_cli.noise.temperature import TemperatureModel

Array = NDArray[np.float64]
Matrix = NDArray[Any]  # real or complex


def amplitude_contributions(rows: Array, temperature: TemperatureModel, frequency_hz: Array) -> Array:
    """Signed h_i = g_i A_i(f) [n_out, k], unit of the output per √Hz, each at its own `frequency_hz` [n_out]."""
    contribution: Array = rows * temperature.amplitudes(frequency_hz).T
    return contribution


def shares_at(rows: Array, temperature: TemperatureModel, factor: Matrix, frequency_hz: float) -> Array:
    """Share [n_out, k] of each area in the PSD of each output at one frequency, for R = F Fᴴ with F [k, m]."""
    shape = temperature.shape_values(np.array([frequency_hz]))[:, 0]
    return _shares(rows, temperature, factor, np.outer(shape, shape))


def shares_over(rows: Array, temperature: TemperatureModel, factor: Matrix, frequency_hz: Array) -> Array:
    """Share [n_out, k] of each area in the power of each output between the first and last of `frequency_hz` [F]."""
    shape = temperature.shape_values(frequency_hz)
    return _shares(rows, temperature, factor, trapezoid(shape[:, None] * shape[None], frequency_hz, axis=-1))


def sum_by(values: Array, labels: NDArray[Any]) -> tuple[NDArray[Any], Array]:
    """Sums of `values` [n_out, k] over areas of equal label [k] (group, shield, shape): labels [q], sums [n_out, q]."""
    names, index = np.unique(labels, return_inverse=True)
    sums: Array = values @ np.eye(len(names))[index]
    return names, sums


def _shares(rows: Array, temperature: TemperatureModel, factor: Matrix, weight: Array) -> Array:
    """Shares for the products of shapes in `weight` [s, s]; zero for an output without any noise."""
    fields = shape_rows(rows, temperature, factor)  # [n_out, s, m]
    power = np.zeros(rows.shape)
    for shape in range(len(temperature.shapes)):
        index = np.flatnonzero(temperature.shape_index == shape)
        partner = np.tensordot(fields, weight[shape], axes=(1, 0))  # [n_out, m]
        cross = np.real(partner.conj() @ factor[index].T)
        power[:, index] = rows[:, index] * temperature.scale[index] * cross
    total = power.sum(axis=1, keepdims=True)
    return np.divide(power, total, out=np.zeros_like(power), where=total > 0.0)
