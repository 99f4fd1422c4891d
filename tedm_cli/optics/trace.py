"""Geometrical ray trace along ordered steps: thin mirrors, thick plates, injectors and photodiodes.

Geometrical optics of the chief ray (Born and Wolf, Principles of Optics, sections 3.2 and 4.6). The element poses are
an argument and may be complex, so that a complex-step derivative runs through the function of the nominal values.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np

from tedm_cli.arrays import AnyArray
from tedm_cli.errors import PhysicsError
from tedm_cli.optics.layout import BeamPath, Element, Operation, OpticalLayout

AMBIENT_INDEX = 1.0
GRAZING = 1e-9  # |cos| of the incidence angle below which a ray counts as parallel to the surface
BEHIND_M = 1e-12  # surfaces in contact may come out this far behind each other by rounding

SurfaceKind = Literal["reflect", "refract", "detect"]
Face = Literal["front", "back"]


class RayLostError(PhysicsError):
    """The chief ray of a path cannot go on; `step` is the number (from 1) of the step it fails at."""

    def __init__(self, fact: str, *, path: BeamPath, step: int, hint: str) -> None:
        super().__init__(fact, where=step_label(path, step), hint=hint)
        self.step = step


@dataclass(frozen=True, eq=False)
class Poses:
    """Where all elements are: `ref` (m), `normal`, `local_y` (zero: none), each [n_elements, 3], layout frame."""

    ref: AnyArray
    normal: AnyArray
    local_y: AnyArray

    def moved(self, motion: AnyArray) -> Poses:
        """Poses after the finite motions `motion` [n_elements, 6] (m, rad), rotations `exp([theta]x)` about `ref`."""
        theta = motion[:, 3:]
        return Poses(self.ref + motion[:, :3], rotated(self.normal, theta), rotated(self.local_y, theta))


@dataclass(frozen=True, eq=False)
class Hit:
    """One surface met by a ray, in the path's step of that number (from 1).

    `normal` points against the incoming ray, whose direction is `direction`; `distance` (m) is from the previous point.
    """

    step: int
    element: int
    face: Face
    kind: SurfaceKind
    distance: Any
    point: AnyArray
    normal: AnyArray
    direction: AnyArray
    index_in: float
    index_out: float


@dataclass(frozen=True, eq=False)
class Trace:
    """A traced path: the surfaces met, and the output [5] on the photodiode: x, y, opl (m), z1, z2 (rad)."""

    hits: tuple[Hit, ...]
    output: AnyArray


def nominal_poses(layout: OpticalLayout) -> Poses:
    """Poses of the undisturbed layout."""
    return Poses(
        layout.refs_m.copy(),
        np.array([e.normal for e in layout.elements]),
        np.array([e.local_y or (0.0, 0.0, 0.0) for e in layout.elements]),
    )


def rotated(vector: AnyArray, theta: AnyArray) -> AnyArray:
    """Rotate `vector` [..., 3] by the rotation vector `theta` [..., 3] (rad): Rodrigues' formula, analytic."""
    square = np.sum(theta * theta, axis=-1, keepdims=True)
    small = np.abs(square) < 1e-4
    angle = np.sqrt(np.where(small, 1.0, square))
    # The series keep the formula analytic at zero, where a complex step starts; they are exact to 1e-20 below 1e-2 rad.
    first = np.where(small, 1 - square / 6 * (1 - square / 20 * (1 - square / 42)), np.sin(angle) / angle)
    second = np.where(
        small, 0.5 - square / 24 * (1 - square / 30 * (1 - square / 56)), 2 * (np.sin(angle / 2) / angle) ** 2
    )
    turned = np.cross(theta, vector)
    return np.asarray(vector + first * turned + second * np.cross(theta, turned))


def trace(layout: OpticalLayout, poses: Poses | None = None) -> AnyArray:
    """Outputs of all paths, [n_paths, 5]: x, y, opl (m), z1, z2 (rad), at the given (default nominal) poses.

    Raises
    ------
    PhysicsError : a ray misses; see `trace_path`.
    """
    at = nominal_poses(layout) if poses is None else poses
    return np.stack([trace_path(layout, path, at).output for path in layout.paths])


def trace_path(layout: OpticalLayout, path: BeamPath, poses: Poses) -> Trace:
    """Trace the chief ray of one path.

    The optical path starts at the injector's reference point, plus its offset, and ends on the photodiode's plane. With
    `ez` the photodiode's normal, `ey = local_y` and `ex = ey x ez`, a ray that arrives at `p` along `d` gives
    `x = ex.(p - ref)`, `y = ey.(p - ref)`, `z1 = ex.d`, `z2 = ey.d`.

    Raises
    ------
    PhysicsError : see `encounters`.
    """
    hits = tuple(encounters(layout, path, poses))
    offset = layout.elements[layout.index(path.steps[0].element)].opl_offset_m
    return Trace(hits, output_of(hits, poses, offset))


