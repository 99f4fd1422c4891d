"""Names of suggested thermal areas: of the areas that their grids are in, so that rules by name still apply."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

import numpy as np

from tedm_cli.area_names import LONGEST
from tedm_cli.arrays import FloatArray, IntArray

_MOSTLY = 0.9  # of an area's volume


def suggested_names(
    label: IntArray, area: IntArray, volume: FloatArray, names: Sequence[str], fits: Callable[[str, str], bool]
) -> tuple[list[str], IntArray]:
    """A name for each of the m new areas, by the old ones that have 90 % of its volume.

    Of one old area its name, with a number where several new ones have it: `FLANGE_1.2`. Of several what their names
    begin with, and a number: `OB_1`, where that fits; else the name of the largest.

    Parameters
    ----------
    label : [n], number from 0 on of the new area of each grid; they are numbered in this order.
    area : [n], row among `names` of its old one. volume : [n], of the grids. names : of all old areas.
    fits : whether a name means to the rules of the model what an old one does.

    Returns
    -------
    Names, none of them that of another old area, and the row of the largest old area of each, [m].
    """
    parts = np.zeros((label.max(initial=-1) + 1, len(names)))
    np.add.at(parts, (label, area), volume)
    origin = np.asarray(parts.argmax(axis=1), dtype=np.int64)
    stems = [_stem(row, names, fits) for row in parts]
    taken = {name.upper() for name in names}  # Nastran does not tell upper from lower case in labels
    last: dict[str, int] = {}
    out = []
    for stem in stems:
        name = stem
        if stem not in names or stems.count(stem) > 1:
            while name == stem or name.upper() in taken:
                last[stem] = last.get(stem, 0) + 1
                number = f"{last[stem]}" if stem not in names else f".{last[stem]}"
                name = stem[: LONGEST - len(number)].rstrip() + number
        taken.add(name.upper())
        out.append(name)
    return out, origin


def _stem(part: FloatArray, names: Sequence[str], fits: Callable[[str, str], bool]) -> str:
    """What the name of a new area begins with, by the volume of each old one in it."""
    order = np.argsort(-part, kind="stable")
    most = int(np.searchsorted(part[order].cumsum(), _MOSTLY * part.sum())) + 1
    largest = str(names[order[0]])
    if most == 1:
        return largest
    length = len(largest)
    while any(not names[a].startswith(largest[:length]) for a in order[:most]):
        length -= 1
    found = re.match(r".*[_.+/:() -]", largest[:length])
    return found[0] if found and fits(f"{found[0]}1", largest) else largest
