"""The linear plant against the exact motion of three rigid bodies, whose own balances are checked first."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from dynamics_models import askew_plant
from exact_motion import move, placed

from tedm_cli.dynamics.in_time import released, time_loop
from tedm_cli.dynamics.plant import Plant
from tedm_cli.dynamics.signals import COORDINATES

TIME = np.linspace(0.0, 1200.0, 7)
RNG = np.random.default_rng(12)
# metres for places, radians for angles, of the same effect on forces
SHAPE = RNG.uniform(0.5, 1.0, 15) * np.concatenate([np.full(3, 3.0), np.tile([1, 1, 1, 3, 3, 3], 2)])


def alone(seed: int = 0) -> Plant:
    """Test masses that feel the spacecraft alone."""
    plant = askew_plant(seed)
    return replace(plant, mutual=np.zeros((12, 12)))


def conservative() -> Plant:
    """A stiffness that is the second derivative of a potential: symmetric, and isotropic for rotations."""
    plant, fixed = alone(), np.zeros((2, 6, 6))
    for i, tm in enumerate(plant.test_masses):
        fixed[i, :3, :3] = plant.fixed[i, :3, :3] + plant.fixed[i, :3, :3].T
        fixed[i, 3:, 3:] = -2e-6 * np.trace(tm.inertia_kg_m2) / 3 * np.linalg.inv(tm.inertia_kg_m2)
    return replace(plant, fixed=fixed)


def test_momentum_is_kept_by_the_exact_motion() -> None:
    plant = alone()
    path = move(placed(plant, 1e-2 * SHAPE, spin=np.array([2e-3, -1e-3, 3e-3])), TIME)
    momentum = np.stack([m.momentum for m in path])
    moved = np.abs(path[-1].coordinates - path[0].coordinates).max()
    assert moved > 1e-2  # what is kept is kept in motion
    assert np.abs(momentum[:, :3] - momentum[0, :3]).max() < 1e-12
    assert np.abs(momentum[:, 3:] - momentum[0, 3:]).max() < 1e-11 * np.abs(momentum[0, 3:]).max()


def test_energy_is_kept_by_the_exact_motion() -> None:
    path = move(placed(conservative(), 1e-2 * SHAPE), TIME)
    kinetic = np.array([m.kinetic_energy for m in path])
    potential = np.array([m.potential_energy for m in path])
    assert kinetic.max() > 0.1 * np.abs(potential[0])  # energy changes hands
    np.testing.assert_allclose(kinetic + potential, potential[0], atol=1e-10 * np.abs(potential).max())


def test_forces_that_do_not_act_back_do_not_keep_momentum() -> None:
    """The check above sees a missing reaction: a force on the spacecraft alone moves the sum."""
    push = np.zeros(18)
    push[0] = 1e-9
    path = move(placed(alone(), 1e-2 * SHAPE), TIME, push)
    assert np.linalg.norm(path[-1].momentum[:3]) == pytest.approx(1e-9 * TIME[-1], rel=1e-2)


@pytest.mark.parametrize("seed", range(3))
def test_accelerations_at_rest_are_those_of_the_plant(seed: int) -> None:
    plant = alone(seed)
    wrench = np.random.default_rng(seed).normal(size=18)
    wrench[3:6] *= 0.3
    wrench[[9, 10, 11, 15, 16, 17]] *= 1e-3
    exact = placed(plant, np.zeros(15)).rate(wrench)
    a_b, rate_b = exact[3:6], exact[10:13]
    second = [rate_b]
    for i, tm in enumerate(plant.test_masses):
        body = exact[13 * (i + 1) : 13 * (i + 2)]
        second.append(tm.axes @ (body[3:6] - a_b - np.cross(rate_b, plant.lever_m[i])))
        second.append(body[10:13] - tm.axes @ rate_b)
    np.testing.assert_allclose(plant.E @ wrench, np.concatenate(second), rtol=1e-11, atol=1e-14)


@pytest.mark.parametrize("seed", range(2))
def test_linear_motion_comes_to_the_exact_one_as_the_amplitude_shrinks(seed: int) -> None:
    plant, off = alone(seed), []
    for amplitude in (1e-3, 1e-4, 1e-5):
        exact = np.stack([m.coordinates for m in move(placed(plant, amplitude * SHAPE), TIME)], axis=1)
        offset = dict(zip(COORDINATES, amplitude * SHAPE, strict=True))
        linear = np.concatenate(list(released(time_loop(plant, None, COORDINATES), offset, TIME[1], len(TIME))), axis=1)
        off.append(np.abs(linear - exact).max() / np.abs(exact).max())
    ratio = np.array(off[:-1]) / off[1:]
    np.testing.assert_allclose(ratio, 10.0, rtol=0.05)
    assert off[-1] < 1e-3
