"""The closed loop as one linear system in time, with named inputs and outputs.

States are p, p' and those of the controller with its delays. Δg holds the second derivative of the read-outs, so the
noise of the two read-outs of x comes a second time, as its second derivative (`nddot_TM1_x`, `nddot_TM2_x`): with both,
the response to read-out noise is that of single frequencies.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import ComplexArray, FloatArray
from tedm_cli.dynamics.closed_loop import output_map
from tedm_cli.dynamics.controller import Controller
from tedm_cli.dynamics.loops import StateSpace
from tedm_cli.dynamics.plant import Plant
from tedm_cli.dynamics.signals import COORDINATES, DISTURBANCES, N_COORDINATES, N_INPUTS, unit

SECOND_DERIVATIVES = ("nddot_TM1_x", "nddot_TM2_x")
SYSTEM_INPUTS = (*DISTURBANCES, *SECOND_DERIVATIVES)
SYSTEM_INPUT_UNITS = (*(unit(name) for name in DISTURBANCES), *("m s^-2" for _ in SECOND_DERIVATIVES))
_P, _V = slice(0, N_COORDINATES), slice(N_COORDINATES, 2 * N_COORDINATES)
_NOISE = slice(N_INPUTS, N_INPUTS + N_COORDINATES)


@dataclass(frozen=True, eq=False)
class LoopSystem:
    """x' = A x + B d, outputs = C x + D d: inputs `SYSTEM_INPUTS`, outputs `signals.OUTPUTS`, SI units."""

    system: StateSpace

    @property
    def states(self) -> tuple[list[str], list[str]]:
        """Names and units of the states: p, `d_` its rates, `control_` those of the controller and its delays."""
        control = len(self.system.a) - 2 * N_COORDINATES
        names = [*COORDINATES, *(f"d_{n}" for n in COORDINATES), *(f"control_{i + 1}" for i in range(control))]
        units = [unit(n) for n in COORDINATES]
        return names, [*units, *map("{}/s".format, units), *(["1"] * control)]

    def response(self, s: ComplexArray) -> ComplexArray:
        """[F, 75, 45] by `DISTURBANCES`, second derivatives put back."""
        whole = self.system.response(s)
        out: ComplexArray = whole[:, :, : len(DISTURBANCES)].copy()
        for n, name in enumerate(SECOND_DERIVATIVES):
            source = DISTURBANCES.index(name.replace("nddot_", "n_"))
            out[:, :, source] += (s * s)[:, None] * whole[:, :, len(DISTURBANCES) + n]
        return out


def loop_system(plant: Plant, controller: Controller | None) -> LoopSystem:
    """The closed loop of a continuous controller; without one, the plant alone."""
    control = StateSpace.gain(np.zeros((N_INPUTS, N_COORDINATES))) if controller is None else controller.state_space()
    n, m = 2 * N_COORDINATES + len(control.a), len(SYSTEM_INPUTS)
    own = slice(2 * N_COORDINATES, n)
    wrench = np.zeros((N_INPUTS, m))  # from outside, and of disturbing accelerations
    wrench[:, :N_INPUTS] = np.eye(N_INPUTS)
    wrench[:, N_INPUTS + N_COORDINATES : len(DISTURBANCES)] = plant.stray_wrench
    noise = np.zeros((N_COORDINATES, m))
    noise[:, _NOISE] = np.eye(N_COORDINATES)
    command_x, command_d = np.zeros((N_INPUTS, n)), -control.d @ noise
    command_x[:, _P], command_x[:, own] = -control.d, -control.c
    a, b = np.zeros((n, n)), np.zeros((n, m))
    a[_P, _V] = np.eye(N_COORDINATES)
    a[_V] = plant.E @ command_x
    a[_V, _P] += plant.K
    b[_V] = plant.E @ (wrench + command_d)
    a[own, _P], a[own, own], b[own] = control.b, control.a, control.b @ noise
    outputs = output_map(plant)
    c: FloatArray = outputs.by_p2 @ a[_V] + outputs.by_u @ command_x
    c[:, _P] += outputs.by_p
    second = [DISTURBANCES.index(name.replace("nddot_", "n_")) for name in SECOND_DERIVATIVES]
    direct = np.concatenate([outputs.by_d, outputs.by_d2[:, second]], axis=1)
    d = np.asarray(outputs.by_p2 @ b[_V] + outputs.by_u @ command_d + direct)
    return LoopSystem(StateSpace(a, b, c, d))
