"""Transfer functions of a linear thermal network, H(f) = (K + 2πi f C)⁻¹ B: one sparse factorisation per frequency."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy

from tedm_cli.arrays import ComplexArray, FloatArray, IndexArray
from tedm_cli.thermal.linear import LinearNetwork
from tedm_cli.thermal.solving import factorised, lost_in_rounding

_BALANCE = 1e-4  # relative, of the heat that boundaries take


def transfer(
    network: LinearNetwork,
    frequency_hz: FloatArray,
    outputs: IndexArray | None = None,
    advance: Callable[[int], None] = lambda done: None,
) -> ComplexArray:
    """H [F, o, u] from every disturbance to the nodes `outputs` [o], rows of the network; all of them by default.

    Time goes as exp(+2πi f t). Arithmetic nodes have no capacity and stay. The right-hand sides of each factorisation
    are the disturbances, or the outputs where these are fewer: rows of the inverse, by the transposed matrix.
    `advance` is told of each frequency.
    """
    n, u = network.disturbed.shape
    rows = np.arange(n) if outputs is None else outputs
    out = np.empty((len(frequency_hz), len(rows), u), dtype=np.complex128)
    adjoint = len(rows) < u
    right: ComplexArray = np.zeros((n, len(rows) if adjoint else u), dtype=np.complex128)
    if adjoint:
        right[rows, np.arange(len(rows))] = 1.0
    else:
        right[:] = network.disturbed
    diagonal = scipy.sparse.diags_array(network.capacity).tocsc()
    for number, f in enumerate(frequency_hz):
        lu = factorised(network.conductance + (2j * np.pi * f) * diagonal)
        out[number] = lu.solve(right, trans="T").T @ network.disturbed if adjoint else lu.solve(right)[rows]
        advance(1)
    return out


def static_gain(network: LinearNetwork, outputs: IndexArray | None = None) -> FloatArray:
    """H [o, u] for f → 0.

    Raises
    ------
    PhysicsError : the heat of a disturbance is not what the boundaries take, by 1e-4 of it: it is lost in rounding.
    """
    gain: FloatArray = factorised(network.conductance).solve(network.disturbed)
    taken, given = network.to_boundaries @ gain, network.disturbed.sum(axis=0)
    if not (np.abs(taken - given) <= _BALANCE * np.abs(network.disturbed).sum(axis=0)).all():
        raise lost_in_rounding()
    return gain if outputs is None else gain[outputs]
