"""The programme of a balance: masses at least total mass that keep every requirement, and what keeps them from it.

A requirement limits a quantity ``v = v₀ + E u`` to a range around 0; u are numbers of units of mass. As ratios to the
ends of the range, ``v/upper <= 1`` and ``v/lower <= 1``, all rows are of one size, and so is the solver's tolerance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.balance.quiet import solved_quietly
from tedm_cli.errors import PhysicsError

_TOLERANCE = 1e-6  # of a ratio: what the solver allows itself, and a little more
_PRICED = 1e-7  # of the sum of all prices: what is below is rounding of the solver
#: Part of the least ratio by which it is let go again, or others would be given up for the last digit of it.
GIVES_WAY = 0.01
_WITHIN = 1.0 - 1e-6  # a ratio that is at most 1 whatever the solver rounds
_GAP = 1e-4  # of the mass: between whole shims and the bound of all others
_INFEASIBLE = 2  # as `linprog` calls it
_OUT_OF_REACH = 1e-9  # of its range: a requirement that all masses together change by less


@dataclass(frozen=True, eq=False, kw_only=True)
class Programme:
    """r requirements and c unknowns.

    Parameters
    ----------
    rest : [r], the quantities without the masses; lower, upper : [r], ends of their ranges, below and above 0; SI.
    effect : [r, c], what one unit of each unknown adds.
    unit_kg, least, most : [c]; see `Column`. whole : [c].
    matrix, bound : [n, c] and [n], what else the unknowns must keep, ``matrix u <= bound``.
    margin : part of each range that is left free.
    off : tangents, each [r, c] and [r], to how far each quantity may be off, SI: by one unit of each unknown, and by
        the rest. A requirement must have room for all of them.
    """

    rest: FloatArray
    lower: FloatArray
    upper: FloatArray
    effect: FloatArray
    unit_kg: FloatArray
    least: FloatArray
    most: FloatArray
    whole: BoolArray
    matrix: FloatArray
    bound: FloatArray
    margin: float = 0.0
    off: tuple[tuple[FloatArray, FloatArray], ...] = ()

    def ratios(self, units: FloatArray, off: FloatArray | float = 0.0) -> FloatArray:
        """[r], values over the ends of their ranges, of those that may be `off` [r] so much on the worse side."""
        value = self.rest + self.effect @ units
        return np.asarray(np.maximum((value + off) / self.upper, (value - off) / self.lower))

    @property
    def met(self) -> float:
        """The largest ratio of what is met with the margin; without one, of what is met whatever the solver rounds."""
        return min(1.0 - self.margin, _WITHIN)

    @property
    def reached(self) -> BoolArray:
        """[r], whether masses change a quantity at all."""
        width = np.minimum(self.upper, -self.lower)
        return np.asarray((np.abs(self.effect) @ self.most) > _OUT_OF_REACH * width)


@dataclass(frozen=True, eq=False, kw_only=True)
class Solution:
    """Numbers of units [c], and what the relaxed programme says of its requirements.

    Parameters
    ----------
    cap : [r], largest ratio that each requirement was allowed: 1 less the margin, and more where it cannot be met.
    blocking : [r], 1 and above where a requirement cannot be met: the place in the order in which they were found, the
        worst first; 0 for those that are met.
    price_kg : [r], by how much the total mass would fall by one unit of ratio more, kg; of the relaxed programme.
    room_kg : [c], the same by one kilogram more than an unknown may have, kg/kg; positive: its box is too small.
    bound_kg : total mass that no solution can be below.
    """

    units: FloatArray
    cap: FloatArray
    blocking: FloatArray
    price_kg: FloatArray
    room_kg: FloatArray
    bound_kg: float

    def mass_kg(self, programme: Programme) -> float:
        """Total mass."""
        return float(programme.unit_kg @ self.units)


@dataclass(frozen=True, eq=False)
class Conflict:
    """The least ratio that requirements can have together, and those that keep each other from less.

    weight : [r], of each of them, with the sum 1: whatever the masses, the sum of the ratios with these weights is at
    least `ratio`, as long as the requirements keep their caps that are `beside` [r] (their prices).
    gain : [c], by how much the ratio would fall by one kilogram more than an unknown may have, 1/kg.
    """

    ratio: float
    weight: FloatArray
    beside: FloatArray
    gain: FloatArray


def least_mass(programme: Programme, cap: FloatArray | None = None) -> Solution | None:
    """The relaxed programme: least total mass with every ratio at most its `cap` [r]; None where that cannot be."""
    caps = np.full(len(programme.rest), programme.met) if cap is None else cap
    matrix, bound, row = _rows(programme, caps)
    found = scipy.optimize.linprog(
        programme.unit_kg,
        A_ub=np.vstack([matrix, programme.matrix]),
        b_ub=np.append(bound, programme.bound),
        bounds=np.column_stack([np.zeros(len(programme.most)), programme.most]),
        method="highs-ds",
    )
    if found.status == _INFEASIBLE:
        return None
    _require_solved(found)
    price = np.zeros(len(programme.rest))
    np.add.at(price, row, -found.ineqlin.marginals[: len(row)])
    return Solution(
        units=np.asarray(found.x),
        cap=caps,
        blocking=np.zeros(len(caps)),
        price_kg=np.where(price > _PRICED * max(price.max(initial=0.0), 1e-30), price, 0.0),
        room_kg=_per_kg(programme, found.upper.marginals),
        bound_kg=float(found.fun),
    )


def least_ratio(programme: Programme, cap: FloatArray, free: BoolArray) -> Conflict:
    """The relaxed programme with the least largest ratio of the requirements `free` [r]; the others keep their `cap`.

    Its dual is why there is no less: weights of the requirements that hold each other.
    """
    matrix, bound, row = _rows(programme, np.where(free, 0.0, cap))
    count = len(programme.most)
    matrix = np.hstack([matrix, np.where(free[row], -1.0, 0.0)[:, None]])
    found = scipy.optimize.linprog(
        np.append(np.zeros(count), 1.0),
        A_ub=np.vstack([matrix, _beside(programme, 1)]),
        b_ub=np.append(bound, programme.bound),
        bounds=[*((0.0, float(m)) for m in programme.most), (0.0, None)],
        method="highs-ds",
    )
    _require_solved(found)
    weight = np.zeros(len(programme.rest))
    np.add.at(weight, row, -found.ineqlin.marginals[: len(row)])
    weight[weight < _PRICED] = 0.0
    gain = _per_kg(programme, found.upper.marginals[:count])
    return Conflict(float(found.x[-1]), np.where(free, weight, 0.0), np.where(free, 0.0, weight), gain)


def balanced(programme: Programme, keep: BoolArray | None = None) -> tuple[Solution, list[Conflict]]:
    """Least total mass that meets every requirement; or the least worst ratios, the worst first.

    Where all cannot be met together, the largest ratio is made as small as it can be. Requirements that hold each other
    there keep it but for a hundredth, and the others are brought as far down in turn, until what is left can be met. Of
    all masses that do so these are the least. Requirements to `keep` [r] are met in any case, where that is known to be
    possible.
    """
    met = programme.met
    cap, blocking = np.full(len(programme.rest), met), np.zeros(len(programme.rest))
    conflicts: list[Conflict] = []
    free = programme.reached if keep is None else programme.reached & ~keep
    found = least_mass(programme, cap)
    while found is None:
        conflict = least_ratio(programme, cap, free)
        if conflict.ratio <= met:  # rounding of the solver: it is at the edge
            cap[free] = min(met * (1.0 + 10.0 * _TOLERANCE), _WITHIN)
            found = least_mass(programme, cap)
            if found is None:
                raise PhysicsError("the programme of the masses is too near to singular to be solved")
            break
        held = free & (conflict.weight > 0.0)
        if not held.any():
            raise PhysicsError("the programme of the masses has no price for what blocks it")
        if not conflicts or conflict.ratio < conflicts[-1].ratio * (1.0 - 1.5 * GIVES_WAY):
            conflicts.append(conflict)  # others are of equal requirements, such as those of two like test masses
        cap[held] = conflict.ratio * (1.0 + GIVES_WAY)
        if conflict.ratio <= _WITHIN:  # without all of its margin, it is still met
            cap[held] = min(cap[held].max(), _WITHIN)
        blocking[held] = len(conflicts)
        free = free & ~held
        found = least_mass(programme, cap)
    return replace(found, blocking=blocking), conflicts


def most_met(programme: Programme, time_limit_s: float) -> BoolArray:
    """[r], the most requirements that can be met together, of those that masses reach; the others are False.

    A mixed-integer programme in which a requirement may be left out, of masses that need not be whole.

    Raises
    ------
    PhysicsError : it was not solved within the time limit.
    """
    cap = np.full(len(programme.rest), programme.met)
    matrix, bound, row = _rows(programme, cap)
    reached = np.flatnonzero(programme.reached)
    count, rows, all_kg = len(programme.most), len(reached), float(programme.unit_kg @ programme.most)
    # Left out, a row has room for whatever the masses may do.
    room = np.maximum(np.maximum(matrix, 0.0) @ programme.most - bound, 0.0)
    leave = np.zeros((len(row), rows))
    leave[np.arange(len(row)), np.searchsorted(reached, row)] = -1.01 * room
    found = solved_quietly(
        scipy.optimize.milp,
        np.append(1e-3 / rows * programme.unit_kg / max(all_kg, 1e-30), np.ones(rows)),
        integrality=np.append(np.zeros(count), np.ones(rows)),
        bounds=scipy.optimize.Bounds(np.zeros(count + rows), np.append(programme.most, np.ones(rows))),
        constraints=scipy.optimize.LinearConstraint(
            np.vstack([np.hstack([matrix, leave]), _beside(programme, rows)]), ub=np.append(bound, programme.bound)
        ),
        options={"time_limit": time_limit_s},
    )
    if found.x is None:
        raise PhysicsError(
            f"which limits can be met together was not found within {time_limit_s:g} s", hint="raise time_limit_s"
        )
    kept = np.zeros(len(programme.rest), dtype=bool)
    kept[reached] = found.x[count:] < 0.5
    return kept


def whole_units(programme: Programme, relaxed: Solution, time_limit_s: float) -> tuple[Solution, float]:
    """Whole shims and steps with the caps of the relaxed solution, and the part of it by which ratios are above one.

    Where whole numbers cannot keep the caps, those give way that cannot be met anyhow, as little as they can; all give
    way where that is not enough. Of all masses with that these are the least.

    Raises
    ------
    PhysicsError : there is no solution within the time limit.
    """
    if not programme.whole.any() and not programme.least.any():
        return relaxed, 0.0
    beyond, cap = 0.0, relaxed.cap
    units, bound = _milp(programme, cap, time_limit_s)
    blocked = relaxed.blocking > 0.0
    for gives_way in [blocked, np.ones_like(blocked)] if blocked.any() else [np.ones_like(blocked)]:
        least = None if units is not None else _least_beyond(programme, relaxed.cap, gives_way, time_limit_s)
        if least is not None:
            beyond = least * (1.0 + 1e-6) + _TOLERANCE
            cap = relaxed.cap * np.where(gives_way, 1.0 + beyond, 1.0)
            units, bound = _milp(programme, cap, time_limit_s)
    if units is None:
        raise PhysicsError(
            f"no whole shims were found within {time_limit_s:g} s",
            hint="give the search more time (time_limit_s), thinner shims, or a box without shims for the last grams",
        )
    bound = bound if beyond else max(bound, relaxed.bound_kg)
    return replace(relaxed, units=units, cap=cap, bound_kg=bound), beyond


def _milp(programme: Programme, cap: FloatArray, time_limit_s: float) -> tuple[FloatArray | None, float]:
    """Least mass in whole units within caps, and its bound; None where there is none."""
    matrix, bound, _ = _rows(programme, cap)
    found = solved_quietly(
        scipy.optimize.milp,
        programme.unit_kg,
        integrality=_integrality(programme),
        bounds=scipy.optimize.Bounds(programme.least, programme.most),
        constraints=scipy.optimize.LinearConstraint(
            np.vstack([matrix, programme.matrix]), ub=np.append(bound, programme.bound)
        ),
        options={"time_limit": time_limit_s, "mip_rel_gap": _GAP},
    )
    if found.x is None:
        return None, 0.0
    units = np.where(programme.whole, np.round(found.x), np.clip(found.x, 0.0, programme.most))
    return np.asarray(units), float(found.mip_dual_bound)


def _least_beyond(programme: Programme, cap: FloatArray, gives_way: BoolArray, time_limit_s: float) -> float | None:
    """The part of their caps by which ratios must be above them for whole units, of those that give way."""
    matrix, bound, row = _rows(programme, cap)
    count = len(programme.most)
    matrix = np.hstack([matrix, np.where(gives_way[row], -cap[row], 0.0)[:, None]])
    found = solved_quietly(
        scipy.optimize.milp,
        np.append(np.zeros(count), 1.0),
        integrality=np.append(_integrality(programme), 0),
        bounds=scipy.optimize.Bounds(np.append(programme.least, 0.0), np.append(programme.most, np.inf)),
        constraints=scipy.optimize.LinearConstraint(
            np.vstack([matrix, _beside(programme, 1)]), ub=np.append(bound, programme.bound)
        ),
        options={"time_limit": time_limit_s, "mip_rel_gap": 1e-4},
    )
    return None if found.x is None else max(float(found.x[-1]), 0.0)


def on_each_other(pairs: Sequence[tuple[int, int]], unknowns: int) -> tuple[FloatArray, FloatArray]:
    """`matrix` and `bound` of pairs of unknowns of which the second may be there only as far as the first is."""
    matrix = np.zeros((len(pairs), unknowns))
    for n, (below, above) in enumerate(pairs):
        matrix[n, above], matrix[n, below] = 1.0, -1.0
    return matrix, np.zeros(len(pairs))


def _integrality(programme: Programme) -> FloatArray:
    """As `milp` has it: 1 whole, 2 either 0 or between its bounds."""
    return np.where(programme.whole, 1, np.where(programme.least > 0.0, 2, 0))


def _rows(programme: Programme, cap: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """Both ends of the ranges of the requirements that masses reach as ``matrix u <= bound``, and which each row is of.

    There is a row for each tangent to how far a quantity may be off.
    """
    used = programme.reached
    row = np.concatenate([np.flatnonzero(used)] * 2)
    end = np.concatenate([programme.upper[used], programme.lower[used]])
    matrix = programme.effect[row] / end[:, None]
    bound = cap[row] - programme.rest[row] / end
    if not programme.off:
        return matrix, bound, row
    return (
        np.concatenate([matrix + by_unit[row] / np.abs(end)[:, None] for by_unit, _ in programme.off]),
        np.concatenate([bound - by_rest[row] / np.abs(end) for _, by_rest in programme.off]),
        np.concatenate([row] * len(programme.off)),
    )


def _beside(programme: Programme, more: int) -> FloatArray:
    """`matrix` of the programme, with no regard to more unknowns behind its own."""
    return np.hstack([programme.matrix, np.zeros((len(programme.matrix), more))])


def _per_kg(programme: Programme, marginals: FloatArray) -> FloatArray:
    """What an unknown could bring by one kilogram more than it may have."""
    has_mass = programme.unit_kg > 0.0
    return np.asarray(np.maximum(-marginals / np.where(has_mass, programme.unit_kg, np.inf), 0.0))


def _require_solved(found: Any) -> None:
    if found.status != 0:
        raise PhysicsError(f"the programme of the masses was not solved: {found.message}")
