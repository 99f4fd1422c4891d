"""The thermal areas as a file tells them, and maps of what outputs feel of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

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
    """Order of the areas with groups together: groups as they first appear, gradients last, areas by name inside."""
    groups = areas.group_by_unit
    first = list(dict.fromkeys([*groups[~areas.gradient], *groups[areas.gradient]]))
    return np.array(sorted(range(len(areas)), key=lambda i: (first.index(groups[i]), areas.name[i])))


def per_area(areas: AreaTable) -> str:
    """What numbers by area are per, as descriptions of matrices say it."""
    return "per K/m of a gradient area, per kelvin of any other" if areas.gradient.any() else "per kelvin of an area"


def unit_per(unit: str, of_area: str) -> str:
    """A unit per that of an area's temperature: `m/K`, and of a gradient `m/(K/m)`."""
    return f"{unit}/({of_area})" if "/" in of_area else f"{unit}/{of_area}"


@dataclass(frozen=True, eq=False)
class AreaMap:
    """|value| [rows, k] of outputs per kelvin of each area; one panel of a map, so all rows share one unit."""

    title: str
    unit: str
    labels: list[str]
    value: FloatArray


def maps_by_kind(maps: Sequence[AreaMap], areas: AreaTable) -> list[tuple[str, str, list[AreaMap], AreaTable]]:
    """Maps of means, and apart from them those of gradients, whose unit is another, as far as there are such areas.

    Of each: what the names of figures end with, what the areas are called, its maps, and its areas.
    """
    found = []
    for mask, suffix, noun in ((~areas.gradient, "", "thermal area"), (areas.gradient, "_gradients", "gradient area")):
        if mask.any():
            own = areas.only(mask)
            mine = [
                replace(m, unit=unit_per(m.unit.removesuffix("/K"), own.unit[0]), value=m.value[:, mask]) for m in maps
            ]
            found.append((suffix, noun, mine, own))
    return found