def output_of(hits: tuple[Hit, ...], poses: Poses, opl_offset_m: float) -> AnyArray:
    """Output [5] of a path from all its hits: x, y, opl (m), z1, z2 (rad)."""
    last = hits[-1]
    ex, ey = photodiode_axes(poses, last.element)
    spot = last.point - poses.ref[last.element]
    opl = sum((hit.index_in * hit.distance for hit in hits), start=opl_offset_m)
    return np.array([ex @ spot, ey @ spot, opl, ex @ last.direction, ey @ last.direction])


def photodiode_axes(poses: Poses, place: int) -> tuple[AnyArray, AnyArray]:
    """Axes `ex`, `ey` of the photodiode that stands at `place` in the layout order."""
    ey = poses.local_y[place]
    return np.cross(ey, poses.normal[place]), ey


def encounters(layout: OpticalLayout, path: BeamPath, poses: Poses) -> Iterator[Hit]:
    """The surfaces that the chief ray of `path` meets, one after the other; the last one is the photodiode's.

    Raises
    ------
    RayLostError : a ray runs parallel to a surface, meets it from the wrong side, leaves it behind, or is totally
        reflected; path, step and element are named. What was met before has been yielded.
    """
    first = layout.index(path.steps[0].element)
    point, direction = poses.ref[first], poses.normal[first]
    for number, step in enumerate(path.steps[1:], start=2):
        lost = partial(RayLostError, path=path, step=number)
        place = layout.index(step.element)
        element = layout.elements[place]
        normal = poses.normal[place]
        front = poses.ref[place] + element.front_offset_m * normal
        anchors = {"front": front, "back": front - element.thickness_m * normal}
        approach = float(np.real(direction @ normal))
        if abs(approach) < GRAZING:
            raise lost(
                f"the ray runs parallel to {element.name}",
                hint=f"turn {element.name} or the element before it",
            )
        if approach > 0 and step.op != "T" and (step.op == "detect" or not element.is_plate):
            angle = np.degrees(np.arccos(min(approach, 1.0)))
            raise lost(
                f"the ray meets {element.name} from behind, {angle:.3g} deg off its normal",
                hint="turn its normal towards the light; only a plate (thickness_m, index) may be met from behind",
            )
        for face, kind, index_in, index_out in _surfaces(element, step.op, approach < 0):
            cosine = direction @ normal
            distance = ((anchors[face] - point) @ normal) / cosine
            if np.real(distance) < -BEHIND_M:
                raise lost(
                    f"{element.name} lies {-np.real(distance):.3g} m behind the ray",
                    hint=f"check ref_m and normal of {element.name} and of the element before it, and the steps",
                )
            point = point + distance * direction
            against = -normal if np.real(cosine) > 0 else normal
            yield Hit(number, place, face, kind, distance, point, against, direction, index_in, index_out)
            if kind == "reflect":
                direction = direction - 2 * cosine * normal
            elif kind == "refract":
                refracted = _refracted(direction, against, index_in / index_out)
                if refracted is None:
                    raise lost(
                        f"the ray is totally reflected in {element.name} where it should be transmitted",
                        hint=f"turn {element.name} towards the beam",
                    )
                direction = refracted


def step_label(path: BeamPath, number: int) -> str:
    """Where a message is about, e.g. ``path PD1A meas, step 5 (M1:R)``."""
    return f"path {path.label}, step {number} ({path.steps[number - 1].label})"


def _surfaces(element: Element, op: Operation, from_front: bool) -> list[tuple[Face, SurfaceKind, float, float]]:
    """Surfaces met in one step, in order: (face, kind, index before, index behind)."""
    outside, inside = AMBIENT_INDEX, element.index
    if op == "T":
        near: Face = "front" if from_front else "back"
        far: Face = "back" if from_front else "front"
        return [(near, "refract", outside, inside), (far, "refract", inside, outside)]
    if from_front:
        return [("front", "detect" if op == "detect" else "reflect", outside, outside)]
    return [
        ("back", "refract", outside, inside),
        ("front", "reflect", inside, inside),
        ("back", "refract", inside, outside),
    ]


def _refracted(direction: AnyArray, normal: AnyArray, ratio: float) -> AnyArray | None:
    """Snell's law in vector form; `normal` against the ray, `ratio` = index before / behind; None: total reflection."""
    cosine = -(direction @ normal)
    square = 1 - ratio**2 * (1 - cosine**2)
    if np.real(square) <= 0:
        return None
    return np.asarray(ratio * direction + (ratio * cosine - np.sqrt(square)) * normal)
