"""The optical layout against the model's configuration: the same test masses in both, at the same places."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.optics.layout import Element, OpticalLayout
from tedm_cli.optics.matrix_checks import LARGEST_SKEW_RAD

LARGEST_GAP_M = 1e-4
"""Distance of centres, and difference of faces, above which two files describe two test masses."""

LARGEST_ANGLE_RAD = LARGEST_SKEW_RAD
"""Angle between a face of the layout and one of the model above which they are two faces."""

ROUNDING_M, ROUNDING_RAD = 1e-6, 1e-6
"""What numbers of a drawing in millimetres are rounded by: nothing is said below."""


@dataclass
class Differences:
    """Problems as (dotted path in the layout, fact), what is odd but no mistake, and names of what was compared."""

    problems: list[tuple[str, str]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    compared: list[str] = field(default_factory=list)

    def add(self, at: str, fact: str, value: float, limits: tuple[float, float]) -> None:
        """Refused above the second of `limits`, spoken of above the first."""
        if value > limits[1]:
            self.problems.append((at, fact))
        elif value > limits[0]:
            self.notes.append(f"{at}: {fact}")


def compare_test_masses(layout: OpticalLayout, test_masses: list[TestMass], name: str) -> Differences:
    """Compare names, centres, axes and faces of the test masses of a layout with the model's configuration `name`.

    Nothing is compared where either has none: it is half of a project.
    """
    found = Differences()
    ours, theirs = {e.name: e for e in layout.test_masses}, {t.name: t for t in test_masses}
    if not ours or not theirs:
        return found
    lacking = [n for n in ours if n not in theirs]
    unmeasured = [n for n in theirs if n not in ours]
    for n in lacking:
        at = f"element[{layout.index(n)}].name"
        fact = f"{name} has no test mass {n}; it has {', '.join(theirs)}"
        if unmeasured:  # of either file one that the other lacks: they are meant to be one
            found.problems.append((at, fact + _near(layout, ours[n], [theirs[u] for u in unmeasured])))
        else:
            found.notes.append(f"{at}: {fact}; {n} has read-outs here, but no self-gravity")
    if unmeasured and not lacking:
        found.notes.append(
            f"element: {', '.join(unmeasured)} of {name} is not here; it has self-gravity, but no read-out"
        )
    for n, element in ours.items():
        if n in theirs:
            found.compared.append(n)
            _compare(layout, element, theirs[n], test_masses.index(theirs[n]), name, found)
    return found


def _compare(layout: OpticalLayout, e: Element, tm: TestMass, number: int, name: str, found: Differences) -> None:
    at, there = f"element[{layout.index(e.name)}]", f"test_mass[{number}]"
    centre = _centre(layout, e)
    gap = float(np.linalg.norm(centre - tm.position_m))
    found.add(
        f"{at}.ref_m",
        f"{e.name} is at {_point(centre)} m of the basic frame, by {name} ({there}.position_m) at"
        f" {_point(tm.position_m)} m: {_length(gap)} apart",
        gap,
        (ROUNDING_M, LARGEST_GAP_M),
    )
    axes = layout.test_mass_axes_basic[layout.test_masses.index(e)]
    turn = float(scipy.spatial.transform.Rotation.from_matrix(axes @ tm.axes.T).magnitude())
    found.add(
        f"{at}.axes",
        f"x, y, z of {e.name} are along {_points(axes)} of the basic frame, by {name} ({there}.axes) along"
        f" {_points(tm.axes)}: {_angle(turn)} apart",
        turn,
        (ROUNDING_RAD, LARGEST_ANGLE_RAD),
    )
    normal = np.array(e.normal) @ layout.axes
    if not np.any(normal):  # a layout of which only the matrices are known
        return
    along = tm.axes @ normal
    k = int(np.abs(along).argmax())
    angle = float(np.arctan2(np.linalg.norm(np.delete(along, k)), abs(along[k])))
    found.add(
        f"{at}.normal",
        f"the face of {e.name} looks along {_point(normal)} of the basic frame, {_angle(angle)} off the nearest axis by"
        f" {name} ({there}.axes), {'xyz'[k]}: {_point(np.sign(along[k]) * tm.axes[k])}",
        angle,
        (ROUNDING_RAD, LARGEST_ANGLE_RAD),
    )
    if e.front_offset_m == 0.0 and not layout.has_geometry:
        return
    half = float(tm.body.high_m[k] if along[k] > 0.0 else -tm.body.low_m[k])  # of its edge, if it is a cuboid
    off = abs(e.front_offset_m - half)
    found.add(
        f"{at}.front_offset_m",
        f"the face of {e.name} is {e.front_offset_m:.9g} m from its centre; half of its edge along {'xyz'[k]} is"
        f" {half:.9g} m by {name} ({there}.side_m): {_length(off)} apart",
        off,
        (ROUNDING_M, LARGEST_GAP_M),
    )


def _near(layout: OpticalLayout, e: Element, others: list[TestMass]) -> str:
    """Which of the others is at the place of the element."""
    same = [t.name for t in others if np.linalg.norm(_centre(layout, e) - t.position_m) <= LARGEST_GAP_M]
    return f"; {same[0]} is at its place" if same else ""


def _centre(layout: OpticalLayout, e: Element) -> FloatArray:
    """In the basic frame, m."""
    return np.asarray(np.array(layout.frame_origin_m) + np.array(e.ref_m) @ layout.axes)


def _point(v: FloatArray) -> str:
    return "(" + ", ".join(f"{round(float(c), 9) + 0.0:.7g}" for c in v) + ")"


def _points(axes: FloatArray) -> str:
    return ", ".join(_point(axis) for axis in axes)


def _angle(value: float) -> str:
    return f"{value:.4g} rad ({np.degrees(value):.3g} deg)"


def _length(value: float) -> str:
    return f"{1e3 * value:.4g} mm"
