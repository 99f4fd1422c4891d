"""Whether the sums over the areas are what the unit loads say."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray

#: Largest difference, over the largest sensitivity of the block: results of solvers hold single precision.
LIMIT = 1e-6


def differences(found: FloatArray, wanted: FloatArray, block: Sequence[str], gradient: BoolArray) -> FloatArray:
    """|found - wanted| over the largest of its block, [r, k].

    Parameters
    ----------
    found, wanted : [r, k], sensitivities to the areas.
    block : [r], names of the rows that are measured together: of one quantity in one unit.
    gradient : [k], areas in K/m, which are measured apart from those in K.
    """
    out = np.asarray(np.abs(found - wanted))
    names = np.array(block)
    for name in dict.fromkeys(block):
        for kind in (False, True):
            part = np.ix_(names == name, gradient == kind)
            largest = np.abs(wanted[part]).max(initial=0.0)
            out[part] = np.divide(out[part], largest, out=np.where(out[part] > 0.0, np.inf, 0.0), where=largest > 0.0)
    return out
