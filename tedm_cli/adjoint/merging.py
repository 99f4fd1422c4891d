"""Areas merged two by two, each time the pair that adds least to the error of all outputs and correlation lengths."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from tedm_cli.adjoint.temperature_field import FieldPoints, covariance_blocks
from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.progress import Step, silent


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
    """

    k: int
    merges: IntArray
    ratio: FloatArray

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

    def areas(self, count: int) -> IntArray:
        """Number [k] from 0 on, among `count` areas, of each that there was first."""
        owner = np.arange(self.k)
        for first, second in self.merges[: self.k - count]:
            owner[owner == second] = first
        return np.asarray(np.unique(owner, return_inverse=True)[1], dtype=np.int64)

    def count_within(self, error: float) -> int | None:
        """The fewest areas from which on the error stays within `error`; None where that of all k is more."""
        over = np.flatnonzero(self.error > error)
        first = self.fewest if not over.size else self.fewest + int(over[-1]) + 1
        return first if first <= self.k else None


def merge_areas(of: AreaCovariance, pairs: IntArray, step: Step = silent) -> Merged:
    """Merge areas until no pair is left.

    With δ what the areas leave out of an output, a merge of a and b adds u to the model's sensitivity, whose sum over
    b is θ = (S_a V_b - S_b V_a)/(V_a + V_b) and over a is -θ. It adds θ² var(T_b - T_a) - 2θ cov(T_b - T_a, δ) to the
    variance of δ. The pair is merged that makes the sum over outputs and lengths of (var δ / var y)² least: squares of
    variances, so that no output pays for the others.

    Parameters
    ----------
    pairs : [p, 2], which of the k areas may be merged; what is merged has the neighbours of both.
    """
    c, volume, s = of.areas.copy(), of.volume.copy(), of.sensitivity.copy()
    k, exact = len(volume), of.exact
    by_model = np.einsum("lab,rb->lra", c, s)  # covariance of the means with the model's outputs
    left = of.outputs - by_model  # and with what the model leaves out
    variance = np.einsum("lra,ra->lr", by_model, s)
    error = (exact + variance - 2.0 * np.einsum("lra,ra->lr", of.outputs, s)) / exact
    keys = _keys(pairs, k)
    merges: list[tuple[int, int]] = []
    ratio = [np.sqrt(variance / exact)]
    while len(keys):
        step(len(merges), k, "merging areas")
        a, b = np.divmod(keys, k)
        theta = (s[:, a] * volume[b] - s[:, b] * volume[a]) / (volume[a] + volume[b])
        apart = c[:, a, a] + c[:, b, b] - 2.0 * c[:, a, b]
        more = theta**2 * apart[:, None] - 2.0 * theta * (left[:, :, b] - left[:, :, a])
        more /= exact[:, :, None]
        at = int(((error[:, :, None] + more) ** 2).sum(axis=(0, 1)).argmin())
        one, two, by = int(a[at]), int(b[at]), theta[:, at]
        error = error + more[:, :, at]
        variance = variance + by**2 * apart[:, at, None] + 2.0 * by * (by_model[:, :, two] - by_model[:, :, one])
        change = by[:, None] * (c[:, two] - c[:, one])[:, None]
        by_model += change
        left -= change
        total = volume[one] + volume[two]
        first, second = volume[one] / total, volume[two] / total
        c[:, one] = first * c[:, one] + second * c[:, two]
        c[:, :, one] = first * c[:, :, one] + second * c[:, :, two]
        for means in (by_model, left):
            means[:, :, one] = first * means[:, :, one] + second * means[:, :, two]
        volume[one] = total
        s[:, one] += s[:, two]
        keys = _keys(np.column_stack([np.where(a == two, one, a), np.where(b == two, one, b)]), k)
        merges.append((one, two))
        ratio.append(np.sqrt(np.maximum(variance, 0.0) / exact))
    step(k, k, "merging areas")
    return Merged(k, np.array(merges, dtype=np.int64).reshape(-1, 2), np.array(ratio))


def _keys(pairs: IntArray, k: int) -> IntArray:
    """Pairs of different areas, each once, as first * k + second."""
    low, high = pairs.min(axis=1, initial=k), pairs.max(axis=1, initial=0)
    return np.asarray(np.unique((low * k + high)[low < high]))
