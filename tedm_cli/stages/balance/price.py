"""What blocks that move cost: the sensitivity to temperature that they add to the test masses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.contracts import BALANCE, DISTORTION, SENSITIVITY, UNIT_LOADS
from tedm_cli.files.blocks import SomeNodes
from tedm_cli.files.store import Reader, Writer
from tedm_cli.gravity.compensation import CompensationMass
from tedm_cli.gravity.operator import contract
from tedm_cli.gravity.structure import stack_rows
from tedm_cli.gravity.ties import needs_rotations, tied_operator
from tedm_cli.results.gravity.self_gravity import read_self_gravity
from tedm_cli.stages.balance.rest import Rest, field_of_each


@dataclass(frozen=True, eq=False)
class Price:
    """[S_SG] without the blocks and what those that are tied add to it, [6 t, k], by row and area.

    left_out : blocks whose grids are in a line, and do not say how they turn.
    """

    label: list[str]
    unit: list[str]
    area: list[str]
    without: FloatArray
    added: FloatArray
    left_out: list[str]


def thermal_price(
    rest: Rest, blocks: Sequence[CompensationMass], sensitivity: Reader, distortion: Reader, unit: Reader
) -> Price | None:
    """Of tied blocks; None where none is tied."""
    position, ids = unit.array(UNIT_LOADS.GRID_POSITION), unit.array(UNIT_LOADS.GRID_ID)
    rows = {block.name: _rows(block, ids) for block in blocks if block.tie is not None}
    turning = [name for name, own in rows.items() if needs_rotations(position[own])]
    tied = [block for block in blocks if block.name in rows and block.name not in turning]
    if not rows:
        return None
    fields = field_of_each(rest.config, rest.test_masses, tied)
    operators = [
        tied_operator(tm, [(b, f, rows[b.name]) for b, f in zip(tied, own, strict=True)], position, ids[:0])
        for tm, own in zip(rest.test_masses, fields, strict=True)
    ]
    found = read_self_gravity(sensitivity)
    added = np.zeros_like(found.S)
    if tied:
        some, d = SomeNodes(operators[0].row), distortion.dataset(DISTORTION.D_TRANSLATION)
        g = stack_rows([o.operator for o in operators])
        for area in range(d.shape[0]):
            added[:, area] = contract(g, some.read(d, area)[None])[:, 0]
    return Price(found.label, found.unit, sensitivity.strings(SENSITIVITY.AREA_NAME), found.S, added, turning)


def _rows(block: CompensationMass, ids: IntArray) -> IntArray:
    """Rows of the grids that a block is tied to by their numbers."""
    assert block.tie is not None
    chosen = np.zeros(len(ids), dtype=bool)
    for low, high in block.tie.ids:
        chosen |= (ids >= low) & (ids <= high)
    return np.flatnonzero(chosen)


def write_price(writer: Writer, price: Price) -> None:
    """The price, where there is one."""
    writer.write(BALANCE.PRICE_ROW, price.label)
    writer.write(BALANCE.PRICE_UNIT, price.unit)
    writer.write(BALANCE.PRICE_AREA, price.area)
    writer.write(BALANCE.S_WITHOUT, price.without, units="see /thermal/unit")
    writer.write(BALANCE.S_ADDED, price.added, units="see /thermal/unit")
