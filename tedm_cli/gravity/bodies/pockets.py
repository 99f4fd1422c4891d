"""Pockets of a body: inside what they are cut out of, and apart from each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import PhysicsError
from tedm_cli.gravity.bodies.box import Box
from tedm_cli.gravity.bodies.composite import Pocket
from tedm_cli.gravity.bodies.cylinder import Cylinder
from tedm_cli.gravity.bodies.facets import facets_of
from tedm_cli.gravity.bodies.polyhedron import Polyhedron

_BEYOND = 1e-9  # over the extent of the body: rounding of sizes that add up to a face
_SHRUNK = 1e-4  # of their sizes: pockets that touch are apart, and clearly so for the solver
_MARGIN = 1e-6
_ROUND = 256  # corners of the prism that stands for a cylinder


def check_pockets(base: Box | Polyhedron | Cylinder, pockets: Sequence[Pocket]) -> None:
    """Refuse pockets that stick out of a convex body or overlap; pockets may touch.

    Raises
    ------
    PhysicsError : names the pocket, or both.
    """
    extent = float((base.high_m - base.low_m).max())
    for pocket in pockets:
        out = _sticks_out(base, pocket)
        if out > _BEYOND * extent:
            raise PhysicsError(f"{pocket.name} is not inside the body: it sticks out of it by {out:.3g} m")
    for number, first in enumerate(pockets):
        for second in pockets[number + 1 :]:
            if _overlap(first.solid, second.solid):
                raise PhysicsError(f"{first.name} and {second.name} overlap", hint="mass must be taken away once")


def _sticks_out(base: Box | Polyhedron | Cylinder, pocket: Pocket) -> float:
    if isinstance(base, Cylinder):
        side = np.max(base.off(_corners(pocket.solid, 1.0)), axis=0)
        return float(side.max())
    if isinstance(base, Box):
        directions = np.concatenate([np.eye(3), -np.eye(3)])
    else:
        directions = facets_of(base.corner_m, base.triangle).normal
    return float((pocket.solid.reach(directions) - base.reach(directions)).max())


def _overlap(first: Box | Cylinder, second: Box | Cylinder) -> bool:
    """Whether no plane keeps two convex solids apart: the widest gap between parallel planes, by linear programming."""
    if (first.low_m >= second.high_m).any() or (second.low_m >= first.high_m).any():
        return False
    if isinstance(first, Box) and isinstance(second, Box):
        common = np.minimum(first.high_m, second.high_m) - np.maximum(first.low_m, second.low_m)
        return bool((common > _BEYOND * np.maximum(first.high_m - first.low_m, second.high_m - second.low_m)).all())
    middle = (first.centre_m + second.centre_m) / 2.0
    a, b = (_corners(s, 1.0 - _SHRUNK) - middle for s in (first, second))
    scale = float(np.abs(np.concatenate([a, b])).max())
    # unknowns: normal w [3], offset c, margin m; maximise m for w·a - c >= m, w·b - c <= -m, |w_i| <= 1
    rows = np.concatenate(
        [np.column_stack([-a / scale, np.ones(len(a)), np.ones(len(a))]),
         np.column_stack([b / scale, -np.ones(len(b)), np.ones(len(b))])]
    )  # fmt: skip
    found = scipy.optimize.linprog(
        [0, 0, 0, 0, -1], A_ub=rows, b_ub=np.zeros(len(rows)), bounds=[(-1, 1)] * 3 + [(None, None), (0, 1)]
    )
    return not (found.status == 0 and found.x[4] > _MARGIN)


def _corners(solid: Box | Cylinder, factor: float) -> FloatArray:
    """Corners of a convex solid, or of a prism in it, shrunk about its centre."""
    if isinstance(solid, Box):
        corners = solid.surface().reshape(-1, 3)
    else:
        angle = 2.0 * np.pi * np.arange(_ROUND) / _ROUND
        rim = solid.radius_m * np.stack([np.cos(angle), np.sin(angle)], axis=1) @ solid.axes[:2]
        half = (solid.top_m - solid.bottom_m) / 2.0 * solid.axis
        corners = np.concatenate([solid.centre_m + rim - half, solid.centre_m + rim + half])
    return np.asarray(solid.centre_m + factor * (corners - solid.centre_m))
