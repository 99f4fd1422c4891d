"""Stability of the closed loop: its poles, and the margins of each loop with the others closed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy

from tedm_cli.arrays import ComplexArray, FloatArray
from tedm_cli.dynamics.closed_loop import loop_transfer
from tedm_cli.dynamics.controller import Controller
from tedm_cli.dynamics.own_controller import StateSpaceController
from tedm_cli.dynamics.plant import Plant
from tedm_cli.dynamics.sampled_loop import one_period
from tedm_cli.dynamics.signals import COORDINATES, N_COORDINATES
from tedm_cli.dynamics.state_space import loop_system
from tedm_cli.errors import PhysicsError

_BAND_HZ = (1e-7, 10.0)  # in which margins are looked for
_PER_DECADE = 100
_NEUTRAL = 1e-9  # rad/s: poles that lie this close to the axis for all their rounding are not called stable


@dataclass(frozen=True)
class Margins:
    """Margins of one loop, the others closed; infinite where nothing is crossed.

    Parameters
    ----------
    phase_deg : smallest at a crossover of gain 1; gain_db : how much more gain is borne, reduction_db : how much less
        (negative), infinite where any is; peak_sensitivity : largest |1 / (1 + L)|; crossover_hz : highest.
    """

    loop: str
    phase_deg: float
    gain_db: float
    reduction_db: float
    peak_sensitivity: float
    crossover_hz: float


@dataclass(frozen=True, eq=False)
class Stability:
    """Poles [n] of the closed loop in rad/s (of a sampled controller: log z / dt), and the margins of every loop."""

    poles: ComplexArray
    margins: tuple[Margins, ...]

    @property
    def largest_real_part(self) -> float:
        """Of the poles, rad/s; negative: stable."""
        return float(self.poles.real.max())


def stability(plant: Plant, controller: Controller) -> Stability:
    """Poles and margins.

    Raises
    ------
    PhysicsError : a pole is not in the left half plane; it is named with the coordinate that it moves most.
    """
    poles, vectors = _modes(plant, controller)
    worst = int(poles.real.argmax())
    if poles[worst].real > -_NEUTRAL:
        shape = np.abs(vectors[:N_COORDINATES, worst])
        name = COORDINATES[int(shape.argmax())]
        pole = poles[worst]
        raise PhysicsError(
            f"the closed loop is unstable: a pole at {pole.real:.3g} {abs(pole.imag):+.3g}i rad/s moves {name} most",
            hint=f"change the gain or the delay of the loop that holds {name}, or the stiffness it works against",
        )
    return Stability(poles, tuple(_margins(plant, controller)))


def _modes(plant: Plant, controller: Controller) -> tuple[ComplexArray, ComplexArray]:
    """Poles (rad/s) and modes, the coordinates first."""
    if isinstance(controller, StateSpaceController) and controller.dt_s is not None:
        z, vectors = np.linalg.eig(one_period(plant, controller))
        z = np.where(z == 0.0, 1e-300, z)
        return np.log(z) / controller.dt_s, vectors
    poles, vectors = scipy.linalg.eig(loop_system(plant, controller).system.a)
    return poles, vectors


def _margins(plant: Plant, controller: Controller) -> list[Margins]:
    top = _BAND_HZ[1]
    if isinstance(controller, StateSpaceController) and controller.dt_s is not None:
        top = min(top, 0.5 / controller.dt_s)
    points = int(_PER_DECADE * np.log10(top / _BAND_HZ[0]))
    f = np.geomspace(_BAND_HZ[0], top, points)
    transfer = np.concatenate([loop_transfer(plant, controller, part) for part in np.array_split(f, 16)])
    return [_margins_of(plant, controller, j, name, f, transfer[:, j]) for j, name in enumerate(controller.loops)]


def _margins_of(
    plant: Plant, controller: Controller, j: int, name: str, f: FloatArray, transfer: ComplexArray
) -> Margins:
    def open_loop(x: float) -> complex:
        t = complex(loop_transfer(plant, controller, np.array([np.exp(x)]))[0, j])
        return t / (1.0 - t)

    x, values = np.log(f), transfer / (1.0 - transfer)
    gain = _crossings(x, np.log(np.abs(values)), lambda v: float(np.log(abs(open_loop(v)))))
    # a phase of ±180° is where the loop is real and negative
    real = _crossings(x, values.imag, lambda v: open_loop(v).imag)
    phase = [v for v in real if open_loop(v).real < 0.0]
    at_phase = np.array([abs(open_loop(v)) for v in phase])
    more, less = at_phase[at_phase < 1.0], at_phase[at_phase > 1.0]
    angles = [abs(np.angle(-open_loop(v), deg=True)) for v in gain]
    sensitivity = np.abs(1.0 - transfer)
    top = int(sensitivity.argmax())
    low, high = x[max(top - 1, 0)], x[min(top + 1, len(x) - 1)]
    best = scipy.optimize.minimize_scalar(
        lambda v: -1.0 / abs(1.0 + open_loop(v)), bounds=(low, high), method="bounded"
    )
    return Margins(
        loop=name,
        phase_deg=float(min(angles, default=np.inf)),
        gain_db=float(-20.0 * np.log10(more.max())) if len(more) else np.inf,
        reduction_db=float(-20.0 * np.log10(less.min())) if len(less) else -np.inf,
        peak_sensitivity=float(max(-best.fun, sensitivity[top])),
        crossover_hz=float(np.exp(max(gain))) if gain else np.nan,
    )


def _crossings(x: FloatArray, values: FloatArray, function: Callable[[float], float]) -> list[float]:
    """Zeros of `function` between points [n] of a grid where its `values` change sign."""
    found = []
    for i in np.flatnonzero(np.signbit(values[:-1]) != np.signbit(values[1:])):
        low, high = function(x[i]), function(x[i + 1])
        if np.signbit(low) != np.signbit(high):
            found.append(float(scipy.optimize.brentq(function, x[i], x[i + 1], xtol=1e-12)))
        else:  # one of them is 0 but for rounding, as half the rate of a sampled controller is
            found.append(float(x[i] if abs(low) < abs(high) else x[i + 1]))
    return found
