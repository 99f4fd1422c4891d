"""Elements of the optical bench as outlines in a view, and beams as segments that each know whose they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.optics.exaggerated import TracedBench
from tedm_cli.optics.layout import Beam, Element, OpticalLayout
from tedm_cli.optics.trace import Poses

_RIM = 32  # points on the edge of a round element
_ASSUMED = 0.02  # half-size where no aperture is given, of the size of the bench
# Depth behind the surface where the layout gives none, and half-size of an injector's nose, of the half-size: they tell
# the kinds apart.
_DEPTH = {"mirror": 0.35, "beamsplitter": 0.35, "window": 0.35, "photodiode": 1.2, "injector": 2.5}
_NOSE = 0.35


@dataclass(frozen=True)
class View:
    """Where one looks from: rows of `axes` [2, 3] point to the right and up in the figure."""

    title: str
    axes: tuple[tuple[float, float, float], tuple[float, float, float]]
    labels: tuple[str, str]

    def flat(self, points_m: FloatArray) -> FloatArray:
        """Points [..., 3] m in the layout frame to [..., 2] mm in the view."""
        return np.asarray(1e3 * points_m @ np.array(self.axes).T)


ABOVE = View("from above", ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), ("x", "y"))
SIDE = View("from the side", ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)), ("x", "z"))


@dataclass(frozen=True, eq=False)
class Segments:
    """Straight pieces of beams, each once: `points` [n, 2, 3] m, `interferometer` [n], -1 where several share it."""

    beam: Beam
    points: FloatArray
    interferometer: IntArray


def body(layout: OpticalLayout, place: int, poses: Poses) -> FloatArray:
    """Corners of an element's body, [m, 3] m, layout frame; the body is their convex hull.

    A plate is the disc or box over its aperture between front and back, a test mass the cube behind its front face.
    """
    element = layout.elements[place]
    ref, normal, y = poses.ref[place], poses.normal[place], poses.local_y[place]
    if not y.any():
        y = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal) + 1e-3 * np.arange(3, 0, -1))])
        y /= np.linalg.norm(y)
    x = np.cross(y, normal)
    half = half_sizes(layout, element)
    if element.kind == "test_mass" or isinstance(element.aperture_m, tuple):
        rim = np.array([[a * half[0], b * half[1]] for a, b in ((1, 1), (1, -1), (-1, -1), (-1, 1))])
    else:
        angle = 2 * np.pi * np.arange(_RIM) / _RIM
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


def outline(points: FloatArray) -> FloatArray:
    """Convex hull of points [m, 2], counter-clockwise (Andrew 1979)."""
    ordered = sorted({(float(p[0]), float(p[1])) for p in np.round(points, 9)})

    def chain(those: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
        kept: list[tuple[float, float]] = []
        for p in those:
            while len(kept) > 1 and _turn(kept[-2], kept[-1], p) <= 1e-12:
                kept.pop()
            kept.append(p)
        return kept[:-1]

    return np.array(chain(ordered) + chain(ordered[::-1]))


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def interferometers(layout: OpticalLayout) -> list[tuple[str, ...]]:
    """Photodiodes that see the same two beams: their paths meet the same elements but for the photodiode."""
    found: dict[tuple[tuple[str, ...], ...], list[str]] = {}
    for name in layout.photodiodes:
        paths = [layout.paths[layout.path_index(name, beam)] for beam in ("meas", "ref")]
        found.setdefault(tuple(tuple(s.element for s in p.steps[:-1]) for p in paths), []).append(name)
    return [tuple(names) for names in found.values()]


def beam_segments(layout: OpticalLayout, bench: TracedBench) -> tuple[Segments, Segments]:
    """Measurement and reference beams as segments, those of several photodiodes once."""
    owner = {name: i for i, names in enumerate(interferometers(layout)) for name in names}
    found: dict[Beam, dict[tuple[float, ...], tuple[FloatArray, set[int]]]] = {"meas": {}, "ref": {}}
    for i, path in enumerate(layout.paths):
        corners = bench.beam(i)
        for piece in np.stack([corners[:-1], corners[1:]], axis=1):
            key = tuple(np.round(piece.reshape(-1), 9))
            found[path.beam].setdefault(key, (piece, set()))[1].add(owner[path.photodiode])
    return _segments("meas", found["meas"]), _segments("ref", found["ref"])


def _segments(beam: Beam, found: dict[tuple[float, ...], tuple[FloatArray, set[int]]]) -> Segments:
    owners = [min(who) if len(who) == 1 else -1 for _, who in found.values()]
    return Segments(beam, np.array([piece for piece, _ in found.values()]), np.array(owners, dtype=np.int64))


def out_of_plane(layout: OpticalLayout, bench: TracedBench) -> bool:
    """Whether beams or elements leave one plane of constant z by more than a micrometre."""
    heights = np.concatenate([bench.poses.ref[:, 2], *(bench.beam(i)[:, 2] for i in range(len(layout.paths)))])
    return bool(np.ptp(heights) > 1e-6)
