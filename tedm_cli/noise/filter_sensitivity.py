"""How far a verdict hangs on the order and corner of the temperature's low-pass filter, which nobody published."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tedm_cli.noise.propagation import output_psd_from_factor
from tedm_cli.noise.requirements import Requirement, judge
from tedm_cli.noise.temperature import ShapedSpectrum, TemperatureModel

Array = NDArray[np.float64]

ORDERS = (1.0, 2.0, 3.0, 4.0)
CORNERS_HZ = (0.3e-3, 1e-3, 3e-3, 10e-3)


@dataclass(frozen=True, eq=False)
class FilterSensitivity:
    """Worst ratios to the requirements, levels at the reference frequency held.

    Parameters
    ----------
    order : [p].
    corner_hz : [q].
    ratio : [verdicts, p, q], safety factor included.
    """

    order: Array
    corner_hz: Array
    ratio: Array


def filter_sensitivity(
    rows: Array,
    kinds: Sequence[str],
    temperature: TemperatureModel,
    factor: NDArray[Any],
    frequency_hz: Array,
    judged: Sequence[tuple[Requirement, int]],
    safety_factor: float,
) -> FilterSensitivity | None:
    """Ratios of (requirement, index of output) pairs `judged` over `ORDERS` and `CORNERS_HZ`; None without a low-pass.

    Parameters as in `output_psd_from_factor`, `kinds` [n_out] as in `judge`; raises as `judge` does.
    """
    if not any(isinstance(shape, ShapedSpectrum) for shape in temperature.shapes):
        return None
    ratio = np.empty((len(judged), len(ORDERS), len(CORNERS_HZ)))
    for p, order in enumerate(ORDERS):
        for q, corner in enumerate(CORNERS_HZ):
            psd = output_psd_from_factor(rows, temperature.with_filter(order, corner), factor, frequency_hz)
            for v, (requirement, o) in enumerate(judged):
                verdict = judge(np.sqrt(psd[o]), frequency_hz, requirement, safety_factor, kind=kinds[o])
                ratio[v, p, q] = verdict.ratio
    return FilterSensitivity(np.array(ORDERS), np.array(CORNERS_HZ), ratio)
