"""S = -G D, with D read in tiles of some areas and grids."""

from __future__ import annotations

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.contracts import DISTORTION, SENSITIVITY
from tedm_cli.errors import InputError
from tedm_cli.files.blocks import BLOCK_NODES, node_blocks
from tedm_cli.files.store import Reader, Writer
from tedm_cli.gravity.operator import contract
from tedm_cli.gravity.structure import StructureGravity, stack_rows
from tedm_cli.gravity.ties import TiedOperator
from tedm_cli.progress import Step, counter

TILE_AREAS = 32  # areas of D held at a time
_UNIT = "1/s^2 (a) or 1/(m s^2) (omegadot), see /row/label"
_TURN_UNIT = "m/s^2 (a) or 1/s^2 (omegadot) per rad, see /row/label"


def self_gravity_sensitivity(
    found: list[StructureGravity],
    tied: list[TiedOperator],
    lever_nodes: IntArray,
    distortion: Reader,
    writer: Writer,
    step: Step,
) -> FloatArray:
    """S [6 t,k] of t test masses; the operator, 24 numbers per grid and test mass, is held and written.

    `tied`: what compensation masses that follow grids add to the operator of each test mass.

    An element's mass acts on all its grids, so no block of G is complete before the last element.
    """
    offset_nodes = distortion.array(DISTORTION.D_OFFSET_NODE)
    if not np.array_equal(offset_nodes, lever_nodes):
        raise InputError(
            "lacks the rotations of the grids that carry offset masses or turn tied compensation masses",
            where=str(distortion.path),
            hint=f"rebuild it with `{distortion.kind.made_by}`, or `tedm run`",
        )
    writer.write(SENSITIVITY.OPERATOR_OFFSET_NODE, offset_nodes)
    parts = (
        (
            DISTORTION.D_ROTATION,
            [s.rotation for s in found],
            (tied[0].lever, stack_rows([t.rotation for t in tied])),
            SENSITIVITY.OPERATOR_G_ROTATION,
            _TURN_UNIT,
        ),
        (
            DISTORTION.D_TRANSLATION,
            [s.operator for s in found],
            (tied[0].row, stack_rows([t.operator for t in tied])),
            SENSITIVITY.OPERATOR_G,
            _UNIT,
        ),
    )
    areas = distortion.dataset(DISTORTION.D_TRANSLATION).shape[0]
    total = np.zeros((6 * len(found), areas))
    work = sum(part[0].shape[2] for _, part, *_ in parts) * areas
    advance = counter(step, work, "contracting S = -G D")
    for path, operators, (more_at, more), target, unit in parts:
        d, n_nodes = distortion.dataset(path), operators[0].shape[2]
        g = writer.allocate(target, (len(total), n_nodes, 3), units=unit)
        room = d.empty((min(areas, TILE_AREAS) * min(n_nodes, BLOCK_NODES) * 3,))
        for block in node_blocks(n_nodes, BLOCK_NODES):
            g_block = stack_rows([part[:, :, block] for part in operators])
            there = slice(*np.searchsorted(more_at, (block.start, block.stop)))
            g_block[:, more_at[there] - block.start] += more[:, there]
            g[:, block] = g_block
            for some in node_blocks(areas, TILE_AREAS):
                shape = (some.stop - some.start, block.stop - block.start, 3)
                tile = room[: shape[0] * shape[1] * 3].reshape(shape)
                d.read_into(tile, np.s_[some, block])
                total[:, some] += contract(g_block, tile)
                advance(shape[0] * shape[1])
    return total


def write_operator(writer: Writer, operator: FloatArray, rotation: FloatArray, lever_nodes: IntArray) -> None:
    """The operator [6 t, N, 3] and [6 t, L, 3] where there is no [D] to contract."""
    writer.write(SENSITIVITY.OPERATOR_OFFSET_NODE, lever_nodes)
    writer.write(SENSITIVITY.OPERATOR_G_ROTATION, rotation, units=_TURN_UNIT)
    writer.write(SENSITIVITY.OPERATOR_G, operator, units=_UNIT)
