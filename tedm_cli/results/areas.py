"""The thermal areas as a file tells them, and maps of what outputs feel of each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.files.store import Reader, Writer
from tedm_cli.noise.areas import AreaTable


def read_areas(file: Reader) -> AreaTable:
    """The areas of any file of the build folder, in the order of its arrays over areas."""
    return AreaTable(
        name=np.array(file.strings("/area/name")),
        group=np.array(file.strings("/area/group")),
        shield=np.array(file.strings("/area/shield")),
        side=np.array(file.strings("/area/side")),
        centroid_m=file.array("/area/centroid") if file.has("/area/centroid") else None,
    )


def write_areas(writer: Writer, areas: AreaTable, area_id: IntArray) -> None:
    """The areas as `read_areas` reads them, and their numbers [k]; without their centroids."""
    writer.write("/area/id", area_id)
    writer.write("/area/name", areas.name)
    writer.write("/area/group", areas.group)
    writer.write("/area/shield", areas.shield)
    writer.write("/area/side", areas.side)


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
