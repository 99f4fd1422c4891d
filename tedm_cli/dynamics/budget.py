"""Noise budgets of the closed loop: total, by source and, with their signs, by thermal area."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from tedm_cli.arrays import AnyArray, ComplexArray, FloatArray
from tedm_cli.dynamics.closed_loop import responses
from tedm_cli.dynamics.controller import Controller
from tedm_cli.dynamics.plant import Plant
from tedm_cli.dynamics.signals import DISTURBANCES, N_COORDINATES, N_INPUTS, OUTPUTS
from tedm_cli.dynamics.sources import NoiseSource, columns, psd_of
from tedm_cli.dynamics.thermal_input import AnyThermal, FromDisturbances, NetworkInput

_READ_OUT = slice(N_INPUTS, N_INPUTS + N_COORDINATES)
_STRAY = slice(N_INPUTS + N_COORDINATES, len(DISTURBANCES))


@dataclass(frozen=True, eq=False)
class Budget:
    """One-sided PSDs, square of the output's unit per Hz, of the outputs in `labels` [n].

    Parameters
    ----------
    total : [F, n].
    by_source : [F, n, sources], of each noise source.
    thermal : [F, n], of all areas together; gravity : [F, n], of their accelerations alone; incoherent : [F, n],
        gravity and read-out apart: |S part|² + |N part|².
    area : by output, for those that were asked for: [F, k], signed part of each area in `thermal`: their sum is it.
    disturbance : of the same outputs, what the disturbances of a thermal network make; empty without one.
    """

    labels: tuple[str, ...]
    total: FloatArray
    by_source: FloatArray
    thermal: FloatArray
    gravity: FloatArray
    incoherent: FloatArray
    area: dict[str, FloatArray]
    disturbance: dict[str, FromDisturbances] = field(default_factory=dict)


def budget(
    plant: Plant,
    controller: Controller | None,
    sources: Sequence[NoiseSource],
    thermal: AnyThermal | None,
    frequency_hz: FloatArray,
    labels: Sequence[str] = (),
    *,
    areas_of: Sequence[str] = (),
    difference_s: float | None = None,
) -> Budget:
    """Noise of the outputs at `frequency_hz` [F] (above 0); parts by area for `areas_of` among the `labels`.

    `labels`: all outputs of the plant, where none is named.
    `difference_s` as for `closed_loop.responses`.

    PSD = Σ over sources |H col|² S + H V C Vᴴ Hᴴ, C the cross-spectra of the temperatures: A R Aᴴ, or D R Dᴴ of a
    thermal network. Gravity and read-out of one temperature add with their phases.
    """
    labels = labels or plant.outputs
    rows = [OUTPUTS.index(label) for label in labels]
    gains, spectra = columns(sources), psd_of(sources, frequency_hz)
    n, f = len(rows), len(frequency_hz)
    k = 0 if thermal is None else thermal.acceleration.shape[1]
    by_source = np.empty((f, n, len(sources)))
    heat, gravity, apart = np.zeros((f, n)), np.zeros((f, n)), np.zeros((f, n))
    area = np.zeros((f, len(areas_of), k))
    network = thermal if isinstance(thermal, NetworkInput) else None
    caused = np.zeros((f, len(areas_of), 0 if network is None else len(network.disturbances)), dtype=np.complex128)
    parted = [labels.index(label) for label in areas_of]
    for here, response in responses(plant, controller, frequency_hz, difference_s):
        chosen = response[:, rows]
        np.multiply(squared(chosen, gains), spectra[:, here].T[:, None, :], out=by_source[here])
        if thermal is not None:
            heat[here], gravity[here], apart[here], area[here] = _thermal(chosen, thermal, here, parted)
        if network is not None:
            caused[here] = network.by_disturbance(_per_kelvin(chosen[:, parted], network), here)
    by_area = {label: area[:, j] for j, label in enumerate(areas_of)}
    by_cause = {
        label: FromDisturbances(network.disturbances, caused[:, j], network.factor)
        for j, label in enumerate(areas_of if network is not None else ())
        if network is not None
    }
    return Budget(tuple(labels), by_source.sum(axis=2) + heat, by_source, heat, gravity, apart, by_area, by_cause)


def _thermal(
    response: ComplexArray, thermal: AnyThermal, here: slice, parted: Sequence[int]
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """PSDs [f, n] together, of gravity, of gravity and read-out apart; the areas' parts [f, n, k] of outputs `parted`.

    What drives the loop, V A F, is multiplied first: few columns where many areas are correlated.
    """
    by_gravity: ComplexArray = response[:, :, _STRAY] @ thermal.driven(thermal.acceleration, here)
    by_read_out: ComplexArray = response[:, :, _READ_OUT] @ thermal.driven(thermal.read_out, here)
    driven = by_gravity + by_read_out
    gravity = _size(by_gravity).sum(axis=-1)
    apart = gravity + _size(by_read_out).sum(axis=-1)
    alone = _per_kelvin(response[:, parted], thermal)
    area: FloatArray = (alone * thermal.returned(driven[:, parted], here).conj()).real
    return _size(driven).sum(axis=-1), gravity, apart, area


def _per_kelvin(response: ComplexArray, thermal: AnyThermal) -> ComplexArray:
    """Outputs [f, n, k] of `response` [f, n, 45] per kelvin of each temperature."""
    return np.asarray(response[:, :, _STRAY] @ thermal.acceleration + response[:, :, _READ_OUT] @ thermal.read_out)


def squared(response: ComplexArray, matrix: AnyArray) -> FloatArray:
    """|response @ matrix|²: response [f, n, d], matrix [d, m]; [f, n, m]. A real matrix by products of real numbers.

    Copies of both parts, since NumPy hands BLAS no matrix with gaps between its numbers and is ten times slower alone.
    """
    if np.iscomplexobj(matrix):
        return _size(response @ matrix)
    flat, real = response.reshape(-1, response.shape[-1]), np.asarray(matrix, dtype=np.float64)
    out, imaginary = (np.ascontiguousarray(part) @ real for part in (flat.real, flat.imag))
    np.square(out, out=out)
    np.square(imaginary, out=imaginary)
    out += imaginary
    return out.reshape(*response.shape[:-1], real.shape[1])


def _size(amplitude: ComplexArray) -> FloatArray:
    """|amplitude|²."""
    out: FloatArray = amplitude.real**2 + amplitude.imag**2
    return out
