"""Sensitivity of the accelerations: contraction of the self-gravity operator with displacements, and its rows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tedm_cli.gravity.testmass import TestMass

Array = NDArray[np.float64]


def contract(operator: Array, displacement: Array) -> Array:
    """Sensitivity of the accelerations to the load cases, ``S = -G D``.

    Nodes may be passed block by block and the results added.

    Parameters
    ----------
    operator : [rows, n, 3], from `tedm_cli.gravity.structure`.
    displacement : [k, n, 3], nodal displacements per kelvin in the basic frame [m/K].

    Returns
    -------
    [rows, k], in the units of `sensitivity_row_units`.
    """
    if operator.shape[1:] != displacement.shape[1:]:
        raise ValueError(f"operator of shape {operator.shape} does not match displacements {displacement.shape}")
    (rows, nodes, _), cases = operator.shape, displacement.shape[0]
    return np.asarray(-(operator.reshape(rows, 3 * nodes) @ displacement.reshape(cases, 3 * nodes).T))


def sensitivity_row_labels(test_masses: Sequence[TestMass]) -> list[str]:
    """Names of the operator's rows: ``<name>_a_x`` ... of all test masses, then ``<name>_omegadot_x`` ..."""
    return [f"{tm.name}_{quantity}_{axis}" for quantity in ("a", "omegadot") for tm in test_masses for axis in "xyz"]


def sensitivity_row_units(test_masses: Sequence[TestMass]) -> list[str]:
    """Units of the sensitivities by row, in the order of `sensitivity_row_labels`."""
    return [unit for unit in ("m/s^2/K", "rad/s^2/K") for _ in range(3 * len(test_masses))]
