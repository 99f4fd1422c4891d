"""distortion.h5: the distortion matrix."""

from __future__ import annotations

from tedm_cli.contracts.spec import (
    BASIC,
    ID,
    NAMES,
    ON_GRIDS,
    PER_AREA,
    TURN_PER_AREA,
    AreaDatasets,
    AreaPlaces,
    Dataset,
    FileKind,
    GridIds,
    Values,
)
from tedm_cli.contracts.unit_loads import UNIT_LOADS

_OPTICS = "optics"  # absent where the project has none


class DistortionFile(AreaPlaces, AreaDatasets, GridIds, FileKind):
    """Its datasets by name; `DISTORTION` is the kind of file."""

    D_TRANSLATION = Dataset(
        "/D/translation",
        ("area", "node", "xyz"),
        "real",
        PER_AREA,
        "distortion matrix [D]: translation per /area/unit of an area; not kept by `tedm merge`",
        BASIC,
        True,
        group=ON_GRIDS,
        view_of=(UNIT_LOADS.name, UNIT_LOADS.TRANSLATION),  # where every load is of 1 K: the same numbers
    )
    D_OFFSET_NODE = Dataset(
        "/D/offset_node",
        ("offset_node",),
        "int",
        "1",
        "rows of /grid from which something with mass is offset, or that turn a tied compensation mass",
        values=Values(rows_of="node", ascending=True),
    )
    D_ROTATION = Dataset(
        "/D/rotation",
        ("area", "offset_node", "xyz"),
        "float",
        TURN_PER_AREA,
        "rotation of these grids per /area/unit of an area",
        BASIC,
        True,
        group=ON_GRIDS,
    )
    OPTICAL_NAME = Dataset(
        "/optical/name", ("optical",), "str", "1", "optical element", optional=True, values=NAMES, group=_OPTICS
    )
    OPTICAL_GRID = Dataset(
        "/optical/grid",
        ("optical",),
        "int",
        "1",
        "Nastran grid that carries the element's motion",
        optional=True,
        values=ID,
        group=_OPTICS,
    )
    OPTICAL_AREA = Dataset(
        "/optical/area",
        ("optical",),
        "str",
        "1",
        "thermal areas of a mean temperature that this grid is in, with a comma between; empty: in none",
        optional=True,
        group="areas of the optics",
    )
    OPTICAL_POSITION = Dataset(
        "/optical/position", ("optical", "xyz"), "float", "m", "position of that grid", BASIC, True, group=_OPTICS
    )
    D_OPT_TRANSLATION = Dataset(
        "/D_opt/translation",
        ("area", "optical", "xyz"),
        "float",
        PER_AREA,
        "translation of the optical elements per /area/unit",
        BASIC,
        True,
        group=_OPTICS,
    )
    D_OPT_ROTATION = Dataset(
        "/D_opt/rotation",
        ("area", "optical", "xyz"),
        "float",
        TURN_PER_AREA,
        "rotation of the optical elements per /area/unit",
        BASIC,
        True,
        group=_OPTICS,
    )
    CHECK_SUPERPOSITION_TRANSLATION = Dataset(
        "/check/superposition_translation",
        (),
        "float",
        "1",
        "largest |sum over mean areas - uniform| over the largest |uniform|, translations",
        optional=True,
    )
    CHECK_SUPERPOSITION_OPTICS = Dataset(
        "/check/superposition_optics",
        (),
        "float",
        "1",
        "the same for the rotations of the optical elements, where there are any",
        optional=True,
        group="superposition of the optics",
    )
    CHECK_MAX_TRANSLATION = Dataset(
        "/check/max_translation", ("area",), "float", PER_AREA, "largest translation of any grid"
    )
    CHECK_RIGID_TRANSLATION = Dataset(
        "/check/rigid_translation",
        ("area", "xyz"),
        "float",
        PER_AREA,
        "translation of the best-fit rigid motion at the centre of gravity",
        BASIC,
    )
    CHECK_RIGID_ROTATION = Dataset(
        "/check/rigid_rotation", ("area", "xyz"), "float", TURN_PER_AREA, "rotation of the best-fit rigid motion", BASIC
    )


DISTORTION = DistortionFile("distortion", 5, "tedm build-distortion")
