"""The equations of motion of spacecraft and test masses, linear about rest (Montemurro 2004, chapter 2, corrected).

With h_i from the spacecraft's centre of mass to test mass i, C_i its axes, F, L the force and torque on the spacecraft
from outside and F_i, L_i what the spacecraft exerts on test mass i (its axes), which acts back on the spacecraft:

    a_B = (F - Σ C_i F_i) / m_B,     ω' = I_B⁻¹ (L - Σ [h_i]x C_i F_i - Σ C_i L_i)
    r_i'' = F_i / m_i - C_iᵀ a_B + C_iᵀ [h_i]x ω' + mutual,     α_i'' = I_i⁻¹ L_i - C_iᵀ ω' + mutual

F_i, L_i contain J K_fix (r_i, α_i). Left out, since they are far below the noise of any mission: the force at rest
times its lever in ω' (below 1e-18 rad/s² at 5 nm), the Sun's force times the attitude, and the rotation rate of the
spacecraft.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray
from tedm_cli.dynamics.bodies import DynamicTestMass, Spacecraft, cross_matrix, x_axes_are_parallel
from tedm_cli.dynamics.signals import (
    DELTA_G,
    N_COORDINATES,
    N_INPUTS,
    N_STRAY,
    OUTPUTS,
    motion_of,
    wrench_on,
)


@dataclass(frozen=True, eq=False)
class Plant:
    """Spacecraft, two test masses and the stiffness between them.

    Parameters
    ----------
    spacecraft, test_masses : the bodies.
    fixed : K_fix [2, 6, 6], force per mass and torque per moment of inertia by displacement (m) and rotation (rad) of
        each test mass among all that moves with the spacecraft; positive is destabilising.
    mutual : [12, 12], the mutual gravity of the test masses alone; rows and columns test mass by test mass.
    """

    spacecraft: Spacecraft
    test_masses: Sequence[DynamicTestMass]
    fixed: FloatArray
    mutual: FloatArray

    @cached_property
    def axes(self) -> FloatArray:
        """[2, 3, 3], of both test masses (rows), basic frame."""
        return np.stack([tm.axes for tm in self.test_masses])

    @cached_property
    def outputs(self) -> tuple[str, ...]:
        """The outputs of the loop; without Δg where the x axes of the test masses are not parallel."""
        along = x_axes_are_parallel(self.axes)
        return tuple(name for name in OUTPUTS if along or name not in DELTA_G)

    @cached_property
    def lever_m(self) -> FloatArray:
        """h_i [2, 3], from the spacecraft's centre of mass to the test masses, basic frame."""
        return np.stack([tm.position_m - self.spacecraft.centre_of_mass_m for tm in self.test_masses])

    @cached_property
    def spacecraft_response(self) -> FloatArray:
        """[6, 18]: a_B and ω' by w, basic frame, with the reactions of the test masses."""
        sc = self.spacecraft
        force, torque = np.zeros((3, N_INPUTS)), np.zeros((3, N_INPUTS))
        force[:, 0:3], torque[:, 3:6] = np.eye(3), np.eye(3)
        for i, (tm, h) in enumerate(zip(self.test_masses, self.lever_m, strict=True)):
            at = wrench_on(i).start
            c = tm.to_basic
            force[:, at : at + 3] = -c
            torque[:, at : at + 3] = -cross_matrix(h) @ c
            torque[:, at + 3 : at + 6] = -c
        return np.concatenate([force / sc.mass_kg, np.linalg.solve(sc.inertia_kg_m2, torque)])

    @cached_property
    def housing(self) -> FloatArray:
        """[12, 6]: acceleration and angular acceleration of each housing, in its frame, by a_B and ω'."""
        rows = []
        for tm, h in zip(self.test_masses, self.lever_m, strict=True):
            c = tm.to_basic
            rows.append(np.block([[c.T, -c.T @ cross_matrix(h)], [np.zeros((3, 3)), c.T]]))
        return np.concatenate(rows)

    @cached_property
    def generalised_mass(self) -> FloatArray:
        """J [12, 12]: masses and inertias of both test masses."""
        return np.asarray(scipy.linalg.block_diag(*(tm.generalised_mass for tm in self.test_masses)))

    @cached_property
    def inverse_mass(self) -> FloatArray:
        """J⁻¹ [12, 12]."""
        return np.asarray(scipy.linalg.block_diag(*(tm.inverse_mass for tm in self.test_masses)))

    @cached_property
    def E(self) -> FloatArray:
        """[15, 18]: second derivatives of the coordinates by w."""
        e = np.zeros((N_COORDINATES, N_INPUTS))
        e[0:3] = self.spacecraft_response[3:6]
        e[3:] = -self.housing @ self.spacecraft_response
        e[3:, 6:] += self.inverse_mass
        return e

    @cached_property
    def stray_wrench(self) -> FloatArray:
        """[18, 12]: w by disturbing accelerations s of the test masses, J s."""
        w = np.zeros((N_INPUTS, N_STRAY))
        w[6:] = self.generalised_mass
        return w

    @cached_property
    def stiffness_wrench(self) -> FloatArray:
        """[18, 15]: w by the coordinates, J K_fix."""
        w = np.zeros((N_INPUTS, N_COORDINATES))
        for i, tm in enumerate(self.test_masses):
            w[wrench_on(i), motion_of(i)] = tm.generalised_mass @ self.fixed[i]
        return w

    @cached_property
    def K(self) -> FloatArray:
        """[15, 15], 1/s²: second derivatives of the coordinates by the coordinates."""
        k = self.E @ self.stiffness_wrench
        k[3:, 3:] += self.mutual
        return k

    @cached_property
    def total_stiffness(self) -> FloatArray:
        """[12, 12]: force per mass and torque per moment by the motions of both test masses, the spacecraft held."""
        k = self.mutual.copy()
        k[0:6, 0:6] += self.fixed[0]
        k[6:12, 6:12] += self.fixed[1]
        return k

    def eighteen(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """M, K [18, 18] and U [18, 18] of M q'' = K q + U w; q: spacecraft position and attitude, then the test masses.

        Rows: force and torque balance of the spacecraft, then force and torque of each test mass. Columns of the
        test masses are their motions relative to the housings; rows of M hold m_i C_iᵀ, -m_i C_iᵀ [h_i]x, m_i and
        I_i C_iᵀ, I_i. Rows of the spacecraft in K and U hold the reactions.
        """
        j = self.generalised_mass
        m, k, u = np.zeros((18, 18)), np.zeros((18, 18)), np.eye(18)
        m[0:3, 0:3] = self.spacecraft.mass_kg * np.eye(3)
        m[3:6, 3:6] = self.spacecraft.inertia_kg_m2
        m[6:, 0:6] = j @ self.housing
        m[6:, 6:] = j
        k[6:, 6:] = j @ self.total_stiffness
        for i, (tm, h) in enumerate(zip(self.test_masses, self.lever_m, strict=True)):
            c, here = tm.to_basic, wrench_on(i)
            reaction = -np.block([[c, np.zeros((3, 3))], [cross_matrix(h) @ c, c]])
            u[0:6, here] = reaction
            k[0:6, here] = reaction @ (tm.generalised_mass @ self.fixed[i])
        return m, k, u
