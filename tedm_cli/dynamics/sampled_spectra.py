"""Spectra of a loop with a sampled controller, exact with all that sampling folds: what its samples are expected to be.

The exact spectra of `closed_loop` take the sampler for a transfer function: what lies above half the sampling rate is
neither heard nor made. Here it is. A disturbance at ν moves the coordinates at ν; their samples y* are a sequence of
frequency f = ν - j/T to which the controller answers, u* = -K_c(e^{iωT}) y*; held commands act at every ν_k = f + k/T:

    y* = [1 + Σ_k P(ν_k) E H(ν_k) K_c]⁻¹ (p(ν) + mean of n),   P = (-ω² - K)⁻¹,   H = hold and delay

Åström and Wittenmark, Computer-Controlled Systems, chapter 7.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from tedm_cli.arrays import ComplexArray, FloatArray
from tedm_cli.dynamics.budget import squared
from tedm_cli.dynamics.closed_loop import OutputMap, output_map
from tedm_cli.dynamics.loops import pade_response
from tedm_cli.dynamics.own_controller import StateSpaceController
from tedm_cli.dynamics.plant import Plant
from tedm_cli.dynamics.signals import DISTURBANCES, N_COORDINATES, N_INPUTS, OUTPUTS
from tedm_cli.dynamics.sources import NoiseSource, columns, psd_of
from tedm_cli.dynamics.thermal_input import AnyThermal

_BLOCK = 128  # frequencies at once
_HEARD = 48  # rates of the samples on either side from which disturbances are folded: of white noise 1 % is farther
_MADE = 32  # the same of held commands: what they make falls with the square
_LEAST = 4  # sampling rates of the controller on either side
_N = slice(N_INPUTS, N_INPUTS + N_COORDINATES)
_S = slice(N_INPUTS + N_COORDINATES, len(DISTURBANCES))
_FELT = slice(N_INPUTS, len(DISTURBANCES))  # what temperatures do


def sampled_psd(
    plant: Plant,
    controller: StateSpaceController,
    sources: Sequence[NoiseSource],
    thermal_at: Callable[[FloatArray], AnyThermal],
    frequency_hz: FloatArray,
    labels: Sequence[str],
    periods: int,
) -> FloatArray:
    """One-sided PSD [n, F] of samples of the outputs, means over so many `periods` of the controller each.

    `thermal_at` gives the temperatures at any frequencies above 0; `frequency_hz` is above 0 and below half the rate of
    the samples. Second derivatives are second differences of samples.
    """
    assert controller.dt_s is not None
    rate = 1.0 / (periods * controller.dt_s)
    loop = _Loop(plant, controller, output_map(plant), [OUTPUTS.index(label) for label in labels], periods)
    total = np.zeros((len(frequency_hz), len(labels)))
    gains = columns(sources)
    for i in range(-(periods // 2), (periods + 1) // 2):  # what the mean over a sample folds, below the controller's
        base = np.abs(frequency_hz + i * rate)
        for first in range(0, len(base), _BLOCK):
            here = slice(first, first + _BLOCK)
            for nu, response in loop.responses(base[here]):
                thermal = thermal_at(np.abs(nu))
                # of real signals: at a negative frequency the conjugate
                response = np.where((nu < 0.0)[:, None, None], response.conj(), response)
                power = squared(response, gains) * psd_of(sources, np.abs(nu)).T[:, None, :]
                heat = response[:, :, _FELT] @ thermal.driven(thermal.columns[_FELT], slice(None))
                total[here] += power.sum(axis=2) + (heat.real**2 + heat.imag**2).sum(axis=2)
    return total.T


class _Loop:
    """Responses of samples to disturbances at every frequency that is folded to them."""

    def __init__(
        self, plant: Plant, controller: StateSpaceController, outputs: OutputMap, rows: Sequence[int], periods: int
    ) -> None:
        assert controller.dt_s is not None
        self._plant, self._controller, self._rows, self._periods = plant, controller, list(rows), periods
        self._dt, self._outputs = controller.dt_s, outputs
        self._heard, self._made = (max(_LEAST, -(-rates // periods)) for rates in (_HEARD, _MADE))

    def responses(self, base_hz: FloatArray) -> list[tuple[FloatArray, ComplexArray]]:
        """(ν [F], H [F, n, 45]) of `base_hz` [F] and of its aliases by the controller's sampling rate."""
        plant, rows, o = self._plant, self._rows, self._outputs
        s = 2j * np.pi * base_hz
        sample = self._periods * self._dt
        second = ((2.0 * np.cosh(s * sample) - 2.0) / sample**2)[:, None, None]
        by_p = o.by_p[rows] + second * o.by_p2[rows]
        by_d = o.by_d[rows] + second * o.by_d2[rows]
        control = self._controller.sequence(s)
        returned = np.zeros((len(s), N_COORDINATES, N_INPUTS), dtype=np.complex128)
        commanded = np.zeros((len(s), len(rows), N_INPUTS), dtype=np.complex128)
        for k in range(-self._made, self._made + 1):
            at = s + 2j * np.pi * k / self._dt
            made = (_mean(at * self._dt) * pade_response(at, self._controller.delay_s))[:, None, None]
            moved = self._moved(at, plant.E) * made
            returned += moved
            commanded += _mean(at * sample)[:, None, None] * (by_p @ moved + o.by_u[rows] * made)
        answer = -control @ np.linalg.inv(np.eye(N_COORDINATES) + returned @ control)
        found = []
        for j in range(-self._heard, self._heard + 1):
            at = s + 2j * np.pi * j / self._dt
            forced = np.zeros((N_COORDINATES, len(DISTURBANCES)))
            forced[:, :N_INPUTS], forced[:, _S] = plant.E, plant.E @ plant.stray_wrench
            free = self._moved(at, forced)
            heard = free.copy()
            heard[:, range(N_COORDINATES), range(_N.start, _N.stop)] += _mean(at * self._dt)[:, None]
            direct = _mean(at * sample)[:, None, None] * (by_p @ free + by_d)
            found.append((base_hz + j / self._dt, commanded @ (answer @ heard) + direct))
        return found

    def _moved(self, s: ComplexArray, forced: FloatArray) -> ComplexArray:
        matrix = (s * s)[:, None, None] * np.eye(N_COORDINATES) - self._plant.K
        out: ComplexArray = np.linalg.solve(matrix, forced.astype(np.complex128)[None])
        return out


def _mean(x: ComplexArray) -> ComplexArray:
    """(1 - e^{-x}) / x: a mean over the time that x is long, and a hold as well."""
    out: ComplexArray = -np.expm1(-x) / x
    return out
