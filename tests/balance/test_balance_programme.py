"""The programme of a balance against sums by hand, its duals against differences, whole shims against all there are."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tedm_cli.balance.programme import Programme, balanced, least_mass, most_met, on_each_other, whole_units
from tedm_cli.balance.retrim import least_change


def programme(rest: Any, effect: Any, **changed: Any) -> Programme:
    """Limits of ±1 on every quantity, unknowns of 1 kg that may be 0 to 10, and no margin."""
    effect = np.array(effect, dtype=float)
    rows, columns = effect.shape
    given = {
        "rest": np.array(rest, dtype=float),
        "lower": np.full(rows, -1.0),
        "upper": np.ones(rows),
        "effect": effect,
        "unit_kg": np.ones(columns),
        "least": np.zeros(columns),
        "most": np.full(columns, 10.0),
        "whole": np.zeros(columns, dtype=bool),
        "matrix": np.zeros((0, columns)),
        "bound": np.zeros(0),
        **changed,
    }
    return Programme(**given)


def test_two_blocks_and_one_requirement_by_hand() -> None:
    """v = 5 - 2 u1 - 0.5 u2 to at most 1 less 20 %: 4.2 are taken off by the block that pulls most per kilogram."""
    p = programme([5.0], [[-2.0, -0.5]], margin=0.2)
    found, conflicts = balanced(p)
    np.testing.assert_allclose(found.units, [2.1, 0.0], atol=1e-12)
    assert not conflicts
    assert found.mass_kg(p) == pytest.approx(2.1)
    assert found.price_kg[0] == pytest.approx(0.5), "a unit of ratio more saves half a kilogram"
    # The first block holds a kilogram: the other does what is left, and a kilogram more would save three of it.
    p = replace(p, most=np.array([1.0, 10.0]))
    found, _ = balanced(p)
    np.testing.assert_allclose(found.units, [1.0, 2.2 / 0.5], atol=1e-12)
    assert found.price_kg[0] == pytest.approx(2.0)
    np.testing.assert_allclose(found.room_kg, [3.0, 0.0], atol=1e-12)


def test_both_ends_of_a_range_that_is_not_even() -> None:
    p = programme([-5.0, 0.0], [[1.0], [0.3]], lower=np.array([-0.5, -2.0]), upper=np.array([3.0, 1.5]))
    found, _ = balanced(p)
    assert found.units[0] == pytest.approx(4.5, rel=1e-5)
    np.testing.assert_allclose(p.ratios(found.units), [1.0, 4.5 * 0.3 / 1.5], rtol=1e-5)


def test_duals_are_the_change_of_the_mass() -> None:
    """Prices and room against a programme with a limit, or a box, that is a little wider."""
    rng = np.random.default_rng(27)
    p = programme(rng.normal(size=6) * 4.0, rng.normal(size=(6, 14)), margin=0.1, most=np.full(14, 1.5),
                  unit_kg=rng.uniform(0.5, 2.0, 14))  # fmt: skip
    found = least_mass(p)
    assert found is not None
    assert (found.price_kg > 0.0).sum() >= 3
    assert (found.room_kg > 0.0).any()
    step = 1e-6
    for row in range(6):
        end = np.where(np.arange(6) == row, 1.0 + step, 1.0)
        wider = least_mass(replace(p, upper=p.upper * end, lower=p.lower * end))
        assert wider is not None
        saved = (found.mass_kg(p) - wider.mass_kg(p)) / step
        assert saved == pytest.approx(found.price_kg[row] * 0.9, abs=1e-5)
    for column in range(14):
        more = p.most + np.where(np.arange(14) == column, step / p.unit_kg, 0.0)
        wider = least_mass(replace(p, most=more))
        assert wider is not None
        assert (found.mass_kg(p) - wider.mass_kg(p)) / step == pytest.approx(found.room_kg[column], abs=1e-5)


def test_what_cannot_be_met_is_named() -> None:
    """Two quantities that every mass moves in opposite ways: they meet half way; a third can be met, and is."""
    effect = [[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, -1.0], [0.0, 0.0, 0.0]]
    p = programme([8.0, 0.0, 5.0, 7.0], effect, margin=0.1)
    found, conflicts = balanced(p)
    assert [c.ratio for c in conflicts] == pytest.approx([4.0])
    np.testing.assert_allclose(conflicts[0].weight, [0.5, 0.5, 0.0, 0.0])
    np.testing.assert_array_equal(found.blocking, [1.0, 1.0, 0.0, 0.0])
    np.testing.assert_allclose(p.ratios(found.units), [4.04, 3.96, 0.9, 7.0], rtol=1e-6)
    np.testing.assert_array_equal(p.reached, [True, True, True, False])
    assert found.mass_kg(p) == pytest.approx(3.96 + 4.1, rel=1e-6), "and no more mass than a hundredth more takes"


def test_a_full_box_is_named_as_what_would_help() -> None:
    p = programme([8.0], [[-1.0, -0.25]], most=np.array([2.0, 4.0]), unit_kg=np.array([0.5, 0.5]))
    found, (conflict,) = balanced(p)
    assert conflict.ratio == pytest.approx(5.0)
    np.testing.assert_allclose(conflict.gain, [2.0, 0.5], atol=1e-9)
    np.testing.assert_allclose(found.units, [2.0, 4.0 - 0.05 * 4], atol=1e-6)


def test_the_worst_ratio_comes_first_and_then_the_next() -> None:
    """Three requirements whose own boxes are too small, by different amounts."""
    p = programme([9.0, 6.0, 3.0], -np.eye(3), most=np.array([2.0, 2.0, 5.0]))
    found, conflicts = balanced(p)
    assert [c.ratio for c in conflicts] == pytest.approx([7.0, 4.0])
    np.testing.assert_array_equal(found.blocking, [1.0, 2.0, 0.0])
    np.testing.assert_allclose(p.ratios(found.units), [7.07, 4.04, 1.0], rtol=1e-5)


def test_whole_shims_are_the_best_of_all_whole_shims() -> None:
    """Against every combination of a stack of three and steps of another block; never below the relaxed bound."""
    rng = np.random.default_rng(1)
    tried, stack = 0, on_each_other([(0, 1), (1, 2)], 5)[0]
    for _ in range(30):
        p = programme(
            rng.normal(size=2) * 2.0, rng.normal(size=(2, 5)), most=np.array([1.0, 1.0, 1.0, 3.0, 2.0]),
            whole=np.array([True, True, True, True, False]), matrix=stack, bound=np.zeros(2),
            unit_kg=np.array([1.0, 1.0, 1.0, 0.7, 1.3]),
        )  # fmt: skip
        relaxed, conflicts = balanced(p)
        found, beyond = whole_units(p, relaxed, 10.0)
        assert (np.diff(found.units[:3]) <= 0).all(), "a shim lies on the one below it"
        if conflicts or beyond:
            continue
        tried += 1
        best = np.inf
        for height, steps in itertools.product(range(4), range(4)):
            fixed = np.array([*(float(n < height) for n in range(3)), float(steps), 0.0])
            rest = p.rest + p.effect @ fixed
            last = least_mass(replace(p, rest=rest, most=np.array([0, 0, 0, 0, 2.0])))
            best = best if last is None else min(best, float(p.unit_kg @ (fixed + last.units)))
        assert found.mass_kg(p) == pytest.approx(best, abs=1e-6)
        assert relaxed.mass_kg(p) - 1e-7 <= found.bound_kg <= found.mass_kg(p) + 1e-7
        assert (p.ratios(found.units) <= 1.0 + 1e-6).all()
    assert tried >= 8


def test_whole_shims_that_cannot_keep_the_caps_come_as_near_as_they_can() -> None:
    p = programme([2.35], [[-1.0]], whole=np.array([True]), upper=np.array([0.3]), lower=np.array([-0.3]))
    relaxed, _ = balanced(p)
    found, beyond = whole_units(p, relaxed, 10.0)
    assert relaxed.units[0] == pytest.approx(2.05)
    assert found.units[0] == 2.0
    assert beyond == pytest.approx(0.35 / 0.3 - 1.0, rel=1e-4)


def test_a_block_has_its_least_mass_or_is_not_there() -> None:
    p = programme([3.0], [[-2.0, -1.0]], least=np.array([5.0, 0.0]))
    relaxed, _ = balanced(p)
    found, beyond = whole_units(p, relaxed, 10.0)
    assert relaxed.units[0] == pytest.approx(1.0)
    np.testing.assert_allclose(found.units, [0.0, 2.0], atol=1e-5)
    assert beyond == 0.0


def test_the_most_that_can_be_met_together() -> None:
    """One quantity is beyond its box, two hold each other, and one is free: two can be met."""
    effect = [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]
    p = programme([20.0, 5.0, 0.0, 3.0], effect, margin=0.1)
    kept = most_met(p, 10.0)
    assert kept.sum() == 2
    assert kept[3]
    assert not kept[0]
    assert kept[1] != kept[2]
    found, conflicts = balanced(p, kept)
    ratios = p.ratios(found.units)
    assert (ratios <= 0.9 + 1e-6).sum() == 2
    assert sorted(c.ratio for c in conflicts) == pytest.approx([4.1, 10.0])
    assert [c.ratio for c in balanced(p)[1]] == pytest.approx([10.0, 2.5]), "the least worst ratios leave one met alone"


def test_what_can_be_met_without_its_margin_is_met() -> None:
    """A hundredth is given away of what cannot be met; of a ratio just below 1 only as much as keeps it there."""
    p = programme([2.995], [[-1.0]], most=np.array([2.0]), margin=0.1)
    found, (conflict,) = balanced(p)
    assert conflict.ratio == pytest.approx(0.995)
    assert 0.995 <= p.ratios(found.units)[0] <= 1.0


@pytest.mark.parametrize(("rest", "units", "change"), [(5.0, 4.0, 0.0), (7.5, 6.5, 2.5), (0.5, 1.5, 2.5)])
def test_the_least_change_adds_or_takes_away(rest: float, units: float, change: float) -> None:
    """There are 3 and 1 units, of which each takes off 1; the second weighs twice as much, so the first changes."""
    p = programme([rest], [[-1.0, -1.0]], unit_kg=np.array([1.0, 2.0]))
    extended = least_change(p, np.array([3.0, 1.0]))
    found, conflicts = balanced(extended)
    assert not conflicts
    assert found.mass_kg(extended) == pytest.approx(change, abs=1e-5)
    np.testing.assert_allclose(found.units[:2], [units - 1.0, 1.0], atol=1e-5)
