"""Whether the sums over the areas are what the unit loads say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray

#: Largest difference, over the largest sensitivity of the block, that is allowed in any case.
LIMIT = 1e-6


@dataclass(frozen=True, eq=False)
class Agreement:
    """Of r outputs and k areas, over the largest sensitivity of the block of each; [r, k].

    difference : |found - wanted|. allowed : `LIMIT`, or what the rounding of the results makes, where that is more.
    """

    difference: FloatArray
    allowed: FloatArray

    @property
    def worst(self) -> tuple[int, int]:
        """Row and column of the difference that is largest over what is allowed."""
        row, column = np.unravel_index((self.difference / self.allowed).argmax(), self.difference.shape)
        return int(row), int(column)


def agreement(
    found: FloatArray, wanted: FloatArray, rounding: FloatArray, block: Sequence[str], gradient: BoolArray
) -> Agreement:
    """Hold sensitivities to the areas against those of the unit loads.

    Parameters
    ----------
    found, wanted : [r, k].
    rounding : [r, k], how far the wanted ones may be off because displacements are in single precision: `ROUNDING` of
        tedm_cli.distortion times the sum of the sizes of their terms.
    block : [r], names of the rows that are measured together: of one quantity in one unit.
    gradient : [k], areas in K/m, which are measured apart from those in K.
    """
    size = np.empty_like(wanted)
    names = np.array(block)
    for name in dict.fromkeys(block):
        for kind in (False, True):
            part = np.ix_(names == name, gradient == kind)
            size[part] = np.abs(wanted[part]).max(initial=0.0)
    there = size > 0.0
    error = np.abs(found - wanted)
    difference = np.divide(error, size, out=np.where(error > 0.0, np.inf, 0.0), where=there)
    explained = np.divide(rounding, size, out=np.zeros_like(size), where=there)
    return Agreement(difference, np.maximum(LIMIT, explained))
