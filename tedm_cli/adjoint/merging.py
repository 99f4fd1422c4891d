"""Areas merged two by two, each time the pair that adds least to the error of all outputs and correlation lengths."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from tedm_cli.adjoint.temperature_field import FieldPoints, covariance_blocks
from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.progress import Step, silent

_NO_WORSE = 2.0  # times what one area less leaves: what so many areas may leave


@dataclass(frozen=True, eq=False, kw_only=True)
class AreaCovariance:
    """Covariances of L fields of correlation lengths by k areas, and by r outputs.

    volume : [k], m³. sensitivity : [r, k], sums over the areas.
    areas : [L, k, k], of the means of the field over them, weighted by volume: C_A.
    outputs : [L, r, k], of these means with the outputs of the field. exact : [L, r], variance of these outputs.
    """

    volume: FloatArray
    sensitivity: FloatArray
    areas: FloatArray
    outputs: FloatArray
    exact: FloatArray


def area_covariance(
    points: FieldPoints, area: IntArray, length_m: Sequence[float], step: Step = silent
) -> AreaCovariance:
    """Covariances by areas, `area` [n] numbers from 0 on; the sums over pairs of points are made block by block."""
    n, volume = len(area), np.bincount(area, points.volume).astype(np.float64)
    k, s = len(volume), points.sensitivity
    mean = csr_array((points.volume / volume[area], area, np.arange(n + 1)), shape=(n, k))
    c_areas, product = np.zeros((len(length_m), k, k)), np.zeros((len(length_m), *s.shape))
    for start, stop, number, c in covariance_blocks(points.position, length_m, step):
        here, own = mean[start:stop], c[:, : stop - start]
        c_areas[number] += here.T @ (own @ here)
        product[number, :, start:] += s[:, start:stop] @ c
        if stop < n:
            beyond = here.T @ (c[:, stop - start :] @ mean[stop:])
            c_areas[number] += beyond + beyond.T
            product[number, :, start:stop] += s[:, stop:] @ c[:, stop - start :].T
    return AreaCovariance(
        volume=volume,
        sensitivity=np.array([np.bincount(area, row, k) for row in s]),
        areas=c_areas,
        outputs=np.array([rows @ mean for rows in product]),
        exact=np.einsum("rn,lrn->lr", s, product),
    )


@dataclass(frozen=True, eq=False)
class Merged:
    """From k areas to the fewest, one merge after the other.

    merges : [k - fewest, 2]; the second of a pair takes the number of the first.
    ratio : [k - fewest + 1, L, r], standard deviation of each output by the areas over that of the field.
    instead : by count, the last merge of this count alone: with that in `merges` an area would lack its mirror image.
        Where that is far worse than one area less, the count is not whole.
    whole : [k - fewest + 1], where every area that has to have a mirror image has it.
    """

    k: int
    merges: IntArray
    ratio: FloatArray
    whole: BoolArray
    instead: Mapping[int, tuple[int, int]] = field(default_factory=dict)

    @property
    def fewest(self) -> int:
        """Areas that are left when no two may be merged."""
        return self.k - len(self.merges)

    @property
    def error(self) -> FloatArray:
        """|ratio - 1| of the worst output and length, by count from `fewest` to k."""
        return np.asarray(np.abs(self.ratio - 1.0).max(axis=(1, 2))[::-1])

    def ratio_at(self, count: int) -> FloatArray:
        """[L, r] of so many areas."""
        return np.asarray(self.ratio[self.k - count])

    def nearest(self, count: int) -> int:
        """The count, or the one below it where areas of this one lack a mirror image."""
        return count if self.whole[self.k - count] else count - 1

    def areas(self, count: int) -> IntArray:
        """Number [k] from 0 on, among `count` areas, of each that there was first."""
        owner, merges = np.arange(self.k), self.merges[: self.k - count].tolist()
        for first, second in [*merges[:-1], self.instead[count]] if count in self.instead else merges:
            owner[owner == second] = first
        return np.asarray(np.unique(owner, return_inverse=True)[1], dtype=np.int64)

    def count_within(self, error: float) -> int | None:
        """The fewest areas from which on the error stays within `error`; None where that of all k is more."""
        over = np.flatnonzero(self.error > error)
        first = self.fewest if not over.size else self.fewest + int(over[-1]) + 1
        while first <= self.k and not self.whole[self.k - first]:
            first += 1
        return first if first <= self.k else None


def merge_areas(of: AreaCovariance, pairs: IntArray, twin: IntArray | None = None, step: Step = silent) -> Merged:
    """Merge areas until no pair is left.

    With δ what the areas leave out of an output, a merge of a and b adds u to the model's sensitivity, whose sum over
    b is θ = (S_a V_b - S_b V_a)/(V_a + V_b) and over a is -θ. It adds θ² var(T_b - T_a) - 2θ cov(T_b - T_a, δ) to the
    variance of δ. The pair is merged that makes the sum over outputs and lengths of (var δ / var y)² least: squares of
    variances, so that no output pays for the others.

    Parameters
    ----------
    pairs : [p, 2], which of the k areas may be merged; what is merged has the neighbours of both. With those of areas
        that have mirror images are those of the images.
    twin : [k], the mirror image of each area, -1 of areas that need none; what is merged on one side is merged on the
        other as well. None: no area needs one.
    """
    state = _State(of, np.full(len(of.volume), -1) if twin is None else twin.copy())
    k = len(of.volume)
    keys, waiting, other = _keys(pairs, k), -1, None
    ratio, whole, instead = [state.ratio], [True], dict[int, tuple[int, int]]()
    while len(keys):
        step(len(state.merges), k, "merging areas")
        at = int(np.searchsorted(keys, waiting)) if waiting >= 0 else state.best(keys)
        one, two = (int(i) for i in np.divmod(keys[at], k))
        image = (-1, -1)
        if waiting < 0:
            other = state.alone(keys) if state.twin[one] >= 0 else None
            image = state.image(one, two)
        state.merge(one, two)
        a, b = np.divmod(keys, k)
        keys = _keys(np.column_stack([np.where(a == two, one, a), np.where(b == two, one, b)]), k)
        first, second = (one if i == two else i for i in image)
        if waiting >= 0 and other is not None and other.cost < _NO_WORSE * state.cost:
            instead[k - len(state.merges) + 1] = other.pair
            ratio[-1], whole[-1] = other.ratio, True
        waiting = min(first, second) * k + max(first, second) if first != second else -1
        ratio.append(state.ratio)
        whole.append(waiting < 0)
    step(k, k, "merging areas")
    merges = np.array(state.merges, dtype=np.int64).reshape(-1, 2)
    return Merged(k, merges, np.array(ratio), np.array(whole), instead)


class _Alone(NamedTuple):
    """A merge of two areas that need no images: what it costs, and the ratios that it leaves."""

    pair: tuple[int, int]
    cost: float
    ratio: FloatArray


class _State:
    """Covariances of the areas that there are at a time, by the numbers of the first of those that they are of."""

    def __init__(self, of: AreaCovariance, twin: IntArray) -> None:
        self.c, self.volume, self.s = of.areas.copy(), of.volume.copy(), of.sensitivity.copy()
        self.exact, self.twin, self.k = of.exact, twin, len(of.volume)
        self.by_model = np.einsum("lab,rb->lra", self.c, self.s)  # covariance of the means with the model's outputs
        self.left = of.outputs - self.by_model  # and with what the model leaves out
        self.variance = np.einsum("lra,ra->lr", self.by_model, self.s)
        both = np.einsum("lra,ra->lr", of.outputs, self.s)
        self.error = (of.exact + self.variance - 2.0 * both) / of.exact
        self.merges: list[tuple[int, int]] = []

    @property
    def ratio(self) -> FloatArray:
        """[L, r], of standard deviations."""
        return self._ratio(self.variance)

    def _ratio(self, variance: FloatArray) -> FloatArray:
        return np.asarray(np.sqrt(np.maximum(variance, 0.0) / self.exact))

    def image(self, one: int, two: int) -> tuple[int, int]:
        """The images of two areas, or twice -1; and what is merged of the two has what is merged of these."""
        first, second = int(self.twin[one]), int(self.twin[two])
        if first < 0:
            return -1, -1
        low = min(first, second)
        if len({one, two, first, second}) < 4:  # across the plane: all of them are one in the end
            low = min(one, two, first, second)
            self.twin[low] = low
        else:
            self.twin[one], self.twin[low] = low, one
        return first, second

    @property
    def cost(self) -> float:
        """What is made least."""
        return float((self.error**2).sum())

    def alone(self, keys: IntArray) -> _Alone | None:
        """Of the pairs that have no image the one that costs least; None without any."""
        a, b = np.divmod(keys, self.k)
        free = self.twin[a] < 0
        if not free.any():
            return None
        theta, more, apart = self._added(a[free], b[free])
        cost = ((self.error[:, :, None] + more) ** 2).sum(axis=(0, 1))
        at = int(cost.argmin())
        one, two = int(a[free][at]), int(b[free][at])
        ratio = self._ratio(self.variance + self._change(one, two, theta[:, at], apart[:, at]))
        return _Alone((one, two), float(cost[at]), ratio)

    def best(self, keys: IntArray) -> int:
        """Place of the pair that costs least, with its image."""
        a, b = np.divmod(keys, self.k)
        more = self._added(a, b)[1]
        cost = ((self.error[:, :, None] + more) ** 2).sum(axis=(0, 1)) - self.cost
        paired = self.twin[a] >= 0
        if paired.any():
            first, second = self.twin[a[paired]], self.twin[b[paired]]
            image = np.minimum(first, second) * self.k + np.maximum(first, second)
            at = np.searchsorted(keys, image)
            cost[paired] += np.where(image == keys[paired], 0.0, cost[at])
        return int(cost.argmin())

    def _added(self, a: IntArray, b: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """θ [r, p], what merging adds to the variances of δ over those of the outputs [L, r, p], var(T_b - T_a)."""
        volume, s, c = self.volume, self.s, self.c
        theta = (s[:, a] * volume[b] - s[:, b] * volume[a]) / (volume[a] + volume[b])
        apart = c[:, a, a] + c[:, b, b] - 2.0 * c[:, a, b]
        more = theta**2 * apart[:, None] - 2.0 * theta * (self.left[:, :, b] - self.left[:, :, a])
        return theta, more / self.exact[:, :, None], apart

    def _change(self, one: int, two: int, theta: FloatArray, apart: FloatArray) -> FloatArray:
        """What merging two areas adds to the variances of the model [L, r]."""
        between = self.by_model[:, :, two] - self.by_model[:, :, one]
        return np.asarray(theta**2 * apart[:, None] + 2.0 * theta * between)

    def merge(self, one: int, two: int) -> None:
        """Merge the second into the first."""
        theta, more, apart = self._added(np.array([one]), np.array([two]))
        by, means = theta[:, 0], (self.by_model, self.left)
        self.error = self.error + more[:, :, 0]
        self.variance = self.variance + by**2 * apart + 2.0 * by * (self.by_model[:, :, two] - self.by_model[:, :, one])
        change = by[:, None] * (self.c[:, two] - self.c[:, one])[:, None]
        self.by_model += change
        self.left -= change
        total = self.volume[one] + self.volume[two]
        first, second = self.volume[one] / total, self.volume[two] / total
        self.c[:, one] = first * self.c[:, one] + second * self.c[:, two]
        self.c[:, :, one] = first * self.c[:, :, one] + second * self.c[:, :, two]
        for mean in means:
            mean[:, :, one] = first * mean[:, :, one] + second * mean[:, :, two]
        self.volume[one] = total
        self.s[:, one] += self.s[:, two]
        self.merges.append((one, two))


def _keys(pairs: IntArray, k: int) -> IntArray:
    """Pairs of different areas, each once, as first * k + second."""
    low, high = pairs.min(axis=1, initial=k), pairs.max(axis=1, initial=0)
    return np.asarray(np.unique((low * k + high)[low < high]))
