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

_AREAS = 8  # areas that are held at once, and contracted with the operator together
_BLOCK = 4_096  # grids of these that stay in a processor's cache


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
        and rotations [N,3] (rad) of the grids in the basic frame, finite. A few are held at a time.
    by : the operator and the rows.
    """
    work = _Held(by)
    for load, is_mean, translation, rotation in motions:
        work.take(load, is_mean, translation, rotation)
    return work.columns(), work.sums


class _Held:
    """A few areas at a time: the operator is larger than the motions of an area, and is read once for all of them."""

    def __init__(self, by: Reduction) -> None:
        n_nodes, levers = by.operator.shape[1], len(by.levers)
        self._by = by
        self._move, self._turn = np.empty((_AREAS, n_nodes, 3)), np.empty((_AREAS, levers, 3))
        self._of_mean: list[bool] = []
        self._gathered: list[tuple[FloatArray, FloatArray, FloatArray]] = []
        self._contracted: list[tuple[FloatArray, FloatArray, FloatArray]] = []
        self.sums = _none(n_nodes, levers)

    def take(self, load: float, is_mean: bool, translation: FloatArray, rotation: FloatArray) -> None:
        by, place = self._by, len(self._of_mean)
        move, turn = self._move[place], self._turn[place]
        np.divide(translation, load, out=move)
        np.divide(rotation[by.levers], load, out=turn)
        blocks = [_followed(block, move[block.rows], turn) for block in by.blocks]
        self._gathered.append((move[by.optics], rotation[by.optics] / load, np.array(blocks).reshape(-1, 6)))
        self._of_mean.append(is_mean)
        self.sums.moving[:] |= np.any(move[by.levers] != 0.0, axis=1)
        self.sums.turned[:] |= np.any(turn != 0.0, axis=1)
        if is_mean:
            self.sums.total_turn[:] += turn
            self.sums.turn_size[:] += np.linalg.norm(turn, axis=1)
        if len(self._of_mean) == _AREAS:
            self._contract()

    def _contract(self) -> None:
        by, held, sums = self._by, len(self._of_mean), self.sums
        column = contract(by.rotation, self._turn[:held])
        moments, largest = np.zeros((held, 4, 3)), np.zeros(held)
        for start in range(0, len(sums.size), _BLOCK):
            block = slice(start, start + _BLOCK)
            move = self._move[:held, block]
            length = np.sqrt(np.einsum("ani,ani->an", move, move))
            np.maximum(largest, length.max(axis=1), out=largest)
            column += contract(by.operator[:, block], move)
            for area, is_mean in enumerate(self._of_mean):
                moments[area] += by.fit.moments(block, move[area])
                if is_mean:
                    sums.total[block] += move[area]
                    sums.size[block] += length[area]
        self._contracted.append((column.T, moments, largest))
        self._of_mean = []

    def columns(self) -> Columns:
        """Those of all areas that were taken."""
        if self._of_mean:
            self._contract()
        by = self._by
        summed: list[tuple[int, ...]] = [(len(by.operator),), (4, 3), ()]
        column, moments, largest = (_stacked([one[i] for one in self._contracted], s) for i, s in enumerate(summed))
        kept: list[tuple[int, ...]] = [(len(by.optics), 3), (len(by.optics), 3), (len(by.blocks), 6)]
        translation, rotation, blocks = (
            _stacked([one[i][None] for one in self._gathered], s) for i, s in enumerate(kept)
        )
        rigid = by.fit.motions(moments) if len(moments) else (np.zeros((0, 3)), np.zeros((0, 3)))
        return Columns(
            columns=np.ascontiguousarray(column.T),
            optical_translation=translation,
            optical_rotation=rotation,
            blocks=blocks,
            largest=largest,
            rigid_translation=rigid[0],
            rigid_rotation=rigid[1],
        )


def _stacked(parts: Sequence[FloatArray], shape: tuple[int, ...]) -> FloatArray:
    """Arrays [n, *shape] one after the other, of which there may be none."""
    return np.concatenate([np.zeros((0, *shape)), *parts])


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
