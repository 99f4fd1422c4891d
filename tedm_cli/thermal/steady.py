"""The steady state of a thermal network, by Newton's method."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IndexArray
from tedm_cli.errors import InputError, PhysicsError
from tedm_cli.thermal.network import ThermalNetwork, selected
from tedm_cli.thermal.solving import factorised

_MOST = 100  # iterations
_STEP = 1e-12  # relative change of the temperatures at which they are found
_NEAR = 1e-6  # or this one, where all heat is in balance but for rounding
_ROUNDING = 64.0 * np.finfo(np.float64).eps  # of the heat at a node, relative to what is summed there
_SMALLEST = 2.0**-20  # of a step that is damped
_WARM_K = 300.0


@dataclass(frozen=True, eq=False)
class SteadyState:
    """Temperatures at which heat is in balance.

    Parameters
    ----------
    temperature_K : [n]. net_heat : [n], W; of a free node that was solved for rounding, of a boundary what it takes up.
    solved : [n]: found here; the others were given. iterations : of Newton's method; 0 where nothing was to find.
    imbalance : largest net heat of the nodes solved for over the sum of all powers and heats at boundaries, by size.
    """

    temperature_K: FloatArray
    net_heat: FloatArray
    solved: BoolArray
    iterations: int
    imbalance: float


def steady_state(network: ThermalNetwork, given_K: FloatArray, start_K: FloatArray, *, where: str) -> SteadyState:
    """The temperatures that are not given, such that the heat of each of their nodes is in balance.

    Newton's method from `start_K` where it is a number, else from the warmest of the temperatures that are given and
    300 K: from above, where radiation is steep. A step that does not make the imbalance smaller is halved. It ends when
    no temperature changes by more than 1e-12 of itself, or by 1e-6 where the imbalance is rounding: the next step would
    be as small as the square of this one.

    Parameters
    ----------
    given_K : [n], NaN where the temperature is to be found; of boundaries always a number.
    start_K : [n], NaN where there is no better beginning.

    Raises
    ------
    InputError : a boundary without a temperature.
    PhysicsError : no steady state is found; names the node that is furthest from one.
    """
    wanted = np.isnan(given_K)
    if (lost := np.flatnonzero(wanted & network.boundary)).size:
        raise InputError(
            f"boundary {network.name[lost[0]]} has no temperature",
            where=where,
            hint="a boundary's temperature is given, not solved for",
        )
    temperature = given_K.copy()
    unknown = np.flatnonzero(wanted)
    start = start_K[unknown]
    warm = max(_WARM_K, float(np.max(given_K[~wanted], initial=0.0)))
    temperature[unknown] = np.where(start > 0.0, start, warm)
    iterations = 0
    net = network.net_heat(temperature)
    if unknown.size:
        temperature, net, iterations = _newton(network, temperature, unknown, where)
    scale = float(abs(network.power).sum() + abs(net[network.boundary]).sum())
    worst = float(np.max(abs(net[unknown]), initial=0.0))
    return SteadyState(temperature, net, wanted, iterations, worst / scale if scale > 0.0 else worst)


def _newton(
    network: ThermalNetwork, temperature: FloatArray, unknown: IndexArray, where: str
) -> tuple[FloatArray, FloatArray, int]:
    net = network.net_heat(temperature)
    for number in range(1, _MOST + 1):
        step = factorised(selected(network.conductance(temperature), unknown, unknown)).solve(net[unknown])
        if not np.isfinite(step).all():
            break
        here = temperature[unknown]
        # A temperature is above 0 K: no step takes more than nine tenths of it.
        length = min(1.0, float(np.min(np.where(step < 0.0, 0.9 * here / np.maximum(-step, 1e-300), 1.0))))
        before = np.linalg.norm(net[unknown])
        while True:
            temperature[unknown] = here + length * step
            net = network.net_heat(temperature)
            balanced = abs(net[unknown]) <= _ROUNDING * network.gross_heat(temperature)[unknown]
            if balanced.all() or np.linalg.norm(net[unknown]) < before or length < _SMALLEST:
                break
            length /= 2.0
        change = float(np.max(np.abs(step) / here))
        if length == 1.0 and change <= (_NEAR if balanced.all() else _STEP):
            return temperature, net, number
        if length < _SMALLEST and not balanced.all():
            break
    gross = network.gross_heat(temperature)[unknown]
    off = np.abs(net[unknown]) / np.maximum(gross, 1e-300)
    worst = int(np.argmax(off))
    node = network.name[unknown[worst]]
    raise PhysicsError(
        f"no steady state after {number} steps of Newton's method: the heat of node {node} is out of balance by"
        f" {net[unknown][worst]:.3g} W at {temperature[unknown][worst]:.4g} K",
        where=where,
        hint="there is none where more power is taken from nodes than can reach them; look at the powers and at the"
        f" conductors of {node}",
    )
