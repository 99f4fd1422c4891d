"""Bodies of the optical elements as the layout has them, for whatever draws the bench."""

from __future__ import annotations

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.optics.layout import Element, OpticalLayout
from tedm_cli.optics.trace import Poses

RIM = 32  # points on the edge of a round element
_ASSUMED = 0.02  # half-size where no aperture is given, of the size of the bench
# Depth behind the surface where the layout gives none, and half-size of an injector's nose, of the half-size: they tell
# the kinds apart.
_DEPTH = {"mirror": 0.35, "beamsplitter": 0.35, "window": 0.35, "photodiode": 1.2, "injector": 2.5}
_NOSE = 0.35


def body(layout: OpticalLayout, place: int, poses: Poses, rim_points: int = RIM) -> FloatArray:
    """Corners of an element's body, [m, 3] m, layout frame; the body is their convex hull.

    A plate is the disc or box over its aperture between front and back, a test mass the cube behind its front face.
    `rim_points` are on the edge of a round element.
    """
    element = layout.elements[place]
    ref, normal, y = poses.ref[place], poses.normal[place], poses.local_y[place]
    if not y.any():
        axes = np.array(element.axes)  # edges of a test mass are along its own
        y = np.cross(normal, axes[np.argmin(np.abs(axes @ normal) + 1e-3 * np.arange(3, 0, -1))])
        y /= np.linalg.norm(y)
    x = np.cross(y, normal)
    half = half_sizes(layout, element)
    if element.kind == "test_mass" or isinstance(element.aperture_m, tuple):
        rim = np.array([[a * half[0], b * half[1]] for a, b in ((1, 1), (1, -1), (-1, -1), (-1, 1))])
    else:
        angle = 2 * np.pi * np.arange(rim_points) / rim_points
        rim = half[0] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    edge = rim @ np.stack([x, y])
    front = ref + element.front_offset_m * normal
    if element.kind == "test_mass":
        return np.concatenate([front + edge, front - 2 * element.front_offset_m * normal + edge])
    depth = element.thickness_m or _DEPTH[element.kind] * min(half)
    back = front - depth * normal + edge
    if element.kind == "injector":
        return np.concatenate([front + _NOSE * edge, front - 0.35 * depth * normal + edge, back])
    return np.concatenate([front + edge, back])


def half_sizes(layout: OpticalLayout, element: Element) -> tuple[float, float]:
    """Half-sizes of an element along its x and y, m; assumed where the layout gives no aperture."""
    if element.kind == "test_mass":
        return element.front_offset_m, element.front_offset_m
    if element.aperture_m is None:
        return (_ASSUMED * layout.size_m,) * 2
    if isinstance(element.aperture_m, tuple):
        return element.aperture_m[0], element.aperture_m[1]
    return element.aperture_m, element.aperture_m
