"""Do the results obey the rigid elements of the deck? A wrong displacement frame or a wrong deck shows here."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.errors import PhysicsError
from tedm_cli.nastran.frames import displacement_axes
from tedm_cli.nastran.geometry import ModelGeometry

# Of a link's own motion. Single precision leaves 2e-7 and penalty formulations some 1e-6; a frame that is turned
# by a degree leaves 2e-2.
TOLERANCE = 1e-4
# Links that hardly move next to the rest of the model are judged against this share of the largest motion.
_STILL = 1e-2


@dataclass(frozen=True)
class RigidLinks:
    """One row per dependent grid of an RBE2 [L].

    independent, dependent : rows of the grid table. tied : [L,6], components (CM) in the dependent grid's displacement
    frame. lever : [L,3] m, from the independent to the dependent grid, basic frame. axes : [L,3,3], unit vectors
    (columns) of the dependent grid's displacement frame. extent_m : longest edge of the model.
    """

    element: IntArray
    independent: IntArray
    dependent: IntArray
    tied: BoolArray
    lever: FloatArray
    axes: FloatArray
    extent_m: float


def rigid_links(model: Any, geometry: ModelGeometry) -> RigidLinks:
    """The links of all RBE2 of a pyNastran model, without those that expand with temperature (ALPHA)."""
    elements, leaders, followers, components = [], [], [], []
    for eid in sorted(model.rigid_elements):
        element = model.rigid_elements[eid]
        if element.type != "RBE2" or element.alpha:
            continue
        mask = [str(digit) in str(element.cm) for digit in range(1, 7)]
        for grid in element.Gmi_node_ids:
            elements.append(eid)
            leaders.append(int(element.Gn()))
            followers.append(int(grid))
            components.append(mask)
    leader = np.searchsorted(geometry.grid_id, np.array(leaders, dtype=np.int64))
    follower = np.searchsorted(geometry.grid_id, np.array(followers, dtype=np.int64))
    axes = displacement_axes(geometry.position_m[follower], geometry.displacement_frame[follower], geometry.frames)
    return RigidLinks(
        element=np.array(elements, dtype=np.int64),
        independent=leader,
        dependent=follower,
        tied=np.array(components, dtype=bool).reshape(-1, 6),
        lever=geometry.position_m[follower] - geometry.position_m[leader],
        axes=np.tile(np.eye(3), (len(leader), 1, 1)) if axes is None else axes,
        extent_m=float(np.ptp(geometry.position_m, axis=0).max()),
    )


def rigidity(links: RigidLinks, translation: FloatArray, rotation: FloatArray) -> FloatArray:
    """Residual [L] of u_d = u_i + θ_i × (x_d - x_i), θ_d = θ_i in the tied components, over the link's own motion.

    The link's own motion is |u_i| + |θ_i| |x_d - x_i| + |u_d| (where these cancel, single precision loses digits), and
    not less than a hundredth of the largest translation [N,3]; for rotations |θ_i| + |θ_d|, and not less than a
    hundredth of the largest translation over the extent of the model.
    """
    if not len(links.element):
        return np.zeros(0)

    def length(v: FloatArray) -> FloatArray:
        return np.asarray(np.linalg.norm(v, axis=1))

    u_i, u_d = translation[links.independent], translation[links.dependent]
    turn_i, turn_d = rotation[links.independent], rotation[links.dependent]
    still = _STILL * length(translation).max()

    def untied(gap: FloatArray, tied: BoolArray) -> FloatArray:
        return length(np.einsum("lab,la->lb", links.axes, gap) * tied)

    gap_u = untied(u_d - u_i - np.cross(turn_i, links.lever), links.tied[:, :3])
    gap_turn = untied(turn_d - turn_i, links.tied[:, 3:])
    scale_u = length(u_i) + length(u_d) + length(turn_i) * length(links.lever) + still
    scale_turn = length(turn_i) + length(turn_d) + still / links.extent_m
    ratio = [
        np.divide(gap, scale, out=np.zeros_like(gap), where=gap > 0)
        for gap, scale in ((gap_u, scale_u), (gap_turn, scale_turn))
    ]
    return np.maximum(*ratio)


def check_rigidity(
    links: RigidLinks, grid_id: IntArray, translation: FloatArray, rotation: FloatArray, *, where: str
) -> float:
    """The largest `rigidity` of a unit load (0 without RBE2).

    Raises
    ------
    PhysicsError : it is above `TOLERANCE`; names the element and its grids.
    """
    ratio = rigidity(links, translation, rotation)
    if not ratio.size:
        return 0.0
    worst = int(ratio.argmax())
    if ratio[worst] > TOLERANCE:
        raise PhysicsError(
            f"RBE2 {links.element[worst]} is not rigid: grid {grid_id[links.dependent[worst]]} does not follow grid"
            f" {grid_id[links.independent[worst]]}, by {ratio[worst]:.2g} of their motion"
            f" ({(ratio > TOLERANCE).sum()} of {ratio.size} links)",
            where=where,
            hint="are deck and OP2 of one run? displacement frames (CD) or grids differ, or the deck was changed since",
        )
    return float(ratio[worst])
