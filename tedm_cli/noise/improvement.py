"""What would bring a verdict down: quieter areas, and the temperature stability that each group would need."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tedm_cli.noise.correlation import Correlation
from tedm_cli.noise.propagation import Carriers, psd_of_fields
from tedm_cli.noise.temperature import TemperatureModel

Array = NDArray[np.float64]

COUNTS = (0, 1, 2, 3, 5, 10)
QUIETER = 10.0  # factor on amplitudes of areas made quieter


@dataclass(frozen=True, eq=False)
class Improvement:
    """How the ratio of one verdict would change.

    Parameters
    ----------
    worst : [10], areas in the order of greatest relief at the binding frequency, each after those before it were
        silenced; -1 where no further area brings relief.
    silenced, quieter : [6], ratio with the first `COUNTS` of them without noise, and with a `QUIETER`-th of it.
    group_factor : [G], the factor on the temperature amplitudes of each group, the others unchanged, that would just
        meet the requirement: how much quieter it must be (< 1) or how much noisier it may be (> 1, infinite where the
        output does not feel it); NaN where this group alone cannot do it.
    """

    worst: NDArray[np.intp]
    silenced: Array
    quieter: Array
    group_factor: Array


def improvement(
    row: Array,
    temperature: TemperatureModel,
    correlation: Correlation,
    frequency_hz: Array,
    binding: int,
    limit: Array,
    groups: Sequence[NDArray[np.bool_]],
) -> Improvement:
    """Improvements of an output with the sensitivities `row` [k] against a limit.

    Parameters
    ----------
    frequency_hz, limit : [F], the frequencies of the band, and the limit over the safety factor there.
    binding : index of the binding frequency.
    groups : masks [k].
    """
    carriers = Carriers.of(temperature, correlation.delay_s)
    values = carriers.values(frequency_hz)
    terms = (row * temperature.scale * values[carriers.index, binding])[:, None] * correlation.factor
    worst = _worst(terms, COUNTS[-1])

    def ratios(scale: float) -> Array:
        rows = np.tile(row, (len(COUNTS), 1))
        for n, count in enumerate(COUNTS):
            rows[n, worst[:count]] *= scale
        return _ratios(carriers.rows(rows, correlation.factor), values, limit)

    parts = np.array([part for mask in groups for part in (np.where(mask, row, 0.0), np.where(mask, 0.0, row))])
    fields = carriers.rows(parts, correlation.factor)
    # Sums of squares over the m components are kept by the triangular factor of [m, 2 G c].
    number, c, m = fields.shape
    triangle = np.asarray(np.linalg.qr(fields.reshape(number * c, m).T, mode="r"))
    fields = triangle.T.reshape(number, c, -1)
    return Improvement(
        worst=np.pad(worst, (0, COUNTS[-1] - len(worst)), constant_values=-1),
        silenced=ratios(0.0),
        quieter=ratios(1.0 / QUIETER),
        group_factor=np.array(
            [_group_factor(fields[2 * g], fields[2 * g + 1], values, limit) for g in range(len(groups))]
        ),
    )


def _ratios(fields: NDArray[Any], values: NDArray[Any], limit: Array) -> Array:
    ratio: Array = (np.sqrt(psd_of_fields(fields, values)) / limit).max(axis=1)
    return ratio


def _worst(terms: NDArray[Any], most: int) -> NDArray[np.intp]:
    """Areas whose silence lowers |Σ_i terms_i|² most, one after the other, of `terms` [k, m]."""
    total = terms.sum(axis=0)
    own = np.sum(np.abs(terms) ** 2, axis=1)
    least = 1e-12 * float(np.sum(np.abs(total) ** 2))  # rounding brings no relief
    chosen: list[int] = []
    for _ in range(min(most, len(terms))):
        relief = 2.0 * np.real(terms @ total.conj()) - own  # |total|² - |total - terms_i|²
        relief[chosen] = 0.0
        best = int(relief.argmax())
        if relief[best] <= least:
            break
        chosen.append(best)
        total = total - terms[best]
    return np.array(chosen, dtype=np.intp)


def _group_factor(group: NDArray[Any], rest: NDArray[Any], values: NDArray[Any], limit: Array) -> float:
    """Factor s at which |s y_group + y_rest| just meets the limit, for their fields [c, m]; NaN for none."""
    own, others = group.T @ values, rest.T @ values

    def power(y: NDArray[Any]) -> Array:
        return np.asarray(np.sum(y.real**2 + y.imag**2, axis=0))

    # s² a + 2 s b + c <= limit² at every frequency: one interval each, their intersection is what is possible.
    a, b, c = power(own), np.sum(own.real * others.real + own.imag * others.imag, axis=0), power(others) - limit**2
    felt = a > 0.0
    if np.any(~felt & (c > 0.0)) or np.any(felt & (b**2 < a * c)):
        return np.nan
    root = np.sqrt(b[felt] ** 2 - a[felt] * c[felt])
    low = float(np.max((-b[felt] - root) / a[felt], initial=0.0))
    high = float(np.min((-b[felt] + root) / a[felt], initial=np.inf))
    failing = bool(np.any(a + 2.0 * b + c > 0.0))
    # Noisier until others are cancelled is no requirement on a stability.
    return np.nan if high < low or (failing and low > 1.0) else high
