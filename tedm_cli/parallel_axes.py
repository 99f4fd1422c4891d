"""Whether axes of two test masses point the same way: along others their difference is of no meaning."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray

PARALLEL_RAD = 1e-3  # axes that are mounted this far apart measure along one direction, as any hardware does


@dataclass(frozen=True, eq=False)
class MassAxis:
    """One axis of a test mass: `letter` x, y or z, and the vector [3] along it, in the frame of all that it meets."""

    test_mass: str
    letter: str
    along: FloatArray


def apart_rad(first: FloatArray, second: FloatArray) -> float:
    """Angle between two vectors [3], from 0 to π; exact for small ones."""
    return float(np.arctan2(np.linalg.norm(np.cross(first, second)), first @ second))


def why_no_difference(first: MassAxis, second: MassAxis, most_rad: float = PARALLEL_RAD) -> str:
    """Why what is told along these two axes has no difference; empty where they are at most `most_rad` apart."""
    angle = apart_rad(first.along, second.along)
    if angle <= most_rad:
        return ""
    one, two = first.test_mass, second.test_mass
    axes = f"the {first.letter} axes of {one} and {two}"
    if first.letter != second.letter:
        axes = f"the {first.letter} axis of {one} and the {second.letter} axis of {two}"
    return f"{axes} are not parallel ({np.degrees(angle):.4g} deg apart), so their difference is of no meaning"
