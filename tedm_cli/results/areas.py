"""The thermal areas as a file tells them, and maps of what outputs feel of each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.contracts import AreaDatasets, AreaPlaces
from tedm_cli.files.store import Reader, Writer
from tedm_cli.noise.areas import AreaTable
from tedm_cli.results.units import units_of
from tedm_cli.symmetry_plane import BASIC_PLANE, SymmetryPlane


def read_areas(file: Reader) -> AreaTable:
    """The areas of any file of the build folder, in the order of its arrays over areas."""
    placed = file.has(AreaPlaces.PLANE_POINT)
    areas = AreaTable(
        name=np.array(file.strings(AreaDatasets.AREA_NAME)),
        group=np.array(file.strings(AreaDatasets.AREA_GROUP)),
        shield=np.array(file.strings(AreaDatasets.AREA_SHIELD)),
        side=np.array(file.strings(AreaDatasets.AREA_SIDE)),
        centroid_m=file.array(AreaPlaces.AREA_CENTROID) if placed else None,
        plane=read_plane(file) if placed else BASIC_PLANE,
        kind=np.array(file.strings(AreaDatasets.AREA_KIND)),
    )
    units_of(file, AreaDatasets.AREA_UNIT, areas.name.tolist(), areas.unit)
    return areas


def read_plane(file: Reader) -> SymmetryPlane:
    """The symmetry plane that a file's areas have their sides of."""
    return SymmetryPlane(file.array(AreaPlaces.PLANE_POINT), file.array(AreaPlaces.PLANE_NORMAL))


def plane_words(plane: SymmetryPlane, origin: str, layout: str) -> str:
    """Which symmetry plane it is, and where it is from; `layout`: name of the file where it is from one."""
    source = {
        "configured": "[areas] symmetry_plane",
        "layout": f"x-z plane of the layout frame in {layout}",
        "basic": "the default without a layout",
    }[origin]
    return f"{plane.words} in the basic frame ({source})"


def write_areas(writer: Writer, areas: AreaTable, area_id: IntArray) -> None:
    """The areas as `read_areas` reads them, and their numbers [k]; without their centroids."""
    writer.write(AreaDatasets.AREA_ID, area_id)
    writer.write(AreaDatasets.AREA_NAME, areas.name)
    writer.write(AreaDatasets.AREA_GROUP, areas.group)
    writer.write(AreaDatasets.AREA_SHIELD, areas.shield)
    writer.write(AreaDatasets.AREA_SIDE, areas.side)
    writer.write(AreaDatasets.AREA_KIND, areas.kind)
    writer.write(AreaDatasets.AREA_UNIT, areas.unit)


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
