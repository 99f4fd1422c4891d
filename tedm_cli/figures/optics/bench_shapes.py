"""Elements of the optical bench as outlines in a view, and beams as segments that each know whose they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.optics.benches import benches
from tedm_cli.optics.exaggerated import TracedBench
from tedm_cli.optics.layout import Beam, OpticalLayout


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


@dataclass(frozen=True)
class Shown:
    """What a view shows: places of elements and of paths; `title` names the bench, where it is one of several."""

    elements: tuple[int, ...]
    paths: tuple[int, ...]
    title: str = ""


def whole(layout: OpticalLayout) -> Shown:
    """All of a layout."""
    return Shown(tuple(range(len(layout.elements))), tuple(range(len(layout.paths))))


def each_bench(layout: OpticalLayout) -> list[Shown]:
    """The benches one by one, each with the test masses that its beams meet; of a layout with one, all of it."""
    found = benches(layout)
    if len(found) == 1:
        return [whole(layout)]
    out = []
    for name, elements in found.items():
        names = {e.name for e in elements}
        paths = [i for i, path in enumerate(layout.paths) if path.photodiode in names]
        names |= {step.element for i in paths for step in layout.paths[i].steps}
        out.append(Shown(tuple(i for i, e in enumerate(layout.elements) if e.name in names), tuple(paths), name))
    return out


def beam_segments(
    layout: OpticalLayout, bench: TracedBench, shown: Sequence[int] | None = None
) -> tuple[Segments, Segments]:
    """Measurement and reference beams as segments, those of several photodiodes once; of the paths `shown`."""
    owner = {name: i for i, names in enumerate(interferometers(layout)) for name in names}
    found: dict[Beam, dict[tuple[float, ...], tuple[FloatArray, set[int]]]] = {"meas": {}, "ref": {}}
    for i in range(len(layout.paths)) if shown is None else shown:
        path = layout.paths[i]
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
