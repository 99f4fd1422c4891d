"""Non-dominated sorting of variants, of which some may lack a criterion.

Values are costs: less is better (`costs` turns those of which more is better). NaN: the variant lacks the criterion.

A variant dominates another where it has every criterion that the other has, is at least as good in each of these, and
better in one. What is lacked is thus neither bad nor good: nothing is better because the other lacks something, and a
variant does not dominate one that has a criterion more. This relation is a strict partial order (transitive, and never
both ways), so some variant is always on the front. Comparing the criteria that two variants share would not be: of
three variants each could then dominate the next.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray

DIGITS = 6  # of a value that are compared: rounding does not decide


def costs(values: FloatArray, more_is_better: Sequence[bool]) -> FloatArray:
    """Values [v, c] as costs, rounded to `DIGITS` significant digits; NaN stays."""
    return np.where(np.asarray(more_is_better, dtype=bool), -rounded(values), rounded(values)) + 0.0


def rounded(values: FloatArray) -> FloatArray:
    """Values of any shape with `DIGITS` significant digits; NaN stays."""
    digits = [float(f"{value:.{DIGITS - 1}e}") for value in np.ravel(values)]
    return np.array(digits, dtype=np.float64).reshape(np.shape(values))


def dominance(cost: FloatArray) -> BoolArray:
    """Whether variant i dominates variant j, [v, v], by costs [v, c]."""
    has = ~np.isnan(cost)
    filled = np.where(has, cost, 0.0)
    of_j = has[None, :, :]
    covers = (has[:, None, :] | ~of_j).all(axis=2)
    no_worse = ((filled[:, None, :] <= filled[None, :, :]) | ~of_j).all(axis=2)
    better = ((filled[:, None, :] < filled[None, :, :]) & of_j & has[:, None, :]).any(axis=2)
    dominates: BoolArray = covers & no_worse & better
    return dominates


def fronts(cost: FloatArray) -> IntArray:
    """The front [v] that each variant is on: 1 where none dominates it, 2 where only those of front 1 do, and so on.

    0: a variant that has no criterion at all is not compared.
    """
    dominates = dominance(cost)
    waiting = ~np.isnan(cost).all(axis=1) if cost.shape[1] else np.zeros(len(cost), dtype=bool)
    found = np.zeros(len(cost), dtype=np.int64)
    number = 0
    while waiting.any():
        number += 1
        now = waiting & ~(dominates & waiting[:, None]).any(axis=0)
        found[now] = number
        waiting &= ~now
    return found


def best(cost: FloatArray) -> list[int]:
    """The variants of the least cost [v] of one criterion, those that tie as well; none where all lack it."""
    return [] if np.isnan(cost).all() else [int(i) for i in np.flatnonzero(cost == np.nanmin(cost))]


def scores(cost: FloatArray, weight: FloatArray) -> FloatArray:
    """The weighted mean [v] of how far each cost [v, c] is on the way from the best to the worst of its criterion.

    0: the best in every criterion with a weight [c]; 1: the worst in each. NaN of a variant that lacks one of these
    criteria, and where none has a weight. A criterion in which all are alike counts as 0.
    """
    if not weight.sum() > 0.0:
        return np.full(len(cost), np.nan)
    used = cost[:, weight > 0.0]
    whole = ~np.isnan(used).any(axis=1)
    found = np.full(len(cost), np.nan)
    if whole.any():
        low, high = used[whole].min(axis=0), used[whole].max(axis=0)
        span = np.where(high > low, high - low, 1.0)
        found[whole] = ((used[whole] - low) / span) @ (weight[weight > 0.0] / weight.sum())
    return found
