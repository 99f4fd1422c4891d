"""Builds drawn from their tolerances: which share of them meets everything; the field of blocks that are moved."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.gravity.compensation import CompensationMass, block_points, graded_cells
from tedm_cli.gravity.field import SelfGravity, self_gravity_by_source
from tedm_cli.gravity.testmass import TestMass

_ORDER = 4  # Gauss points per edge of a cell: what is wrong with the field of a block is in both ends of a difference
_POINTS = 1 << 17  # at once


@dataclass(frozen=True, eq=False)
class Yield:
    """Of so many `draws` these `met` everything, and the 95 % interval of their share by Clopper and Pearson.

    each : [r], the share that meets each requirement. ratio : [3, r], ratios of each that 5, 50 and 95 % stay below.
    error : largest difference from the exact field of those builds that were compared with it, over the range.
    """

    draws: int
    met: int
    low: float
    high: float
    each: FloatArray
    ratio: FloatArray
    error: float


def judged_draws(ratios: FloatArray, error: float) -> Yield:
    """From the ratios [d, r] of all draws."""
    passed: BoolArray = ratios <= 1.0
    met = int(passed.all(axis=1).sum())
    low, high = interval(met, len(ratios))
    quantiles = np.quantile(ratios, [0.05, 0.5, 0.95], axis=0)
    return Yield(len(ratios), met, low, high, passed.mean(axis=0), np.asarray(quantiles), error)


def interval(met: int, draws: int) -> tuple[float, float]:
    """95 % interval of Clopper and Pearson (1934) of a probability."""
    found = scipy.stats.binomtest(met, draws).proportion_ci(0.95, method="exact")
    return float(found.low), float(found.high)


def changes_by_shift(tm: TestMass, block: CompensationMass, shift_m: FloatArray, G: float) -> FloatArray:
    """How the field of a block changes when it is moved, [n, 12] in the order of what is judged at rest, SI.

    Parameters
    ----------
    shift_m : [n, 3], m, basic frame.

    Raises
    ------
    PhysicsError : a shift brings the block into the test mass.
    """
    points, masses = block_points(*graded_cells(tm, block), block, _ORDER)
    at_rest = judged_quantities(self_gravity_by_source(points, masses, tm, G=G)).sum(axis=0)
    found = np.zeros((len(shift_m), 12))
    some = max(1, _POINTS // len(points))
    for start in range(0, len(shift_m), some):
        moved = shift_m[start : start + some, None, :] + points
        field = self_gravity_by_source(moved.reshape(-1, 3), np.tile(masses, len(moved)), tm, G=G)
        found[start : start + some] = judged_quantities(field).reshape(len(moved), -1, 12).sum(axis=1) - at_rest
    return found


@dataclass(frozen=True, eq=False)
class ByShift:
    """The change of n quantities by a shift (m) to the second order: first [3, n] and second [3, 3, n] derivatives."""

    first: FloatArray
    second: FloatArray

    def of(self, shift_m: FloatArray) -> FloatArray:
        """[d, n], by shifts [d, 3]."""
        bent = np.einsum("di,dj,ijn->dn", shift_m, shift_m, self.second, optimize=True)
        return np.asarray(shift_m @ self.first + 0.5 * bent)


def by_shift(tm: TestMass, block: CompensationMass, step_m: float, G: float) -> ByShift:
    """How the field of a block depends on its place, from fields at twelve others that are `step_m` off along axes."""
    pairs = ((0, 1), (0, 2), (1, 2))
    along = [*np.eye(3), *(np.eye(3)[i] + np.eye(3)[j] for i, j in pairs)]
    changes = changes_by_shift(tm, block, step_m * np.concatenate([along, -np.array(along)]), G)
    ahead, behind = changes[:6], changes[6:]
    curve = (ahead + behind) / step_m**2
    second = np.zeros((3, 3, 12))
    for i in range(3):
        second[i, i] = curve[i]
    for k, (i, j) in enumerate(pairs, start=3):
        second[i, j] = second[j, i] = (curve[k] - curve[i] - curve[j]) / 2.0
    return ByShift((ahead - behind)[:3] / (2.0 * step_m), second)


def judged_quantities(field: SelfGravity) -> FloatArray:
    """What can be judged at rest of fields with a leading axis, [n, 12] as `dc_quantities` has them."""
    rows, columns = np.triu_indices(3)
    return np.concatenate([field.gamma_lin[:, rows, columns], field.acceleration, field.angular_acceleration], axis=1)
