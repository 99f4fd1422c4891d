"""The self-gravity operator: coefficients of every nodal displacement in the accelerations of the test masses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tedm_cli.gravity.constants import G_CODATA_2018
from tedm_cli.gravity.field import massive_blocks
from tedm_cli.gravity.kernel import cuboid_field
from tedm_cli.gravity.testmass import TestMass

Array = NDArray[np.float64]


def lumped_operator(
    points: ArrayLike,
    masses: ArrayLike,
    test_masses: Sequence[TestMass],
    *,
    G: float = G_CODATA_2018,
    node_ids: Sequence[int] | NDArray[np.int64] | None = None,
) -> Array:
    """Operator of lumped nodal masses (Montemurro 2004, chapter 8): ``S[r, k] = -Σ_nc G[r, n, c] D[k, n, c]``.

    The change of acceleration by source displacements ``dr_s`` is ``-Σ_s Γ_lin,s dr_s / M``, that of the angular
    acceleration ``-Σ_s I⁻¹ Ω_lin,s dr_s``. The operator depends on geometry and mass alone.

    Parameters
    ----------
    points : [n, 3], nodes in the basic frame [m].
    masses : [n], lumped masses [kg]; massless nodes get zeros wherever they are.
    test_masses : t test masses.
    G : gravitational constant [m³ kg⁻¹ s⁻²].
    node_ids : [n], names of the nodes in error messages (their indices by default).

    Returns
    -------
    [6 t, n, 3]: rows are the accelerations of all test masses (1/s²), then their angular accelerations (1/(m s²)), each
    in the frame of its test mass, in the order of `sensitivity_row_labels`; the last axis is the displacement of the
    node in the basic frame.

    Raises
    ------
    PhysicsError
        If a node with mass is not finite, or inside or on a test mass; names the node and the test mass.
    """
    points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    count = len(test_masses)
    operator = np.zeros((2, count, 3, points.shape[0], 3))
    for row, test_mass in enumerate(test_masses):
        gyration = test_mass.inertia_kg_m2 / test_mass.mass_kg
        for index, position, mass in massive_blocks(points, masses, test_mass, node_ids):
            field = cuboid_field(position, test_mass.side_m)
            weight = (G * mass)[:, None, None]
            linear = weight * field.gamma_lin @ test_mass.axes
            angular = weight * field.omega_lin / gyration[:, None] @ test_mass.axes
            operator[0, row][:, index] = linear.swapaxes(0, 1)
            operator[1, row][:, index] = angular.swapaxes(0, 1)
    return operator.reshape(6 * count, points.shape[0], 3)


def contract(operator: Array, displacement: Array) -> Array:
    """Sensitivity of the accelerations to the load cases, ``S = -G D``.

    Nodes may be passed block by block and the results added.

    Parameters
    ----------
    operator : [rows, n, 3], from `lumped_operator`.
    displacement : [k, n, 3], nodal displacements per kelvin in the basic frame [m/K].

    Returns
    -------
    [rows, k], in the units of `sensitivity_row_units`.
    """
    if operator.shape[1:] != displacement.shape[1:]:
        raise ValueError(f"operator of shape {operator.shape} does not match displacements {displacement.shape}")
    rows, cases = operator.shape[0], displacement.shape[0]
    return np.asarray(-(operator.reshape(rows, -1) @ displacement.reshape(cases, -1).T))


def sensitivity_row_labels(test_masses: Sequence[TestMass]) -> list[str]:
    """Names of the operator's rows: ``<name>_a_x`` ... of all test masses, then ``<name>_omegadot_x`` ..."""
    return [f"{tm.name}_{quantity}_{axis}" for quantity in ("a", "omegadot") for tm in test_masses for axis in "xyz"]


def sensitivity_row_units(test_masses: Sequence[TestMass]) -> list[str]:
    """Units of the sensitivities by row, in the order of `sensitivity_row_labels`."""
    return [unit for unit in ("m/s^2/K", "rad/s^2/K") for _ in range(3 * len(test_masses))]
