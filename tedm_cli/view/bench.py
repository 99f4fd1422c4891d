"""The optical bench as faces and segments that move with the temperatures: bodies of its elements, and its beams.

What is drawn is linear in the motions, as the read-outs are. Corners of bodies follow their element; corners of beams
follow the derivative of the ray trace, by a complex step, so that a beam leaves a turned mirror at twice its angle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.optics.bodies import body
from tedm_cli.optics.exaggerated import motion_of_elements, traced_bench
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.optics.trace import nominal_poses

KINDS = ("injector", "mirror", "beamsplitter", "window", "photodiode")
BEAMS = ("meas", "ref")
_RIM = 12  # corners of a round element
_STEP = 1e-20


@dataclass(frozen=True, eq=False)
class DrawnBench:
    """Corners, and what they make.

    Parameters
    ----------
    position, motion : [v, 3] m and [k, v, 3] m/K, basic frame: where the corners are, and how each area moves them.
    face, face_kind : [F, 3] corners and [F] place in `KINDS`.
    segment, segment_beam : [S, 2] corners and [S] place in `BEAMS`.
    """

    position: FloatArray
    motion: FloatArray
    face: IntArray
    face_kind: IntArray
    segment: IntArray
    segment_beam: IntArray


def drawn_bench(layout: OpticalLayout | None, motion: FloatArray, node_positions_m: FloatArray) -> DrawnBench:
    """The bench of a layout; without corners where there is none, or where it does not say where its surfaces are.

    Parameters
    ----------
    motion : [k, n_bench, 6] (m/K, rad/K), of the grids of the bench elements per kelvin of each area, basic frame.
    node_positions_m : [n_bench, 3], these grids, basic frame.

    Raises
    ------
    PhysicsError : a ray of the layout is lost.
    """
    k = len(motion)
    if layout is None or not layout.has_geometry:
        return _joined(k, [], [], [], [], [], [])
    moved = np.array([motion_of_elements(layout, of_area, node_positions_m) for of_area in motion])
    corners: list[FloatArray] = []
    moves: list[FloatArray] = []
    faces: list[IntArray] = []
    kinds: list[int] = []
    poses = nominal_poses(layout)
    first = 0
    for place, element in enumerate(layout.elements):
        if element.kind == "test_mass":
            continue
        points = np.asarray(body(layout, place, poses, _RIM))
        arm = points - poses.ref[place]
        corners.append(points)
        moves.append(moved[:, place, None, :3] + np.cross(moved[:, place, None, 3:], arm))
        found = ConvexHull(points).simplices.astype(np.int64)
        faces.append(found + first)
        kinds += [KINDS.index(element.kind)] * len(found)
        first += len(points)
    segments: list[IntArray] = []
    beams: list[int] = []
    traces = [traced_bench(layout, poses.moved(1j * _STEP * of_area)) for of_area in moved]
    at_rest = traced_bench(layout, poses)
    for number, path in enumerate(layout.paths):
        points = at_rest.beam(number)
        corners.append(points)
        moves.append(np.array([t.beam(number).imag for t in traces]) / _STEP)
        ends = first + np.arange(len(points))
        segments.append(np.stack([ends[:-1], ends[1:]], axis=1))
        beams += [BEAMS.index(path.beam)] * (len(points) - 1)
        first += len(points)
    origin, axes = np.array(layout.frame_origin_m), layout.axes
    corners = [origin + c @ axes for c in corners]
    return _joined(k, corners, [m @ axes for m in moves], faces, kinds, segments, beams)


def _joined(
    k: int,
    corners: list[FloatArray],
    moves: list[FloatArray],
    faces: list[IntArray],
    kinds: list[int],
    segments: list[IntArray],
    beams: list[int],
) -> DrawnBench:
    return DrawnBench(
        np.concatenate([np.zeros((0, 3)), *corners]),
        np.concatenate([np.zeros((k, 0, 3)), *moves], axis=1),
        np.concatenate([np.zeros((0, 3), dtype=np.int64), *faces]),
        np.array(kinds, dtype=np.int64),
        np.concatenate([np.zeros((0, 2), dtype=np.int64), *segments]),
        np.array(beams, dtype=np.int64),
    )
