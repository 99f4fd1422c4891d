"""A bench deformed as much as an eye can see: motions multiplied by a factor, beams traced again through the new poses.

The trace is the full one, not its derivative: what is drawn is a bench that could be built. The factor is kept so small
that beams and elements move by a few per cent of the bench, where the two hardly differ.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.optics.layout import N_MOTIONS, OpticalLayout
from tedm_cli.optics.sensitivity import reference_offsets
from tedm_cli.optics.trace import Poses, RayLostError, Trace, nominal_poses, trace_path

_SHIFT = 0.05  # largest shift of an element or of a beam on a surface, of the size of the bench
_TURN = 0.2  # largest rotation of an element, rad
_PROBE = 1e-6  # of the size of the bench, and rad: where the trace is linear


@dataclass(frozen=True, eq=False)
class TracedBench:
    """Poses of all elements and the traces of all paths through them, in the layout's order."""

    poses: Poses
    traces: tuple[Trace, ...]

    def beam(self, path: int) -> FloatArray:
        """Corners of one beam, [m, 3] m, layout frame: injector, then every surface."""
        hits = self.traces[path].hits
        source = hits[0].point - hits[0].distance * hits[0].direction
        return np.array([source, *(hit.point for hit in hits)])


@dataclass(frozen=True, eq=False)
class ExaggeratedBench:
    """The bench as it is, and after `factor` times its motions."""

    before: TracedBench
    after: TracedBench
    factor: float


def traced_bench(layout: OpticalLayout, poses: Poses | None = None) -> TracedBench:
    """The bench at the given (default nominal) poses.

    Raises
    ------
    PhysicsError : a ray is lost.
    """
    at = nominal_poses(layout) if poses is None else poses
    return TracedBench(at, tuple(trace_path(layout, path, at) for path in layout.paths))


def motion_of_elements(layout: OpticalLayout, D_opt: FloatArray, node_positions_m: FloatArray) -> FloatArray:
    """Motion of all elements about the layout's reference points, [n_elements, 6] (m, rad), layout frame.

    Parameters
    ----------
    D_opt : motion of the nodes of the bench elements, [n_bench, 6] (m, rad), basic frame; test masses do not move.
    node_positions_m : these nodes, [n_bench, 3] m, basic frame.
    """
    shift, turn = D_opt[:, :3] @ layout.axes.T, D_opt[:, 3:] @ layout.axes.T
    motion = np.zeros((len(layout.elements), N_MOTIONS))
    places = [layout.index(e.name) for e in layout.bench]
    motion[places, :3] = shift + np.cross(turn, reference_offsets(layout, node_positions_m))
    motion[places, 3:] = turn
    return motion


def exaggerated_bench(layout: OpticalLayout, motion: FloatArray) -> ExaggeratedBench:
    """The bench after its motions times the largest factor of one digit that can be drawn.

    No element, and no beam on a surface, is shifted by more than 5 % of the bench, none turned by more than
    0.2 rad, and no ray is lost.

    Parameters
    ----------
    motion : of all elements about the layout's reference points, [n_elements, 6] (m, rad), layout frame.

    Raises
    ------
    PhysicsError : a ray of the nominal layout is lost.
    """
    before = traced_bench(layout)
    size = layout.size_m
    turn = float(np.abs(motion[:, 3:]).max())
    largest = max(float(np.abs(motion[:, :3]).max()) / size, turn)
    if largest == 0.0:
        return ExaggeratedBench(before, before, 1.0)
    probe = _PROBE / largest
    shift = _largest_shift(before, traced_bench(layout, before.poses.moved(probe * motion))) / probe
    factor = round_down(1.0 / max(shift / (_SHIFT * size), turn / _TURN))
    while True:
        try:
            after = traced_bench(layout, before.poses.moved(factor * motion))
        except RayLostError:
            after = None
        if after is not None and _largest_shift(before, after) <= _SHIFT * size:
            return ExaggeratedBench(before, after, factor)
        factor = round_down(0.9 * factor)


def round_down(value: float) -> float:
    """A positive number with its first digit kept and the others made zero."""
    decade = math.floor(math.log10(value))
    digit = math.floor(value / 10.0**decade * (1 + 1e-9))  # 2 that became 1.999... by rounding is 2
    return float(f"{max(1, digit)}e{decade}")


def _largest_shift(before: TracedBench, after: TracedBench) -> float:
    """Largest shift of a reference point or of a beam on a surface, m."""
    beams = [np.linalg.norm(after.beam(i) - before.beam(i), axis=1).max() for i in range(len(before.traces))]
    return float(max(np.linalg.norm(after.poses.ref - before.poses.ref, axis=1).max(), *beams))
