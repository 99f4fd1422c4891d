"""Controllers of the drag-free satellite: what the read-outs y make of forces and torques, u = -K_c(s) y."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
import scipy

from tedm_cli.arrays import ComplexArray, FloatArray
from tedm_cli.dynamics.bodies import angle_words, cross_matrix, x_axes_are_parallel
from tedm_cli.dynamics.loops import Loop, LoopShape, StateSpace, polynomials, rational
from tedm_cli.dynamics.plant import Plant
from tedm_cli.dynamics.signals import COORDINATES, INPUTS, N_COORDINATES, N_INPUTS
from tedm_cli.errors import PhysicsError

DRAG_FREE = ("TM1_x", "TM1_y", "TM1_z", "TM1_theta", "TM2_y", "TM2_z")
SUSPENSION = ("x12", "TM1_eta", "TM1_phi", "TM2_theta", "TM2_eta", "TM2_phi")
ATTITUDE = ("SC_theta", "SC_eta", "SC_phi")
LOOPS = (*DRAG_FREE, *SUSPENSION, *ATTITUDE)

_CROSSOVER_HZ = {
    **{name: 0.05 for name in DRAG_FREE},
    "TM1_x": 0.1,
    "TM1_theta": 0.02,
    **{name: 2e-3 for name in SUSPENSION},
    "x12": 1e-3,
    **{name: 2e-4 for name in ATTITUDE},
}
_DELAY_S = {**{name: 0.4 for name in LOOPS}, **{name: 1.0 for name in ATTITUDE}}
_SINGULAR = 1e-9  # of the matrix that turns demands of the drag-free loops into accelerations, relative


class Controller(Protocol):
    """What the closed loop asks of a controller.

    `returns` [L, 15] and `acts` [18, L] are where its L loops can be broken one at a time: u = -acts v, v the commands
    of the loops, each made of `returns` y.
    """

    @property
    def loops(self) -> tuple[str, ...]:
        """Names of the loops [L]."""

    @property
    def returns(self) -> FloatArray:
        """[L, 15]: the error of each loop by the read-outs."""

    def command(self, s: ComplexArray) -> ComplexArray:
        """[F, 18, L] at `s` [F]: minus u by the errors of the loops."""

    def state_space(self) -> StateSpace:
        """From the read-outs [15] to minus u [18]."""


@dataclass(frozen=True, eq=False)
class ScalarLoops:
    """Independent scalar loops: drag-free by thrusters, suspension of what they leave, attitude by the test masses."""

    plant: Plant
    shapes: Sequence[Loop]

    @property
    def loops(self) -> tuple[str, ...]:
        return LOOPS

    @cached_property
    def returns(self) -> FloatArray:
        """[15, 15]: each loop's own coordinate; x12 = x2 - x1."""
        rows = np.zeros((len(LOOPS), N_COORDINATES))
        for n, name in enumerate(LOOPS):
            if name == "x12":
                rows[n, [COORDINATES.index("TM2_x"), COORDINATES.index("TM1_x")]] = 1.0, -1.0
            else:
                rows[n, COORDINATES.index(name)] = 1.0
        return rows

    @cached_property
    def actuation(self) -> FloatArray:
        """D [18, 15]: u = -D v, by the acceleration demand v of each loop."""
        return actuation(self.plant)

    @cached_property
    def _polynomials(self) -> tuple[FloatArray, FloatArray]:
        return polynomials(self.shapes)

    def command(self, s: ComplexArray) -> ComplexArray:
        out: ComplexArray = self.actuation * rational(*self._polynomials, s)[:, None, :]
        return out

    def state_space(self) -> StateSpace:
        parts = [loop.state_space() for loop in self.shapes]
        a, b, c, d = (scipy.linalg.block_diag(*(getattr(p, name) for p in parts)) for name in "abcd")
        return StateSpace(a, b @ self.returns, self.actuation @ c, self.actuation @ d @ self.returns)


def default_loops(shape: LoopShape = LoopShape()) -> tuple[Loop, ...]:
    """The loops of LISA Pathfinder's science mode; degrees of freedom as in PRD 99, 082001."""
    return tuple(Loop(name, _CROSSOVER_HZ[name], _DELAY_S[name], shape) for name in LOOPS)


def default_controller(plant: Plant, shapes: Sequence[Loop]) -> ScalarLoops:
    """The default controller of a satellite.

    Raises
    ------
    PhysicsError : test masses whose x axes are not parallel: the loop x12 holds them along one direction.
    """
    if not x_axes_are_parallel(plant.axes):
        raise PhysicsError(
            "the default controller is for test masses whose x axes are parallel;"
            f" these are {angle_words(plant.axes)} apart",
            hint="a controller of your own runs, without Δg: name its file in [controller] of the dynamics",
        )
    return ScalarLoops(plant, shapes)


def actuation(plant: Plant) -> FloatArray:
    """D [18, 15] of the science mode: u = -D v.

    Drag-free: (a, ω') = B⁻¹ v, F = m_B a, L = I_B ω', rows of B [(C_iᵀ)_k, -(C_iᵀ [h_i]x)_k] and for θ1 [0, (C_1ᵀ)_x].
    Suspension: m v, I v on the test mass. Attitude: forces m_i [C_iᵀ (v × (h_i - h_mid))] in y and z, torque I_1 e_x
    (C_1ᵀ v)_x on test mass 1; the spacecraft follows the test masses.

    Raises
    ------
    PhysicsError : B is singular; both test masses are at one x.
    """
    d = np.zeros((N_INPUTS, len(LOOPS)))
    sc, first = plant.spacecraft, plant.test_masses[0]
    b = np.stack([plant.housing[COORDINATES.index(name) - 3] for name in DRAG_FREE])
    scale = np.array([1.0, 1.0, 1.0, *(np.full(3, _length(plant)))])
    balanced = b * scale / np.linalg.norm(b * scale, axis=1, keepdims=True)
    if np.linalg.svd(balanced, compute_uv=False)[-1] < _SINGULAR:
        raise PhysicsError(
            "the thrusters cannot make both test masses drag-free in y and z: they are at one x",
            hint="the drag-free loops need test masses apart along the axis of measurement",
        )
    wanted = np.linalg.inv(b)
    n = len(DRAG_FREE)
    d[0:3, :n] = -sc.mass_kg * wanted[0:3]
    d[3:6, :n] = -sc.inertia_kg_m2 @ wanted[3:6]
    for k, name in enumerate(SUSPENSION, start=n):
        coordinate = COORDINATES.index("TM2_x" if name == "x12" else name) - 3
        d[6:, k] = plant.generalised_mass[:, coordinate]
    k = n + len(SUSPENSION)
    middle = plant.lever_m.mean(axis=0)
    for i, (tm, h) in enumerate(zip(plant.test_masses, plant.lever_m, strict=True)):
        turn = tm.mass_kg * tm.to_basic.T @ -cross_matrix(h - middle)
        d[6 + 6 * i + 1 : 6 + 6 * i + 3, k:] = turn[1:]
    at = INPUTS.index("TM1_Lx")
    d[at : at + 3, k:] = np.multiply.outer(first.inertia_kg_m2[:, 0], first.to_basic.T[0])
    return d


def _length(plant: Plant) -> float:
    """A length (m) that makes translations and rotations comparable: between the test masses, or 1 m at one place."""
    apart = float(np.linalg.norm(plant.lever_m[1] - plant.lever_m[0]))
    return 1.0 / apart if apart > 0.0 else 1.0
