"""How much a verdict depends on the order and corner of the temperature's low-pass filter, which are not published."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.noise.propagation import Carriers, OutputNoise, psd_of_fields
from tedm_cli.noise.requirements import Requirement, in_band
from tedm_cli.noise.temperature import ShapedSpectrum

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

    order: FloatArray
    corner_hz: FloatArray
    ratio: FloatArray


def filter_sensitivity(
    noise: OutputNoise, judged: Sequence[tuple[Requirement, int]], safety_factor: float
) -> FilterSensitivity | None:
    """Ratios of (requirement, index of output) pairs `judged` over `ORDERS` and `CORNERS_HZ`; None without a low-pass.

    The frequencies of the noise hold the bands of the requirements.
    """
    temperature, frequency_hz = noise.temperature, noise.frequency_hz
    if not any(isinstance(shape, ShapedSpectrum) for shape in temperature.shapes):
        return None
    carriers = noise.source.carriers  # the filter changes their shapes alone
    ratio = np.empty((len(judged), len(ORDERS), len(CORNERS_HZ)))
    limits = {requirement.name: requirement.amplitude(frequency_hz) for requirement, _ in judged}
    bands = {requirement.name: in_band(requirement, frequency_hz) for requirement, _ in judged}
    wanted = np.array(sorted({o for _, o in judged}), dtype=np.intp)
    for p, order in enumerate(ORDERS):
        for q, corner in enumerate(CORNERS_HZ):
            filtered = Carriers(
                temperature.with_filter(order, corner), carriers.index, carriers.shape, carriers.delay_s
            )
            asd = np.sqrt(psd_of_fields(noise.fields[wanted], filtered.values(frequency_hz)))
            for v, (requirement, o) in enumerate(judged):
                inside = bands[requirement.name]
                amplitude = asd[np.searchsorted(wanted, o), inside]
                ratio[v, p, q] = (safety_factor * amplitude / limits[requirement.name][inside]).max()
    return FilterSensitivity(np.array(ORDERS), np.array(CORNERS_HZ), ratio)
