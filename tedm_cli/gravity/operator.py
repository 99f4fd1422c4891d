"""Sensitivity of the accelerations: contraction of the self-gravity operator with displacements, and its rows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tedm_cli.arrays import FloatArray
from tedm_cli.gravity.testmass import TestMass

_NODES = 512  # of some ten cases: what is multiplied together stays in a processor's cache


def contract(operator: FloatArray, displacement: FloatArray | NDArray[np.float32]) -> FloatArray:
    """Sensitivity of the accelerations to the load cases, ``S = -G D``.

    Nodes may be passed block by block and the results added.

    Parameters
    ----------
    operator : [rows, n, 3], from `tedm_cli.gravity.structure`.
    displacement : [k, n, 3], nodal displacements per kelvin in the basic frame [m/K]; summed in double precision
        whatever they come in.

    Returns
    -------
    [rows, k], in the units of `sensitivity_row_units`.
    """
    if operator.shape[1:] != displacement.shape[1:]:
        raise ValueError(f"operator of shape {operator.shape} does not match displacements {displacement.shape}")
    rows, cases = operator.shape[0], displacement.shape[0]
    total = np.zeros((rows, cases))
    for start in range(0, operator.shape[1], _NODES):
        part = slice(start, start + _NODES)
        move = displacement[:, part].astype(np.float64)
        total -= operator[:, part].reshape(rows, -1) @ move.reshape(cases, -1).T
    return total


def sensitivity_row_labels(test_masses: Sequence[TestMass]) -> list[str]:
    """Names of the operator's rows: ``<name>_a_x`` ... of all test masses, then ``<name>_omegadot_x`` ..."""
    return [f"{tm.name}_{quantity}_{axis}" for quantity in ("a", "omegadot") for tm in test_masses for axis in "xyz"]


def sensitivity_row_units(test_masses: Sequence[TestMass]) -> list[str]:
    """Units of the sensitivities by row, in the order of `sensitivity_row_labels`."""
    return [unit for unit in ("m/s^2/K", "rad/s^2/K") for _ in range(3 * len(test_masses))]
