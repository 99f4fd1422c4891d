"""Unit loads, one at a time, to the columns that they leave in the matrices, and to what their checks need.

[D] of a model has three numbers for each grid and area. What the chain goes on with is far less: a column of [S_SG],
and the motions of optical elements and of tied compensation masses. So results can be reduced where they are, and the
parts be put together elsewhere. Every area is reduced by itself; sums over areas are of each part.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.distortion import RigidFit
from tedm_cli.gravity.operator import contract
from tedm_cli.gravity.ties import Follower

_BLOCK = 65_536  # grids that are reduced at once: as `build-distortion` reads them


@dataclass(frozen=True, eq=False)
class FollowedGrids:
    """A tied compensation mass: rows [n] of its grids, and how it moves by them.

    turning : places of these grids among those with levers, where their rotations turn the block; else empty.
    """

    rows: IntArray
    follower: Follower
    turning: IntArray


@dataclass(frozen=True, eq=False)
class Reduction:
    """What displacements are reduced by; rows are of the grid table, G that of ``S = -G D``.

    operator : [r, N, 3], by translations, 1/s² and 1/(m s²); rotation : [r, L, 3], by rotations of `levers`.
    levers : [L], ascending rows of the grids whose rotations are used. optics : [E], rows of optical elements.
    blocks : tied compensation masses. fit : rigid motions of the model.
    """

    operator: FloatArray
    rotation: FloatArray
    levers: IntArray
    optics: IntArray
    blocks: tuple[FollowedGrids, ...]
    fit: RigidFit


@dataclass(frozen=True, eq=False, kw_only=True)
class Columns:
    """What a areas leave, per unit of their temperature (K; K/m of gradients), in their order.

    columns : [r, a], of -G D. optical_translation, optical_rotation : [a, E, 3], m and rad. blocks : [a, B, 6], motions
    of tied blocks. largest : [a], length of the largest translation, m. rigid_translation, rigid_rotation : [a, 3].
    """

    columns: FloatArray
    optical_translation: FloatArray
    optical_rotation: FloatArray
    blocks: FloatArray
    largest: FloatArray
    rigid_translation: FloatArray
    rigid_rotation: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Sums:
    """Sums over areas of mean temperatures, and which grids with levers move and turn under any load.

    total : [N, 3] and size : [N], of translations and their lengths, m/K. total_turn : [L, 3] and turn_size : [L], of
    the rotations of grids with levers, rad/K. moving, turned : [L].
    """

    total: FloatArray
    size: FloatArray
    total_turn: FloatArray
    turn_size: FloatArray
    moving: BoolArray
    turned: BoolArray

    def __add__(self, other: Sums) -> Sums:
        return Sums(
            total=self.total + other.total,
            size=self.size + other.size,
            total_turn=self.total_turn + other.total_turn,
            turn_size=self.turn_size + other.turn_size,
            moving=self.moving | other.moving,
            turned=self.turned | other.turned,
        )


def reduced(motions: Iterable[tuple[float, bool, FloatArray, FloatArray]], by: Reduction) -> tuple[Columns, Sums]:
    """Columns of the areas in the order of `motions`, and their sums.

    Parameters
    ----------
    motions : of each area its temperature step (K; K/m), whether that is a mean temperature, and translations [N,3] (m)
        and rotations [N,3] (rad) of the grids in the basic frame, finite. One is held at a time.
    by : the operator and the rows.
    """
    n_nodes, levers = by.operator.shape[1], by.levers
    found: list[tuple[FloatArray, ...]] = []
    moments: list[FloatArray] = []
    sums = _none(n_nodes, len(levers))
    for load, is_mean, translation, rotation in motions:
        turn = rotation[levers] / load
        column = contract(by.rotation, turn[None])[:, 0]
        moment, largest = np.zeros((4, 3)), 0.0
        for start in range(0, n_nodes, _BLOCK):
            block = slice(start, min(start + _BLOCK, n_nodes))
            move = translation[block] / load
            length = np.sqrt(np.einsum("ni,ni->n", move, move))
            largest = max(largest, float(length.max()))
            column += contract(by.operator[:, block], move[None])[:, 0]
            moment += by.fit.moments(block, move)
            if is_mean:
                sums.total[block] += move
                sums.size[block] += length
        at_levers = translation[levers]
        sums.moving[:] |= np.any(at_levers != 0.0, axis=1)
        sums.turned[:] |= np.any(turn != 0.0, axis=1)
        if is_mean:
            sums.total_turn[:] += turn
            sums.turn_size[:] += np.linalg.norm(turn, axis=1)
        blocks = [_followed(block, translation[block.rows] / load, turn) for block in by.blocks]
        optics = (translation[by.optics] / load, rotation[by.optics] / load)
        found.append((column, *optics, np.array(blocks).reshape(len(by.blocks), 6), np.array(largest)))
        moments.append(moment)
    rigid = by.fit.motions(np.array(moments)) if moments else (np.zeros((0, 3)), np.zeros((0, 3)))
    shapes = ((len(by.operator),), (len(by.optics), 3), (len(by.optics), 3), (len(by.blocks), 6), ())
    parts = [np.array([one[i] for one in found]).reshape(len(found), *shape) for i, shape in enumerate(shapes)]
    columns = Columns(
        columns=np.ascontiguousarray(parts[0].T),
        optical_translation=parts[1],
        optical_rotation=parts[2],
        blocks=parts[3],
        largest=parts[4],
        rigid_translation=rigid[0],
        rigid_rotation=rigid[1],
    )
    return columns, sums


def joined(parts: Sequence[tuple[IntArray, Columns]]) -> Columns:
    """The columns of several parts, each with the places of its areas; all places from 0 on, each once."""
    order = np.argsort(np.concatenate([places for places, _ in parts]), kind="stable")

    def along(name: str, axis: int) -> FloatArray:
        whole = np.concatenate([getattr(columns, name) for _, columns in parts], axis=axis)
        return np.ascontiguousarray(np.take(whole, order, axis=axis))

    return Columns(
        columns=along("columns", 1),
        optical_translation=along("optical_translation", 0),
        optical_rotation=along("optical_rotation", 0),
        blocks=along("blocks", 0),
        largest=along("largest", 0),
        rigid_translation=along("rigid_translation", 0),
        rigid_rotation=along("rigid_rotation", 0),
    )


def _none(n_nodes: int, levers: int) -> Sums:
    return Sums(
        total=np.zeros((n_nodes, 3)),
        size=np.zeros(n_nodes),
        total_turn=np.zeros((levers, 3)),
        turn_size=np.zeros(levers),
        moving=np.zeros(levers, dtype=bool),
        turned=np.zeros(levers, dtype=bool),
    )


def _followed(block: FollowedGrids, translation: FloatArray, turn: FloatArray) -> FloatArray:
    """(t, θ) [6] of a block, by the motions of its grids and the rotations of all grids with levers, per unit."""
    own = turn[block.turning] if block.turning.size else np.zeros_like(translation)
    moved: FloatArray = block.follower.motion(translation[None], own[None])[0]
    return moved
