"""Test masses are summed side by side: the same bits, one after the other for those who listen, and an early end."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import numpy as np
import pytest

from benchmarks import synthetic
from tedm_cli.config.model.file import load_model
from tedm_cli.contracts import UNIT_LOADS
from tedm_cli.files.store import open_checked
from tedm_cli.gravity.structure import structure_gravity
from tedm_cli.results.unit_loads import mass_of
from tedm_cli.threads import side_by_side


def test_fields_and_operators_are_those_of_one_thread_to_the_bit(tmp_path_factory: pytest.TempPathFactory) -> None:
    where = synthetic.project(tmp_path_factory.mktemp("threads"))
    with open_checked(synthetic.write_unit_loads(where, synthetic.block((24, 15, 10)), 2), UNIT_LOADS) as unit:
        masses = mass_of(unit)
    test_masses = load_model(where.model)[1].test_masses()
    done = [0]

    def add(more: int) -> None:
        done[0] += more

    both = side_by_side(lambda tm, on: structure_gravity(masses, tm, tolerance=1e-3, advance=on), test_masses, add)
    assert done[0] == 2 * sum(len(block.id) for block in masses.elements)
    for found, tm in zip(both, test_masses, strict=True):
        alone = structure_gravity(masses, tm, tolerance=1e-3)
        np.testing.assert_array_equal(found.operator, alone.operator)
        np.testing.assert_array_equal(found.field.acceleration, alone.field.acceleration)
        np.testing.assert_array_equal(found.nodal("gamma_lin"), alone.nodal("gamma_lin"))


def test_whoever_listens_hears_one_thread_at_a_time() -> None:
    inside = threading.Lock()

    def listen(more: int) -> None:
        assert inside.acquire(blocking=False)
        time.sleep(1e-4)
        inside.release()

    def work(item: int, advance: Callable[[int], None]) -> int:
        for _ in range(50):
            advance(1)
        return item

    assert side_by_side(work, [3, 1, 2], listen) == [3, 1, 2]


@pytest.mark.parametrize("failure", [ValueError, KeyboardInterrupt])
def test_a_failure_ends_the_others_and_is_the_first_items(failure: type[BaseException]) -> None:
    started = threading.Barrier(2)
    steps: list[int] = []

    def work(item: int, advance: Callable[[int], None]) -> None:
        started.wait()
        if item == 0:
            raise failure
        while len(steps) < 1_000_000:
            steps.append(item)
            time.sleep(1e-5)
            advance(1)

    with pytest.raises(failure):
        side_by_side(work, [0, 1], lambda more: None)
    assert len(steps) < 1_000_000
