"""The closed loop at single frequencies: every output by every disturbance, exact for the linear model.

    (-ω² - K + E K_c) p = E (w + J s) - E K_c n,   y = p + n,   u = -K_c y

with w the forces and torques, s the disturbing accelerations and n the noise of the read-outs (e^{+iωt}).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import ComplexArray, FloatArray
from tedm_cli.dynamics.controller import Controller
from tedm_cli.dynamics.plant import Plant
from tedm_cli.dynamics.signals import COORDINATES, DISTURBANCES, INPUTS, N_COORDINATES, N_INPUTS, OUTPUTS, STRAY
from tedm_cli.errors import InputError

_BLOCK = 32  # frequencies at once: their matrices stay in the cache
_W, _N = slice(0, N_INPUTS), slice(N_INPUTS, N_INPUTS + N_COORDINATES)
_S = slice(N_INPUTS + N_COORDINATES, len(DISTURBANCES))
_X1, _X2 = COORDINATES.index("TM1_x"), COORDINATES.index("TM2_x")
_F1, _F2 = INPUTS.index("TM1_Fx"), INPUTS.index("TM2_Fx")


@dataclass(frozen=True, eq=False)
class OutputMap:
    """Outputs as sums over coordinates, their second derivatives, commands and disturbances.

    outputs = (by_p + s² by_p2) p + (by_u) u + (by_d + s² by_d2) d, d the `DISTURBANCES`; matrices [75, ...].
    """

    by_p: FloatArray
    by_p2: FloatArray
    by_u: FloatArray
    by_d: FloatArray
    by_d2: FloatArray

    def differentiated(self, rows: Sequence[int]) -> tuple[int, ...]:
        """Places among the `rows` of outputs with second derivatives of coordinates or read-outs."""
        return tuple(k for k, row in enumerate(rows) if self.by_p2[row].any() or self.by_d2[row].any())


def output_map(plant: Plant) -> OutputMap:
    """The 75 outputs of `signals.OUTPUTS`.

    With o1 = y_x1, o12 = y_x2 - y_x1, the commanded g_c = u_F2x/m_2 - u_F1x/m_1, and κ the row of x on test mass 2 less
    that on test mass 1 of the total stiffness:

        delta_g = o12'' - g_c - κ_x2 (o12 + o1) - κ_x1 o1;   delta_g_full = o12'' - g_c - κ y
        delta_g_true = s_x2 - s_x1, with the noise of the forces on the test masses
    """
    by_p, by_p2 = np.zeros((len(OUTPUTS), N_COORDINATES)), np.zeros((len(OUTPUTS), N_COORDINATES))
    by_u = np.zeros((len(OUTPUTS), N_INPUTS))
    by_d, by_d2 = np.zeros((len(OUTPUTS), len(DISTURBANCES))), np.zeros((len(OUTPUTS), len(DISTURBANCES)))
    by_p[:15] = by_p[15:30] = np.eye(15)
    by_d[15:30, _N] = np.eye(15)
    by_u[30:48] = np.eye(18)
    bodies = np.concatenate([plant.spacecraft_response, np.zeros((12, N_INPUTS))])
    bodies[6:, 6:] = plant.inverse_mass
    housing = (plant.housing @ plant.spacecraft_response).reshape(2, 2, 3, N_INPUTS)[:, 0].reshape(6, N_INPUTS)
    forced = np.concatenate([bodies, housing])  # [24, 18], by all forces: commanded, from outside, of the stiffness
    by_u[48:72] = by_d[48:72, _W] = forced
    by_d[48:72, _S] = forced @ plant.stray_wrench
    by_p[48:72] = forced @ plant.stiffness_wrench
    by_p[54:66, 3:] += plant.mutual
    masses = [plant.test_masses[i].mass_kg for i in (0, 1)]
    kappa = np.zeros(N_COORDINATES)
    kappa[3:] = plant.total_stiffness[6] - plant.total_stiffness[0]
    measured_x = np.zeros(N_COORDINATES)
    measured_x[[_X1, _X2]] = kappa[[_X1, _X2]]
    for row, compensated in ((72, measured_x), (73, kappa)):
        by_p[row], by_d[row, _N] = -compensated, -compensated
        by_p2[row, [_X1, _X2]] = by_d2[row, [N_INPUTS + _X1, N_INPUTS + _X2]] = -1.0, 1.0
        by_u[row, [_F1, _F2]] = 1.0 / masses[0], -1.0 / masses[1]
    stray = N_INPUTS + N_COORDINATES
    by_d[74, [stray + STRAY.index("TM1_a_x"), stray + STRAY.index("TM2_a_x")]] = -1.0, 1.0
    by_d[74, [_F1, _F2]] = -1.0 / masses[0], 1.0 / masses[1]
    return OutputMap(by_p, by_p2, by_u, by_d, by_d2)


def responses(
    plant: Plant, controller: Controller | None, frequency_hz: FloatArray, difference_s: float | None = None
) -> Iterator[tuple[slice, ComplexArray]]:
    """Blocks of frequencies and H [f, 75, 45]: `OUTPUTS` by `DISTURBANCES`, SI units.

    `controller` None: the open loop, which may well be unstable; its response is that of the equations.
    `difference_s`: second derivatives of read-outs are second differences of samples this far apart.

    Raises
    ------
    InputError : a frequency that is not above 0.
    """
    if not (np.isfinite(frequency_hz).all() and (frequency_hz > 0.0).all()):
        raise InputError("frequencies of the dynamics must be above 0", hint="at 0 Hz the equations are singular")
    outputs = output_map(plant)
    for first in range(0, len(frequency_hz), _BLOCK):
        here = slice(first, min(first + _BLOCK, len(frequency_hz)))
        s = 2j * np.pi * frequency_hz[here]
        second = s * s if difference_s is None else (2.0 * np.cosh(s * difference_s) - 2.0) / difference_s**2
        yield here, _response(plant, controller, outputs, s, second)


def _response(
    plant: Plant, controller: Controller | None, outputs: OutputMap, s: ComplexArray, second: ComplexArray
) -> ComplexArray:
    square = (s * s)[:, None, None]
    control = _control(controller, s)
    matrix = square * np.eye(N_COORDINATES) - plant.K + plant.E @ control
    driving = np.empty((len(s), N_COORDINATES, len(DISTURBANCES)), dtype=np.complex128)
    driving[:, :, _W] = plant.E
    driving[:, :, _N] = -plant.E @ control
    driving[:, :, _S] = plant.E @ plant.stray_wrench
    p = np.linalg.solve(matrix, driving)
    measured = p.copy()
    measured[:, range(N_COORDINATES), range(N_INPUTS, N_INPUTS + N_COORDINATES)] += 1.0
    out: ComplexArray = outputs.by_p @ p
    out -= outputs.by_u @ (control @ measured)
    out += outputs.by_d
    twice = list(outputs.differentiated(range(len(OUTPUTS))))
    out[:, twice] += second[:, None, None] * (outputs.by_p2[twice] @ p + outputs.by_d2[twice])
    return out


def _control(controller: Controller | None, s: ComplexArray) -> ComplexArray:
    """K_c [F, 18, 15]: minus u by the read-outs."""
    if controller is None:
        return np.zeros((len(s), N_INPUTS, N_COORDINATES), dtype=np.complex128)
    out: ComplexArray = controller.command(s) @ controller.returns
    return out


def loop_transfer(plant: Plant, controller: Controller, frequency_hz: FloatArray) -> ComplexArray:
    """T_j [F, L]: complementary sensitivity of every loop, all others closed; its open loop is T / (1 - T)."""
    s = 2j * np.pi * frequency_hz
    command, returns = controller.command(s), controller.returns
    square = (s * s)[:, None, None]
    matrix = square * np.eye(N_COORDINATES) - plant.K + plant.E @ (command @ returns)
    out: ComplexArray = np.einsum("lp,fpl->fl", returns, np.linalg.solve(matrix, plant.E @ command))
    return out
