"""What was measured in flight, for orders of magnitude in projects of that mission; nothing is judged by it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class FlightResult:
    """An amplitude spectral density that was measured.

    Parameters
    ----------
    quantity : a key of `UNITS`; amplitude : in its unit per √Hz; band_hz : where it was found.
    mission, source : who found it; meaning : of what.
    """

    quantity: str
    amplitude: float
    band_hz: tuple[float, float]
    mission: str
    meaning: str
    source: str


_OF_MISSION = "lpf_"  # with which the names of LISA Pathfinder's requirements begin
_FIRST = "Armano et al. 2016, Phys. Rev. Lett. 116, 231101"
_BOTH, _SENSOR = "the two test masses against each other", "residual noise of the interferometer"
FLIGHT_RESULTS = (
    FlightResult("acceleration", 5.2e-15, (0.7e-3, 20e-3), "LISA Pathfinder", _BOTH, _FIRST),
    FlightResult("displacement", 34.8e-15, (60e-3, math.inf), "LISA Pathfinder", _SENSOR, _FIRST),
    FlightResult(
        "displacement",
        32.0e-15,
        (200e-3, math.inf),
        "LISA Pathfinder",
        _SENSOR,
        "Armano et al. 2021, Phys. Rev. Lett. 126, 131103",
    ),
)


def flight_results(
    quantity: str, low_hz: float, high_hz: float, requirements: Iterable[str]
) -> list[tuple[FlightResult, tuple[float, float]]]:
    """Results on one quantity of which some part lies within a range of frequencies, each with that part.

    `requirements`: names of those that judge; without any of LISA Pathfinder its results say nothing of the project.
    """
    overlapping: list[tuple[FlightResult, tuple[float, float]]] = []
    if not any(name.startswith(_OF_MISSION) for name in requirements):
        return overlapping
    for result in FLIGHT_RESULTS:
        low, high = max(low_hz, result.band_hz[0]), min(high_hz, result.band_hz[1])
        if result.quantity == quantity and low < high:
            overlapping.append((result, (low, high)))
    return overlapping
