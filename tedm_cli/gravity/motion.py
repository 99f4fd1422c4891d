"""Linearised equations of motion of all test masses under self-gravity (Montemurro 2004, section 6.2, corrected)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.gravity.field import SelfGravity
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.inertia import divided_by_inertia


def linearised_motion(
    test_masses: Sequence[TestMass],
    fixed: Sequence[SelfGravity],
    mutual: Mapping[tuple[int, int], SelfGravity],
) -> FloatArray:
    """Stiffness of all test masses together: ``(F1/M, I⁻¹ T1, F2/M, ...) = DC + K (dr1, dα1, dr2, ...)``.

    For test mass i moved by dr_i, dα_i among fixed sources ``F = Γ_lin dr_i + Γ_ang dα_i``, ``T = Ω_lin dr_i + Ω_ang
    dα_i`` (section 6.1). Test mass j, whose sources are at r = r_ij + r', moves them by ``dr_j + dα_j × r'``:

        F_i = Γ_lin (dr_i - dr_j) + Γ_ang (dα_i - dα_j) - ([F]x + Γ_lin [r_ij]x) dα_j
        T_i = Ω_lin (dr_i - dr_j) + Ω_ang (dα_i - dα_j) - ([T]x + Ω_lin [r_ij]x) dα_j

    with the field of j on i. For two equal, aligned cubes the first bracket is -2 Γ_ang and T vanishes: eq. 6.18,
    ``F_i = Γ_lin (dr_i - dr_j) + Γ_ang (dα_i + dα_j)``, and eq. 6.21, signs corrected.

    Parameters
    ----------
    test_masses : t test masses.
    fixed : field of everything that moves with the satellite (structure, compensation masses) on each test mass.
    mutual : field on test mass i of test mass j, for every pair of different indices (i, j).

    Returns
    -------
    [6 t, 6 t]: rows and columns by test mass, each in its nominal frame, in the order of `motion_labels`. Translations
    are in m, rotations (right-handed, small) in rad, rows in m/s² and rad/s².
    """
    count = len(test_masses)
    stiffness = np.zeros((count, 6, count, 6))
    for i, tm in enumerate(test_masses):
        own = fixed[i]
        for j, other in enumerate(test_masses):
            if j != i:
                field = mutual[i, j]
                own = own + field
                # columns are the motion of j, in its own frame
                turn = tm.axes @ other.axes.T
                stiffness[i, :, j] = -by_motion_of_source(tm, other.position_m, field) @ np.kron(np.eye(2), turn)
        stiffness[i, :, i] = np.block([[own.gamma_lin, own.gamma_ang], [own.omega_lin, own.omega_ang]])
    return stiffness.reshape(6 * count, 6 * count)


def motion_labels(test_masses: Sequence[TestMass]) -> tuple[list[str], list[str]]:
    """Names of the rows (`TM1_a_x` ..., `TM1_omegadot_x` ...) and columns (`TM1_x` ..., `TM1_theta` ...)."""
    rows = [f"{tm.name}_{quantity}_{axis}" for tm in test_masses for quantity in ("a", "omegadot") for axis in "xyz"]
    columns = [f"{tm.name}_{motion}" for tm in test_masses for motion in ("x", "y", "z", "theta", "eta", "phi")]
    return rows, columns


def by_motion_of_source(tm: TestMass, place_m: FloatArray, field: SelfGravity) -> FloatArray:
    """Minus the change of `field` on `tm` by translation and rotation of its rigid source, [6, 6], frame of `tm`.

    The source turns about `place_m` [3], basic frame, m.
    """
    separation = cross_matrix(tm.axes @ (place_m - tm.position_m))
    inertia = tm.inertia_kg_m2
    torque = divided_by_inertia(inertia, cross_matrix(inertia @ field.angular_acceleration), 0)
    force_turn = field.gamma_ang + cross_matrix(field.acceleration) + field.gamma_lin @ separation
    torque_turn = field.omega_ang + torque + field.omega_lin @ separation
    return np.block([[field.gamma_lin, force_turn], [field.omega_lin, torque_turn]])


def cross_matrix(vector: FloatArray) -> FloatArray:
    """``[v]x`` with ``[v]x w = v × w``."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
