"""Compensation masses that are tied to grids: how they follow the structure, and what that adds to the operator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.gravity.compensation import CompensationMass
from tedm_cli.gravity.field import SelfGravity
from tedm_cli.gravity.motion import by_motion_of_source, cross_matrix
from tedm_cli.gravity.testmass import TestMass

# Grids whose distance from a line is less than this of their length stand on it, as far as a rotation about it goes;
# grids this close together stand at one point.
_THIN, _POINT_M = 1e-3, 1e-6


@dataclass(frozen=True, eq=False)
class Follower:
    """Rigid motion by the motions of n grids, ``(t, θ) = Σ by_translation u_n + by_rotation θ_n``.

    by_translation, by_rotation : [n, 6, 3], basic frame; rows are the translation t of a point (m) and the rotation θ
    (rad). by_rotation is 0 where the positions of the grids define every rotation.
    """

    by_translation: FloatArray
    by_rotation: FloatArray

    def motion(self, translation: FloatArray, rotation: FloatArray) -> FloatArray:
        """(t, θ) [k, 6] under translations and rotations [k, n, 3] of the grids."""
        moved = np.einsum("nsc,knc->ks", self.by_translation, translation)
        return np.asarray(moved + np.einsum("nsc,knc->ks", self.by_rotation, rotation))


def follower(position: FloatArray, at: FloatArray) -> Follower:
    """How a rigid body follows grids: the motion that fits them best, with equal weights.

    It minimises ``Σ |u_n - t - θ x (x_n - x̄)|²``, as an RBE3 with equal weights on the translations does: t is the mean
    displacement, ``θ = J⁻¹ Σ (x_n - x̄) x u_n`` with ``J = Σ |r|² 1 - r rᵀ``, r = x_n - x̄. About axes where J says
    nothing (of one grid all, of grids in a line the line) θ is the mean of the grids' own rotations. Of one grid that
    leaves ``t = u + θ x (at - x)``.

    Parameters
    ----------
    position : [n, 3], grids, basic frame, m.
    at : [3], the point that t is of, basic frame, m.
    """
    count, middle = len(position), position.mean(axis=0)
    arm = position - middle
    inverse, blind = _rotation_of(arm)
    turn = np.stack([inverse @ cross_matrix(r) for r in arm])
    own = np.broadcast_to(blind / count, (count, 3, 3))
    shift = -cross_matrix(at - middle)  # θ x d = -d x θ
    return Follower(
        np.concatenate([np.eye(3) / count + shift @ turn, turn], axis=1), np.concatenate([shift @ own, own], axis=1)
    )


def needs_rotations(position: FloatArray) -> bool:
    """Whether the rotation of a body that follows grids at `position` [n, 3] (m) takes their own rotations."""
    return bool(own_rotation(position).any())


def own_rotation(position: FloatArray) -> FloatArray:
    """Projection [3, 3] on the axes about which a body turns as its grids at `position` [n, 3] (m) turn themselves.

    Basic frame; all of one grid, the line of grids in a line, none (0) of others.
    """
    return _rotation_of(position - position.mean(axis=0))[1]


def _rotation_of(arm: FloatArray) -> tuple[FloatArray, FloatArray]:
    """J⁺ [3, 3], and the projection [3, 3] on the axes that J says nothing about."""
    second = arm.T @ arm
    size, axes = np.linalg.eigh(np.trace(second) * np.eye(3) - second)
    known = size > max(_THIN**2 * size[-1], len(arm) * _POINT_M**2)
    lines = axes[:, known]
    return (lines / size[known]) @ lines.T, axes[:, ~known] @ axes[:, ~known].T


@dataclass(frozen=True, eq=False)
class TiedOperator:
    """What tied blocks add to the operator of one test mass.

    row : [m], ascending rows of the grid table; operator : [2, 3, m, 3], per displacement of these grids.
    lever : [l], ascending places in the table of grids with levers; rotation : [2, 3, l, 3], per rotation of these.
    Units and frames are those of `StructureGravity`.
    """

    row: IntArray
    operator: FloatArray
    lever: IntArray
    rotation: FloatArray


def tied_operator(
    test_mass: TestMass,
    blocks: Sequence[tuple[CompensationMass, SelfGravity, IntArray]],
    position: FloatArray,
    lever_node: IntArray,
) -> TiedOperator:
    """Operator of blocks that follow grids, from the field of each.

    A rigid block that moves by (t, θ) at its centre c changes the field as the opposite motion of the test mass about c
    would: all points of its quadrature, and so its own rotation and size, are in its field and stiffness (section 6.2).

    Parameters
    ----------
    blocks : each with its field on `test_mass` and the rows of its grids.
    position : [N, 3], grids, basic frame, m.
    lever_node : [L], ascending rows of the grids whose rotations are used; those that blocks need among them.
    """
    moved: list[tuple[IntArray, FloatArray]] = []
    turned: list[tuple[IntArray, FloatArray]] = []
    for block, field, nodes in blocks:
        by_motion = by_motion_of_source(test_mass, block.centre_m, field) @ np.kron(np.eye(2), test_mass.axes)
        follows = follower(position[nodes], block.centre_m)
        moved.append((nodes, by_motion @ follows.by_translation))
        if follows.by_rotation.any():
            turned.append((np.searchsorted(lever_node, nodes), by_motion @ follows.by_rotation))
    return TiedOperator(*_summed(moved), *_summed(turned))


def _summed(parts: Sequence[tuple[IntArray, FloatArray]]) -> tuple[IntArray, FloatArray]:
    """Ascending rows, and the sums [2, 3, n, 3] of what parts [m, 6, 3] have at each."""
    rows = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *(at for at, _ in parts)]))
    total = np.zeros((len(rows), 6, 3))
    for at, values in parts:
        total[np.searchsorted(rows, at)] += values
    return rows, np.asarray(total.reshape(len(rows), 2, 3, 3).transpose(1, 2, 0, 3))
