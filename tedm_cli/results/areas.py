"""The thermal areas as a file tells them, and maps of what outputs feel of each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.files.store import Reader
from tedm_cli.noise.areas import AreaTable


def read_areas(file: Reader) -> AreaTable:
    """The areas of any file of the build folder, in the order of its arrays over areas."""
    columns = {c: np.array(file.strings(f"/area/{c}")) for c in ("name", "group", "shield", "side")}
    return AreaTable(**columns, centroid_m=file.array("/area/centroid") if file.has("/area/centroid") else None)


def by_group(areas: AreaTable) -> IntArray:
    """Order of the areas with groups together: groups as they first appear, areas by name inside."""
    first = list(dict.fromkeys(areas.group))
    return np.array(sorted(range(len(areas)), key=lambda i: (first.index(areas.group[i]), areas.name[i])))


@dataclass(frozen=True, eq=False)
class AreaMap:
    """|value| [rows, k] of outputs per kelvin of each area; one panel of a map, so all rows share one unit."""

    title: str
    unit: str
    labels: list[str]
    value: FloatArray
