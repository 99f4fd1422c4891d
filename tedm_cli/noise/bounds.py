"""What any correlation between the thermal areas could do to an output, for given amplitudes.

With signed contributions h_i = g_i A_i of the active areas the power is S = Σ_ij h_i R_ij h_j*. Over all correlation
matrices R it runs from the smallest to the largest square of the vector sum of arrows of lengths |h_i|.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tedm_cli.noise.temperature import TemperatureModel

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Bounds:
    """One-sided PSDs [n_out, F] that enclose the output, each attained by some correlation.

    Parameters
    ----------
    maximum : over all correlations, (Σ|h_i|)².
    maximum_non_negative : over all correlations without a negative entry, p² + n² with the positive and negative sums.
    minimum : over all correlations, max(0, 2 max|h_i| - Σ|h_i|)².
    known_blocks : blocks as the case has them, unknown correlation between them, (Σ_b √S_b)².
    """

    maximum: Array
    maximum_non_negative: Array
    minimum: Array
    known_blocks: Array


def correlation_bounds(
    rows: Array, temperature: TemperatureModel, blocks: Sequence[NDArray[np.intp]], frequency_hz: Array
) -> Bounds:
    """Bounds for outputs with `rows` [n_out, k] over the correlations of the areas that are in a block."""
    shape = (len(rows), len(frequency_hz))
    out = Bounds(np.empty(shape), np.empty(shape), np.empty(shape), np.zeros(shape))
    amplitudes = temperature.amplitudes(frequency_hz)
    active = np.concatenate(blocks)
    for number, row in enumerate(rows):  # one output at a time: [k, F] is the largest array
        h = row[active, None] * amplitudes[active]
        size = np.abs(h)
        total = size.sum(axis=0)
        out.maximum[number] = total**2
        positive, negative = np.maximum(h, 0.0).sum(axis=0), np.minimum(h, 0.0).sum(axis=0)
        out.maximum_non_negative[number] = positive**2 + negative**2
        out.minimum[number] = np.maximum(0.0, 2.0 * size.max(axis=0) - total) ** 2
        out.known_blocks[number] = sum(np.abs(row[index] @ amplitudes[index]) for index in blocks) ** 2
    return out
