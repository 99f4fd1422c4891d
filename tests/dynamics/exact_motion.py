"""Three free rigid bodies in inertial coordinates: the exact motion, of which the plant is the linear part.

Nothing of the plant's algebra is used: each body has its place, velocity, attitude and spin; forces follow from where
the test masses stand in the turned spacecraft, and what acts on a test mass acts back at the same point.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import integrate
from scipy.spatial.transform import Rotation

from tedm_cli.arrays import FloatArray
from tedm_cli.dynamics.plant import Plant

# of one body: place [3], velocity [3], attitude (quaternion [4], body to inertial), spin [3] in its own axes
_PLACE, _VELOCITY, _ATTITUDE, _SPIN, _SIZE = slice(0, 3), slice(3, 6), slice(6, 10), slice(10, 13), 13


@dataclass(frozen=True, eq=False)
class Motion:
    """A state of the three bodies and what follows from it."""

    plant: Plant
    state: FloatArray

    def body(self, k: int) -> FloatArray:
        return self.state[_SIZE * k : _SIZE * (k + 1)]

    def attitude(self, k: int) -> FloatArray:
        q = self.body(k)[_ATTITUDE]
        matrix: FloatArray = Rotation.from_quat(q / np.linalg.norm(q)).as_matrix()
        return matrix

    def of_test_mass(self, i: int) -> tuple[FloatArray, FloatArray]:
        """r_i and α_i (rotation vector) in the frame of its housing."""
        tm, b = self.plant.test_masses[i], self.attitude(0)
        place = b.T @ (self.body(i + 1)[_PLACE] - self.body(0)[_PLACE]) - self.plant.lever_m[i]
        turn = tm.axes @ b.T @ self.attitude(i + 1)
        return tm.axes @ place, Rotation.from_matrix(turn).as_rotvec()

    @property
    def coordinates(self) -> FloatArray:
        """[15]: attitude of the spacecraft, then r_1, α_1, r_2, α_2."""
        parts = [Rotation.from_matrix(self.attitude(0)).as_rotvec()]
        for i in (0, 1):
            parts += self.of_test_mass(i)
        return np.concatenate(parts)

    def masses(self, k: int) -> tuple[float, FloatArray]:
        """Mass and tensor of inertia in the body's axes."""
        if k == 0:
            return self.plant.spacecraft.mass_kg, self.plant.spacecraft.inertia_kg_m2
        tm = self.plant.test_masses[k - 1]
        return tm.mass_kg, tm.inertia_kg_m2

    @property
    def momentum(self) -> FloatArray:
        """[6]: linear momentum, and angular momentum about the origin of the inertial frame."""
        total = np.zeros(6)
        for k in range(3):
            m, inertia = self.masses(k)
            x, v = self.body(k)[_PLACE], self.body(k)[_VELOCITY]
            total[:3] += m * v
            total[3:] += m * np.cross(x, v) + self.attitude(k) @ inertia @ self.body(k)[_SPIN]
        return total

    @property
    def kinetic_energy(self) -> float:
        energy = 0.0
        for k in range(3):
            m, inertia = self.masses(k)
            v, spin = self.body(k)[_VELOCITY], self.body(k)[_SPIN]
            energy += 0.5 * m * float(v @ v) + 0.5 * float(spin @ inertia @ spin)
        return energy

    @property
    def potential_energy(self) -> float:
        """Of a stiffness that has one: symmetric among places, isotropic among angles, none between them."""
        energy = 0.0
        for i, tm in enumerate(self.plant.test_masses):
            q = np.concatenate(self.of_test_mass(i))
            energy -= 0.5 * float(q @ (tm.generalised_mass @ self.plant.fixed[i] @ q))
        return energy

    def rate(self, wrench: FloatArray) -> FloatArray:
        """Derivative of the state under w [18] and the stiffness of each test mass in its housing."""
        b = self.attitude(0)
        force = [b @ wrench[0:3], np.zeros(3), np.zeros(3)]  # inertial
        torque = [b @ wrench[3:6], np.zeros(3), np.zeros(3)]
        for i, tm in enumerate(self.plant.test_masses):
            own = wrench[6 + 6 * i : 12 + 6 * i]
            own = own + tm.generalised_mass @ self.plant.fixed[i] @ np.concatenate(self.of_test_mass(i))
            f, t = b @ tm.axes.T @ own[:3], b @ tm.axes.T @ own[3:]
            force[i + 1], torque[i + 1] = f, t
            force[0] = force[0] - f
            torque[0] = torque[0] - t - np.cross(self.body(i + 1)[_PLACE] - self.body(0)[_PLACE], f)
        out = np.empty_like(self.state)
        for k in range(3):
            m, inertia = self.masses(k)
            x, y, z, s = self.body(k)[_ATTITUDE]
            spin, here = self.body(k)[_SPIN], out[_SIZE * k : _SIZE * (k + 1)]
            here[_PLACE], here[_VELOCITY] = self.body(k)[_VELOCITY], force[k] / m
            by_spin = np.array([[s, -z, y], [z, s, -x], [-y, x, s], [-x, -y, -z]])
            here[_ATTITUDE] = 0.5 * by_spin @ spin
            here[_SPIN] = np.linalg.solve(inertia, self.attitude(k).T @ torque[k] - np.cross(spin, inertia @ spin))
        return out


def placed(plant: Plant, coordinates: FloatArray, spin: FloatArray | None = None) -> Motion:
    """At `coordinates` [15]; at rest, or with everything turning as one rigid body by `spin` (inertial, rad/s)."""
    spin = np.zeros(3) if spin is None else spin
    b = Rotation.from_rotvec(coordinates[0:3]).as_matrix()
    bodies = [(np.zeros(3), b)]
    for i, tm in enumerate(plant.test_masses):
        r, alpha = coordinates[3 + 6 * i : 6 + 6 * i], coordinates[6 + 6 * i : 9 + 6 * i]
        at = b @ (plant.lever_m[i] + tm.axes.T @ r)
        bodies.append((at, b @ tm.axes.T @ Rotation.from_rotvec(alpha).as_matrix()))
    state = [
        np.concatenate([at, np.cross(spin, at), Rotation.from_matrix(turned).as_quat(), turned.T @ spin])
        for at, turned in bodies
    ]
    return Motion(plant, np.concatenate(state))


def move(start: Motion, time_s: FloatArray, wrench: FloatArray | None = None) -> list[Motion]:
    """The motion at `time_s`, under a constant wrench in the axes of spacecraft and housings."""
    w = np.zeros(18) if wrench is None else wrench
    done = integrate.solve_ivp(
        lambda _, y: Motion(start.plant, y).rate(w),
        (0.0, float(time_s[-1])),
        start.state,
        method="DOP853",
        t_eval=time_s,
        rtol=1e-13,
        atol=1e-20,
    )
    assert done.success, done.message
    return [Motion(start.plant, y) for y in done.y.T]
