"""Which column of a user's table holds the temperature of which thermal area."""

from __future__ import annotations

import difflib
from collections.abc import Sequence

import numpy as np

from tedm_cli.arrays import BoolArray, IndexArray
from tedm_cli.errors import InputError
from tedm_cli.noise.areas import AreaTable

ALL = "all"
_SHOWN = 6


def columns_of_areas(columns: Sequence[str], areas: AreaTable, needed: BoolArray, *, where: str) -> IndexArray:
    """Column [k] of every area that is needed, -1 for the others.

    A column is named after an area, a group, a shield (`inside`, `outside`) or `all`; the narrowest one counts. No two
    `columns` have one name.

    Raises
    ------
    InputError : a column that names nothing of the model, or a needed area without a column.
    """
    names = list(columns)
    known = [*areas.name.tolist(), *sorted(set(areas.group.tolist())), "inside", "outside", ALL]
    unknown = [name for name in names if name not in known]
    if unknown:
        near = difflib.get_close_matches(unknown[0], known, n=1)
        more = f" and {len(unknown) - 1} more" if len(unknown) > 1 else ""
        raise InputError(
            f"column {unknown[0]!r}{more} names no thermal area, group or shield",
            where=where,
            hint=(f"did you mean {near[0]}? " if near else "")
            + f"columns may be areas, groups ({', '.join(sorted(set(areas.group.tolist())))}), inside, outside or all",
        )
    index = np.full(len(areas), -1, dtype=np.intp)
    missing = []
    for area in np.flatnonzero(needed):
        keys = (str(areas.name[area]), str(areas.group[area]), str(areas.shield[area]), ALL)
        column = next((names.index(key) for key in keys if key in names), -1)
        index[area] = column
        if column < 0:
            missing.append(keys[0])
    if missing:
        shown = ", ".join(missing[:_SHOWN]) + (f" and {len(missing) - _SHOWN} more" if len(missing) > _SHOWN else "")
        raise InputError(
            f"no column for {len(missing)} of {len(areas)} thermal areas: {shown}",
            where=where,
            hint="add a column for each of them, for their group, for inside or outside, or for all",
        )
    return index
