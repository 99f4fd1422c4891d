"""Compensation masses in sensitivity.h5: what the tied ones add to the operator, and how each moves per kelvin."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.contracts import DISTORTION, SENSITIVITY
from tedm_cli.files.blocks import SomeNodes
from tedm_cli.files.store import Reader, Writer
from tedm_cli.gravity.compensation import BlockQuadrature, CompensationMass
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.gravity.ties import TiedOperator, follower, needs_rotations, tied_operator
from tedm_cli.results.gravity.ties import Ties


def tied_operators(
    test_masses: Sequence[TestMass],
    blocks: Sequence[CompensationMass],
    quadrature: Sequence[BlockQuadrature],
    ties: Ties,
    position: FloatArray,
    lever_node: IntArray,
) -> list[TiedOperator]:
    """What tied blocks add to the operator of each test mass; `quadrature`: of all blocks, test mass by test mass."""
    found = []
    for t, tm in enumerate(test_masses):
        own = quadrature[t * len(blocks) : (t + 1) * len(blocks)]
        moved = [(block, how.field, ties.rows(block.name)) for block, how in zip(blocks, own, strict=True) if block.tie]
        found.append(tied_operator(tm, moved, position, lever_node))
    return found


def write_blocks(
    writer: Writer,
    blocks: Sequence[CompensationMass],
    ties: Ties,
    distortion: Reader,
    position: FloatArray,
    moved: FloatArray | None,
) -> None:
    """Where each block is, what it follows, and its motion by that; `moved` [k, B, 6]: that of the tied ones in their
    order, where there is no [D] to tell it."""
    rows = [ties.rows(block.name) for block in blocks]
    writer.write(SENSITIVITY.COMPENSATION_NAME, [b.name for b in blocks])
    writer.write(SENSITIVITY.COMPENSATION_CENTRE, np.array([b.centre_m for b in blocks]).reshape(-1, 3))
    writer.write(SENSITIVITY.COMPENSATION_SIZE, np.array([b.size_m for b in blocks]).reshape(-1, 3))
    writer.write(SENSITIVITY.COMPENSATION_AXES, np.array([b.axes for b in blocks]).reshape(-1, 3, 3))
    writer.write(SENSITIVITY.COMPENSATION_MASS, np.array([b.mass_kg for b in blocks], dtype=float))
    writer.write(SENSITIVITY.COMPENSATION_TIE, ["" if b.tie is None else b.tie.words for b in blocks])
    writer.write(SENSITIVITY.COMPENSATION_NODE_OFFSET, np.cumsum([0, *map(len, rows)]))
    writer.write(SENSITIVITY.COMPENSATION_NODE_INDEX, np.concatenate([np.zeros(0, dtype=np.int64), *rows]))
    areas = len(distortion.strings(DISTORTION.AREA_NAME))
    motion = np.zeros((areas, len(blocks), 6))
    tied = [number for number, block in enumerate(blocks) if block.tie]
    for place, number in enumerate(tied):
        nodes, centre = rows[number], blocks[number].centre_m
        motion[:, number] = _motion(distortion, nodes, position[nodes], centre) if moved is None else moved[:, place]
    writer.write(SENSITIVITY.COMPENSATION_TRANSLATION, motion[..., :3])
    writer.write(SENSITIVITY.COMPENSATION_ROTATION, motion[..., 3:])


def _motion(distortion: Reader, nodes: IntArray, position: FloatArray, centre: FloatArray) -> FloatArray:
    """(t, θ) [k, 6] of a block that follows `nodes`, per kelvin of each area."""
    d, turns = distortion.dataset(DISTORTION.D_TRANSLATION), distortion.dataset(DISTORTION.D_ROTATION)
    some, areas = SomeNodes(nodes), range(d.shape[0])
    moved = np.array([some.read(d, area) for area in areas])
    turned = np.zeros_like(moved)
    if needs_rotations(position):
        some = SomeNodes(np.searchsorted(distortion.array(DISTORTION.D_OFFSET_NODE), nodes))
        turned = np.array([some.read(turns, area) for area in areas])
    return follower(position, centre).motion(moved, turned)
