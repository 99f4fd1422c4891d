"""Which variant dominates which: against the definition, spelt out for every pair, and by what any order must have."""

from __future__ import annotations

import math
from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tedm_cli.trade.changes import changes, largest_of_any
from tedm_cli.trade.pareto import best, costs, dominance, fronts, scores

NAN = math.nan
#: Few values, so that ties and empty criteria are common.
COSTS = st.integers(1, 7).flatmap(
    lambda v: st.integers(1, 4).flatmap(
        lambda c: arrays(np.float64, (v, c), elements=st.sampled_from([0.0, 1.0, 2.0, 3.0, NAN]))
    )
)


def dominates(a: list[float], b: list[float]) -> bool:
    """The definition: all that b has, a has, at least as good, and one of them better."""
    had = [(x, y) for x, y in zip(a, b, strict=True) if not math.isnan(y)]
    return all(not math.isnan(x) and x <= y for x, y in had) and any(x < y for x, y in had)


@given(COSTS)
def test_every_pair_by_the_definition(cost: np.ndarray) -> None:
    rows = cost.tolist()
    assert dominance(cost).tolist() == [[dominates(a, b) for b in rows] for a in rows]


@given(COSTS)
def test_it_is_a_strict_order(cost: np.ndarray) -> None:
    """Never of itself, never both ways, and passed on: or a variant could be dominated by none and by all."""
    d = dominance(cost)
    assert not d.diagonal().any()
    assert not (d & d.T).any()
    assert not ((d.astype(int) @ d.astype(int) > 0) & ~d).any()


@given(COSTS)
def test_fronts_are_what_is_left_when_those_before_are_taken_away(cost: np.ndarray) -> None:
    rows, found = cost.tolist(), fronts(cost).tolist()
    left = {i for i, row in enumerate(rows) if not all(map(math.isnan, row))}
    assert {i for i, f in enumerate(found) if f == 0} == set(range(len(rows))) - left
    number = 0
    while left:
        number += 1
        front = {i for i in left if not any(dominates(rows[j], rows[i]) for j in left)}
        assert front, "some variant is on every front"
        assert {i for i, f in enumerate(found) if f == number} == front
        left -= front
    assert max(found, default=0) == number


@given(COSTS, st.randoms())
def test_the_order_of_variants_and_criteria_is_nothing(cost: np.ndarray, random: Random) -> None:
    v, c = list(range(cost.shape[0])), list(range(cost.shape[1]))
    random.shuffle(v)
    random.shuffle(c)
    assert fronts(cost[np.ix_(v, c)]).tolist() == fronts(cost)[v].tolist()


@given(COSTS)
def test_a_criterion_that_all_lack_or_in_which_all_are_alike_changes_nothing(cost: np.ndarray) -> None:
    more = np.hstack([cost, np.full((len(cost), 1), NAN)])
    assert fronts(more).tolist() == fronts(cost).tolist()
    same = np.where(fronts(cost)[:, None] > 0, 5.0, NAN)
    assert fronts(np.hstack([cost, same])).tolist() == fronts(cost).tolist()


def test_what_is_lacked_is_neither_zero_nor_bad() -> None:
    whole, lacking, worse = [1.0, 1.0], [1.0, NAN], [2.0, NAN]
    assert fronts(np.array([whole, lacking])).tolist() == [1, 1], "nothing is better because the other lacks something"
    assert fronts(np.array([whole, worse])).tolist() == [1, 2], "it can be worse in what it has"
    assert fronts(np.array([[2.0, 9.0], lacking])).tolist() == [1, 1], "and does not dominate what has one more"
    assert fronts(np.array([[NAN, NAN], [3.0, 3.0]])).tolist() == [0, 1]
    assert fronts(np.zeros((2, 0))).tolist() == [0, 0]


def test_comparing_what_two_share_would_go_in_a_circle() -> None:
    """Why the relation is as it is: here each would be better than the next in all that both have."""
    cost = np.array([[1.0, NAN, 2.0], [2.0, 1.0, NAN], [NAN, 2.0, 1.0]])
    assert fronts(cost).tolist() == [1, 1, 1]


def test_more_is_better_where_it_is_said_and_rounding_does_not_decide() -> None:
    values = np.array([[60.0, 1.0], [70.0, 1.0 + 1e-9], [70.0, 1.001]])
    assert fronts(costs(values, [True, False])).tolist() == [2, 1, 2]
    assert fronts(costs(values, [False, False])).tolist() == [1, 2, 3]
    turned = costs(np.array([[NAN], [0.0]]), [True])
    assert math.isnan(turned[0, 0])
    assert math.copysign(1.0, turned[1, 0]) == 1.0


def test_the_best_of_one_criterion() -> None:
    assert best(np.array([3.0, 1.0, NAN, 1.0])) == [1, 3]
    assert best(np.array([NAN, NAN])) == []


def test_scores() -> None:
    cost = np.array([[0.0, 10.0, 1.0], [1.0, 20.0, 1.0], [0.5, 20.0, NAN]])
    assert scores(cost, np.array([3.0, 1.0, 0.0])).tolist() == pytest.approx([0.0, 1.0, 0.625])
    found = scores(cost, np.array([3.0, 0.0, 1.0]))
    assert found[:2].tolist() == pytest.approx([0.0, 0.75])
    assert math.isnan(found[2]), "a variant that lacks a criterion with a weight has no score"
    assert np.isnan(scores(cost, np.zeros(3))).all()


@given(COSTS, st.data())
def test_the_least_score_is_dominated_by_none_that_has_one(cost: np.ndarray, data: st.DataObject) -> None:
    weight = np.array(
        data.draw(st.lists(st.sampled_from([0.5, 1.0, 2.0]), min_size=cost.shape[1], max_size=cost.shape[1]))
    )
    found = scores(cost, weight)
    assert ((found[~np.isnan(found)] >= 0.0) & (found[~np.isnan(found)] <= 1.0 + 1e-12)).all()
    if not np.isnan(found).all():
        least = int(np.nanargmin(found))
        assert not dominance(cost)[~np.isnan(found), least].any()


def test_what_has_changed_most_comes_first() -> None:
    found = changes({"a": 1.0, "b": -4.0, "c": 2.0}, {"b": 1.0, "c": 2.0, "d": 3.0})
    assert [(c.name, c.before, c.after) for c in found] == [
        ("b", -4.0, 1.0),
        ("d", None, 3.0),
        ("a", 1.0, None),
        ("c", 2.0, 2.0),
    ]
    assert sum(c.difference for c in found) == pytest.approx(6.0 - -1.0)


def test_contributors_that_are_large_anywhere() -> None:
    assert largest_of_any([{"a": 5.0, "b": 1.0}, {"b": -9.0, "c": 2.0}], 1) == ["b", "a"]
    assert largest_of_any([{}, {"b": 1.0}], 3) == ["b"]
    assert largest_of_any([], 3) == []
