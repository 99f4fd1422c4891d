"""The loop of a sampled controller: plant and delay over a period with the commands held, then the controller.

At every period the controller hears y = p + n and holds its commands until the next, through the delay. White noise has
no value at a time, so of noise it hears the mean over the period that ends there, as a read-out that is averaged gives
it: a white spectrum stays as it is. Signals that are straight between samples have values, and those are heard; outputs
are told as means over the period before, in which commands jump.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.dynamics.closed_loop import output_map
from tedm_cli.dynamics.loops import StateSpace
from tedm_cli.dynamics.noise_drive import WhiteDriven
from tedm_cli.dynamics.own_controller import StateSpaceController, delays
from tedm_cli.dynamics.plant import Plant
from tedm_cli.dynamics.signals import DISTURBANCES, N_COORDINATES, N_INPUTS, OUTPUTS
from tedm_cli.dynamics.steps import (
    NoiseSteps,
    StraightSteps,
    balanced_transition,
    repeated,
    stationary_steps,
    straight_gains,
)
from tedm_cli.errors import PhysicsError

_M = len(DISTURBANCES)
_READ_OUT = slice(N_INPUTS, N_INPUTS + N_COORDINATES)
_WHOLE = 1e-9  # of a period, between samples and periods that are said to fit
_MOST_PERIODS = 10**6  # in a sample


@dataclass(frozen=True, eq=False)
class SampledTimeLoop:
    """`in_time.TimeLoop` of a sampled controller.

    Parameters
    ----------
    body : plant and delay; states p, p' and those of the delay, inputs `DISTURBANCES` [45] and commands u [18], outputs
        as of a `TimeLoop`.
    control : from y [15] to minus u [18], in steps of `dt_s`.
    """

    labels: tuple[str, ...]
    second: tuple[int, ...]
    body: StateSpace
    control: StateSpace
    dt_s: float

    def periods(self, step_s: float) -> int:
        """Periods of the controller between samples `step_s` apart; `PhysicsError` where that is no whole number."""
        ratio = step_s / self.dt_s
        whole = max(1, round(ratio))
        if abs(ratio - whole) > _WHOLE * whole or whole > _MOST_PERIODS:
            raise PhysicsError(
                f"samples of {step_s:.9g} s are no whole number of the controller's periods of {self.dt_s:g} s"
                if whole <= _MOST_PERIODS
                else f"samples of {step_s:.9g} s hold {whole:,} of the controller's periods of {self.dt_s:g} s",
                hint=f"take samples of {self.dt_s * min(whole, _MOST_PERIODS):.9g} s"
                f" ({1.0 / (self.dt_s * min(whole, _MOST_PERIODS)):.9g} Hz)",
            )
        return whole

    def under_noise(self, drive: WhiteDriven, step_s: float) -> NoiseSteps:
        times, dt = self.periods(step_s), self.dt_s
        body, noise, control = self.body, drive.system, self.control
        nf, nb, nc, q = len(noise.a), len(body.a), len(control.a), len(body.c)
        # over a period: filters, body, held commands, integrals of the outputs, integrals of the read-out noise
        sizes = np.cumsum([nf, nb, N_INPUTS, q, N_COORDINATES])
        f, x, u, out, heard = (slice(a, b) for a, b in zip([0, *sizes[:-1]], sizes, strict=True))
        a, b = np.zeros((sizes[-1], sizes[-1])), np.zeros((sizes[-1], noise.b.shape[1]))
        a[f, f], b[f] = noise.a, noise.b
        a[x, f], a[x, x], a[x, u], b[x] = body.b[:, :_M] @ noise.c, body.a, body.b[:, _M:], body.b[:, :_M] @ noise.d
        a[out, f], a[out, x], a[out, u] = body.d[:, :_M] @ noise.c, body.c, body.d[:, _M:]
        b[out] = body.d[:, :_M] @ noise.d
        a[heard, f], b[heard] = noise.c[_READ_OUT], noise.d[_READ_OUT]
        phi, factor = balanced_transition(a, b, dt)
        # states between periods: filters, body, controller, mean of the read-out noise over the period before
        n = nf + nb + nc + N_COORDINATES
        own, mean = slice(nf + nb, nf + nb + nc), slice(n - N_COORDINATES, n)
        y = np.zeros((N_COORDINATES, n))
        y[:, nf : nf + N_COORDINATES] = y[:, mean] = np.eye(N_COORDINATES)
        begin = np.zeros((nf + nb + N_INPUTS, n))  # filters, body and commands at the beginning of a period
        begin[: nf + nb, : nf + nb] = np.eye(nf + nb)
        begin[nf + nb :] = -control.d @ y
        begin[nf + nb :, own] -= control.c
        over = phi[:, : nf + nb + N_INPUTS] @ begin
        r = factor.shape[1]
        step, kick = np.zeros((n, n)), np.zeros((n, r))
        step[: nf + nb], kick[: nf + nb] = over[: nf + nb], factor[: nf + nb]
        step[own] = control.b @ y
        step[own, own] += control.a
        step[mean], kick[mean] = over[heard] / dt, factor[heard] / dt
        start = stationary_steps(step, kick)
        # so many periods are one sample: with the integrals of the outputs as states that begin at 0
        wide, gathered = np.zeros((n + q, n + q)), np.zeros((n + q, r))
        wide[:n, :n], wide[n:, :n], wide[n:, n:] = step, over[out] / step_s, np.eye(q)
        gathered[:n], gathered[n:] = kick, factor[out] / step_s
        wide, gathered = repeated(wide, gathered, times)
        return NoiseSteps(np.ascontiguousarray(wide[:n, :n]), gathered[:n], wide[n:, :n], gathered[n:], start)

    def under_signals(self, disturbances: FloatArray, step_s: float) -> StraightSteps:
        times, dt = self.periods(step_s), self.dt_s
        body, control, k = self.body, self.control, disturbances.shape[1]
        nb, nc, q = len(body.a), len(control.a), len(body.c)
        # over a period: body and integrals of the outputs, under signals and held commands
        a = np.block([[body.a, np.zeros((nb, q))], [body.c / dt, np.zeros((q, q))]])
        felt = np.concatenate([body.b, body.d / dt])
        phi, early, late = straight_gains(a, np.concatenate([felt[:, :_M] @ disturbances, felt[:, _M:]], axis=1), dt)
        held = early[:, k:] + late[:, k:]
        # states between periods: body, means of the outputs over the period before, controller
        out, n = nb + q, nb + q + nc
        y, y_d = np.zeros((N_COORDINATES, n)), disturbances[_READ_OUT]
        y[:, :N_COORDINATES] = np.eye(N_COORDINATES)
        u, u_d = -control.d @ y, -control.d @ y_d
        u[:, out:] -= control.c
        step, at, slope = np.zeros((n, n)), np.zeros((n, k)), np.zeros((n, k))
        step[:out] = held @ u
        step[:out, :nb] += phi[:, :nb]
        step[out:] = control.b @ y
        step[out:, out:] += control.a
        at[:out], at[out:] = early[:, :k] + late[:, :k] + held @ u_d, control.b @ y_d
        slope[:out] = late[:, :k]
        # so many periods are one sample: the signals and what they gain in a period as states
        wide = np.zeros((n + 2 * k, n + 2 * k))
        wide[:n, :n], wide[:n, n : n + k], wide[:n, n + k :] = step, at, slope
        wide[n : n + k, n : n + k] = wide[n : n + k, n + k :] = wide[n + k :, n + k :] = np.eye(k)
        wide = np.linalg.matrix_power(wide, times)
        after = wide[:n, n + k :] / times
        told = np.zeros((q, n))
        told[:, nb:out] = np.eye(q)
        before = wide[:n, n : n + k] - after
        return StraightSteps(np.ascontiguousarray(wide[:n, :n]), before, after, told, np.zeros((q, k)))

    def let_go(self, coordinates: FloatArray) -> FloatArray:
        nb, nc, p = len(self.body.a), len(self.control.a), len(coordinates)
        told: FloatArray = self.body.c[:, :p] @ coordinates
        return np.concatenate([coordinates, np.zeros(nb - p), told, np.zeros(nc)])


def sampled_time_loop(plant: Plant, controller: StateSpaceController, labels: Sequence[str]) -> SampledTimeLoop:
    """The loop of a sampled controller with the outputs `labels`."""
    assert controller.dt_s is not None
    outputs = output_map(plant)
    rows = [OUTPUTS.index(label) for label in labels]
    second = outputs.differentiated(rows)
    twice = [rows[k] for k in second]
    body = _body(plant, controller)
    n, q = len(body.a), len(rows) + len(twice)
    pick = np.zeros((N_COORDINATES, n))
    pick[:, :N_COORDINATES] = np.eye(N_COORDINATES)
    c, d = np.zeros((q, n)), np.zeros((q, _M + N_INPUTS))
    c[: len(rows)] = outputs.by_p[rows] @ pick + outputs.by_u[rows] @ body.c
    d[: len(rows), :_M], d[: len(rows), _M:] = outputs.by_d[rows], outputs.by_u[rows] @ body.d[:, _M:]
    c[len(rows) :], d[len(rows) :, :_M] = outputs.by_p2[twice] @ pick, outputs.by_d2[twice]
    return SampledTimeLoop(
        tuple(labels), second, StateSpace(body.a, body.b, c, d), controller.state_space(), controller.dt_s
    )


def _body(plant: Plant, controller: StateSpaceController) -> StateSpace:
    """Plant and delay, from `DISTURBANCES` [45] and commands u [18] to the late commands [18]; states p, p', delay."""
    late = delays(controller.delay_s, controller.outputs) if controller.delay_s else StateSpace.gain(np.eye(N_INPUTS))
    m = 2 * N_COORDINATES
    n = m + len(late.a)
    a, b = np.zeros((n, n)), np.zeros((n, _M + N_INPUTS))
    a[:N_COORDINATES, N_COORDINATES:m] = np.eye(N_COORDINATES)
    a[N_COORDINATES:m, :N_COORDINATES] = plant.K
    a[N_COORDINATES:m, m:], a[m:, m:] = plant.E @ late.c, late.a
    b[N_COORDINATES:m, :N_INPUTS] = plant.E
    b[N_COORDINATES:m, N_INPUTS + N_COORDINATES : _M] = plant.E @ plant.stray_wrench
    b[N_COORDINATES:m, _M:], b[m:, _M:] = plant.E @ late.d, late.b
    c, d = np.zeros((N_INPUTS, n)), np.zeros((N_INPUTS, _M + N_INPUTS))
    c[:, m:], d[:, _M:] = late.c, late.d
    return StateSpace(a, b, c, d)


def one_period(plant: Plant, controller: StateSpaceController) -> FloatArray:
    """States over one period of the closed loop: p, p', those of the delay, those of the controller [n, n]."""
    loop = sampled_time_loop(plant, controller, ())
    return loop.under_signals(np.zeros((_M, 1)), loop.dt_s).step
