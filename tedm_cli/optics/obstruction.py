"""Elements as bodies: how far from the middle of its aperture a point lies, and what a straight ray runs into.

A body is the prism or cylinder over the aperture between front and back plane; that of a test mass reaches from face to
opposite face. A segment is cut against the body's planes and its cylinder one after the other, which leaves the part of
the segment inside, since the body is convex.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.optics.layout import Element, OpticalLayout


@dataclass(frozen=True, eq=False)
class Obstruction:
    """A body in the way: `point` (m, layout frame) is the middle of the ray's part inside it, `depth_m` the distance of
    that point inside the edge (plus the clearance)."""

    element: str
    point: FloatArray
    depth_m: float


def lateral_excess(element: Element, point: FloatArray) -> tuple[float, float]:
    """Distance (m) of `point` from the middle of the aperture in the element's plane, and the limit it has there.

    Of a rectangular aperture the direction is reported in which the point is furthest out.
    """
    assert element.aperture_m is not None
    normal, offset = np.array(element.normal), point - np.array(element.ref_m)
    if not isinstance(element.aperture_m, tuple):
        return float(np.linalg.norm(offset - (offset @ normal) * normal)), element.aperture_m
    values = [abs(float(axis @ offset)) for axis in _axes(element)]
    worst = int(np.argmax(np.array(values) - np.array(element.aperture_m)))
    return values[worst], element.aperture_m[worst]


def obstructions(
    layout: OpticalLayout, start: FloatArray, end: FloatArray, apart_from: tuple[str, ...]
) -> Iterator[Obstruction]:
    """Bodies, enlarged by the layout's clearance, on the segment from `start` to `end` (m, layout frame)."""
    clearance = layout.tolerances.clearance_m
    for element in layout.elements:
        if element.aperture_m is None or element.name in apart_from:
            continue
        inside = _inside(element, start, end - start, clearance)
        if inside is not None:
            point = start + inside * (end - start)
            value, limit = lateral_excess(element, point)
            yield Obstruction(element.name, point, limit + clearance - value)


def _inside(element: Element, start: FloatArray, way: FloatArray, clearance: float) -> float | None:
    """Middle of the part of `start + t way`, 0 <= t <= 1, inside the enlarged body; None where there is none."""
    offset, normal = start - np.array(element.ref_m), np.array(element.normal)
    depth = 2 * element.front_offset_m if element.kind == "test_mass" else element.thickness_m
    back, front = element.front_offset_m - depth - clearance, element.front_offset_m + clearance
    low, high = _between(float(offset @ normal), float(way @ normal), back, front)
    if isinstance(element.aperture_m, tuple):
        for axis, half in zip(_axes(element), element.aperture_m, strict=True):
            reach = half + clearance
            first, last = _between(float(offset @ axis), float(way @ axis), -reach, reach)
            low, high = max(low, first), min(high, last)
    else:
        assert element.aperture_m is not None
        across, along = offset - (offset @ normal) * normal, way - (way @ normal) * normal
        first, last = _within_radius(across, along, element.aperture_m + clearance)
        low, high = max(low, first), min(high, last)
    low, high = max(low, 0.0), min(high, 1.0)
    return (low + high) / 2 if low <= high else None


def _axes(element: Element) -> tuple[FloatArray, FloatArray]:
    y = np.array(element.local_y)
    return np.cross(y, np.array(element.normal)), y


def _between(offset: float, slope: float, lower: float, upper: float) -> tuple[float, float]:
    """Range of t with `lower <= offset + slope t <= upper`; empty as (1, 0)."""
    if slope == 0.0:
        return (-np.inf, np.inf) if lower <= offset <= upper else (1.0, 0.0)
    ends = sorted(((lower - offset) / slope, (upper - offset) / slope))
    return ends[0], ends[1]


def _within_radius(offset: FloatArray, slope: FloatArray, radius: float) -> tuple[float, float]:
    """Range of t with `|offset + slope t| <= radius`; empty as (1, 0)."""
    a, b, c = float(slope @ slope), float(offset @ slope), float(offset @ offset) - radius**2
    if a == 0.0:
        return (-np.inf, np.inf) if c <= 0 else (1.0, 0.0)
    square = b * b - a * c
    if square < 0:
        return 1.0, 0.0
    return (-b - np.sqrt(square)) / a, (-b + np.sqrt(square)) / a
