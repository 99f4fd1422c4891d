"""A temperature field that decorrelates with distance, and what a model of areas makes of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.distance import cdist

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.progress import Step, silent

_BLOCK = 512  # rows of the covariance at a time


@dataclass(frozen=True, eq=False, kw_only=True)
class FieldPoints:
    """n points of a temperature field, and what r outputs make of it: y = Σ s_n T_n.

    position : [n, 3], m. volume : [n], m³, above 0: the mean of the field over an area is weighted by it.
    sensitivity : [r, n], s, times the amplitude of the field where that differs from place to place.
    """

    position: FloatArray
    volume: FloatArray
    sensitivity: FloatArray

    def only(self, mask: BoolArray) -> FieldPoints:
        """The points of the mask [n]."""
        return FieldPoints(
            position=self.position[mask], volume=self.volume[mask], sensitivity=self.sensitivity[:, mask]
        )

    def of_areas(self, area: IntArray) -> FloatArray:
        """Sensitivity [r, n] of a model in which every point has the mean temperature of its area.

        An area acts by the sum of s over its points, and its mean weights them by volume: so s per volume becomes its
        mean over the area. Where it is even in each area already, the model is exact for any field.

        Parameters
        ----------
        area : [n], numbers from 0 on of the points' areas.
        """
        of_area = np.array([np.bincount(area, row) for row in self.sensitivity]) / np.bincount(area, self.volume)
        return np.asarray(of_area[:, area] * self.volume)


def covariance_blocks(
    position: FloatArray, length_m: Sequence[float], step: Step = silent, block: int = _BLOCK
) -> Iterator[tuple[int, int, int, FloatArray]]:
    """The upper half of C = exp(-d/ℓ) in blocks of rows, so that it is never there as a whole.

    Parameters
    ----------
    position : [n, 3], m. length_m : [L], correlation lengths ℓ; distances are found once for all of them.

    Yields
    ------
    start, stop, number of the length, and C[start:stop, start:] of it, whose memory the next one takes.
    """
    n = len(position)
    for start in range(0, n, block):
        step(start, n, "covariance of the field")
        stop = min(start + block, n)
        distance = cdist(position[start:stop], position[start:])
        found = np.empty_like(distance)
        for number, length in enumerate(length_m):
            np.multiply(distance, -1.0 / length, out=found)
            np.exp(found, out=found)
            yield start, stop, number, found
    step(n, n, "covariance of the field")


def field_products(
    position: FloatArray, rows: FloatArray, length_m: Sequence[float], step: Step = silent
) -> FloatArray:
    """Covariance of the field at every point with what the rows make of it, C x, [L, c, n].

    Parameters
    ----------
    position : [n, 3], m. rows : [c, n], x. length_m : [L], correlation lengths of a field of variance 1.
    """
    out = np.zeros((len(length_m), *rows.shape))
    for start, stop, number, c in covariance_blocks(position, length_m, step):
        out[number, :, start:] += rows[:, start:stop] @ c
        out[number, :, start:stop] += rows[:, stop:] @ c[:, stop - start :].T
    return out


@dataclass(frozen=True, eq=False)
class AreaError:
    """How a model of k areas tells r outputs of fields of L correlation lengths.

    exact : [L, r], standard deviation of the outputs of the field.
    ratio : [L, r], standard deviation by the areas over that of the field; 1 where ℓ is long.
    difference : [L, r], standard deviation of what the areas leave out, over that of the output.
    share : [L, r, k], of the areas in the variance of that; it sums to 1 (NaN where nothing is left out).
    """

    exact: FloatArray
    ratio: FloatArray
    difference: FloatArray
    share: FloatArray


def area_error(points: FieldPoints, area: IntArray, length_m: Sequence[float], step: Step = silent) -> AreaError:
    """Error of a model of areas, for fields of covariance exp(-d/ℓ).

    Parameters
    ----------
    points : whose outputs all follow something. area : [n], numbers from 0 on of the points' areas.
    """
    exact, model = points.sensitivity, points.of_areas(area)
    left = exact - model
    products = field_products(points.position, np.concatenate([exact, model]), length_m, step)
    r = len(exact)
    of_exact, of_model = (
        np.einsum("rn,lrn->lr", rows, products[:, part]) for rows, part in ((exact, slice(r)), (model, slice(r, 2 * r)))
    )
    terms = left * (products[:, :r] - products[:, r:])
    of_area = np.array([[np.bincount(area, row) for row in rows] for rows in terms])
    of_left = np.maximum(of_area.sum(axis=2), 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = of_area / of_left[:, :, None]
    return AreaError(np.sqrt(of_exact), np.sqrt(of_model / of_exact), np.sqrt(of_left / of_exact), share)
