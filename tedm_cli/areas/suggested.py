"""Names of suggested thermal areas: those of the areas that their grids are in, so that rules by name still apply."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.area_names import LONGEST
from tedm_cli.arrays import FloatArray, IntArray


def suggested_names(
    label: IntArray, area: IntArray, volume: FloatArray, names: Sequence[str]
) -> tuple[list[str], IntArray]:
    """A name for each of the m new areas: that of the old one with most of its volume, numbered where several have it.

    Parameters
    ----------
    label : [n], number from 0 on of the new area of each grid; they are numbered in this order.
    area : [n], row among `names` of its old one. volume : [n], of the grids.
    names : of all old areas; a number makes no name that is among them.

    Returns
    -------
    Names, and the row of the old area that each is of, [m].
    """
    most = np.zeros((label.max(initial=-1) + 1, len(names)))
    np.add.at(most, (label, area), volume)
    origin = np.asarray(most.argmax(axis=1), dtype=np.int64)
    shared = np.bincount(origin, minlength=len(names)) > 1
    taken = {name.upper() for name in names}  # Nastran does not tell upper from lower case in labels
    last = [0] * len(names)
    out = []
    for old in origin.tolist():
        name = names[old]
        while shared[old] and name.upper() in taken:
            last[old] += 1
            suffix = f".{last[old]}"
            name = names[old][: LONGEST - len(suffix)].rstrip() + suffix
        taken.add(name.upper())
        out.append(name)
    return out, origin
