"""Which thermal areas correlation cases treat alike: areas that are made of several of them keep their meaning."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.correlation import CorrelationCase
from tedm_cli.noise.selection import select


def told_apart(areas: AreaTable, cases: Sequence[CorrelationCase], amplitude: FloatArray) -> IntArray:
    """Number [k], from 0 on, of what the areas that nothing tells apart have in common.

    That is their kind, group and shield, their spectrum, the blocks and delays of the cases that take them, and their
    side where a block is divided by sides or into mirror pairs. Areas that a case lets stand alone are alike: how
    many there are of these is what a choice of areas decides. Matrices of a case name areas one by one; they are not
    looked at.

    Parameters
    ----------
    amplitude : [n, k], of the temperatures of the areas at n frequencies.
    """
    columns: list[list[str]] = [c.tolist() for c in (areas.kind, areas.group, areas.shield)]
    columns += [[f"{value:.9g}" for value in row] for row in amplitude.tolist()]
    for case in cases:
        for selector in (*case.blocks, *(selector for selector, _ in case.delays)):
            taken = select(selector, areas)[0]
            by_side = taken & (selector.partition in ("side", "mirror"))
            columns.append(np.where(by_side, areas.side, taken.astype(str)).tolist())
    keys = list(zip(*columns, strict=True))
    number = {key: i for i, key in enumerate(dict.fromkeys(keys))}
    return np.array([number[key] for key in keys], dtype=np.int64)


def paired(areas: AreaTable, cases: Sequence[CorrelationCase]) -> BoolArray:
    """Areas [k] of which a case asks for mirror images, found by their centroids."""
    out = np.zeros(len(areas), dtype=bool)
    for case in cases:
        for selector in case.blocks:
            if selector.partition == "mirror" and not selector.mirror_names:
                out |= select(selector, areas)[0]
    return out
