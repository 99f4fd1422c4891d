"""The outer search finds optima that are known otherwise, from a start that a seed draws."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from tedm_cli.balance.boxes import Box, columns_of
from tedm_cli.balance.programme import Programme
from tedm_cli.balance.search import objective_of, searched
from tedm_cli.config.project import Project
from tedm_cli.gravity.compensation import field_of_compensation_masses
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.progress import silent
from tedm_cli.stages.balance.balance import balance

TM = TestMass(name="TM1", position_m=np.zeros(3), side_m=np.full(3, 0.046), mass_kg=1.96)
Make = Callable[..., Project]
SOUGHT = """
subsystems = ["all"]
margin = 0.1

[search]
generations = 3
population = 4
seed = {seed}

[[box]]
name = "CM"
frame = "TM1"
low_m = [-0.084, -0.030, -0.030]
high_m = [-0.034, 0.030, 0.030]
density_kg_m3 = 18500.0
block_m = [0.020, 0.040, 0.040]
alike = true
"""


def test_a_block_goes_where_a_gram_pulls_most() -> None:
    """A pull along x is asked for. A cube in a box of 40 x 60 x 60 mm does it with least mass at the face near to the
    test mass, in the middle of the others: from a random start it is found there, to 0.1 mm."""
    box = Box(
        name="B", centre_m=np.array([0.06, 0.0, 0.0]), size_m=np.array([0.04, 0.06, 0.06]), axes=np.eye(3),
        density_kg_m3=18500.0, inner_m=np.full(3, 0.016),
    )  # fmt: skip

    def objective(numbers: np.ndarray) -> float:
        (column,) = columns_of([box.placed(numbers)])
        pull = field_of_compensation_masses(TM, column.blocks, tolerance=1e-7)[0].acceleration[0]
        one = np.array([1.0])
        return objective_of(
            Programme(
                rest=np.array([-3e-9]), lower=np.array([-1e-9]), upper=np.array([1e-9]), effect=np.array([[pull]]),
                unit_kg=one * column.unit_kg, least=0.0 * one, most=one, whole=np.array([False]),
                matrix=np.zeros((0, 1)), bound=np.zeros(0),
            ),
            1.0,
        )  # fmt: skip

    found = searched(objective, np.zeros(3), np.ones(3), seed=2, generations=8, population=5)
    np.testing.assert_allclose(found.parameter, [0.0, 0.5, 0.5], atol=2.5e-3)
    best = objective(np.array([0.0, 0.5, 0.5]))
    assert found.objective == pytest.approx(best, rel=1e-4)
    others = [objective(np.random.default_rng(n).uniform(0.0, 1.0, 3)) for n in range(10)]
    assert min(others) > 1.01 * best


def test_sizes_are_sought_where_they_may_vary() -> None:
    """Numbers of a box say place and size along each edge where there is room; the block never leaves the box."""
    box = Box(
        name="B", centre_m=np.array([0.1, 0.2, 0.3]), size_m=np.array([0.04, 0.03, 0.02]), axes=np.eye(3),
        density_kg_m3=1000.0, inner_m=np.array([0.01, 0.03, 0.005]), vary_size=True,
    )  # fmt: skip
    assert box.sought == 4
    largest = box.placed(np.array([0.3, 0.9, 1.0, 1.0]))
    np.testing.assert_allclose(largest.size_m, box.size_m)
    np.testing.assert_allclose(largest.centre_m, box.centre_m)
    least = box.placed(np.array([0.0, 1.0, 0.0, 0.0]))
    np.testing.assert_allclose(least.size_m, [0.01, 0.03, 0.005])
    np.testing.assert_allclose(least.centre_m, [0.1 - 0.015, 0.2, 0.3 + 0.0075])


def test_the_command_seeks_places(project_of: Make) -> None:
    """The difference of a_x is all that is asked for: the block ends at the near face."""
    done = balance(project_of(SOUGHT.format(seed=3)), None, None, silent)
    r = done.results
    assert done.sought is not None
    assert done.sought.numbers == 3
    assert r.met == len(r.after)
    at = r.centre[r.block.index("CM")] - [-0.188, 0.0, 0.0]
    assert at[0] == pytest.approx(-0.044, abs=1e-3)
    np.testing.assert_allclose(r.size[0], [0.020, 0.040, 0.040])
