"""distortion.h5: the distortion matrix."""

from __future__ import annotations

from tedm_cli.contracts.spec import AREAS, BASIC, GRID, ID, NAMES, Dataset, FileKind, Values

DISTORTION = FileKind(
    "distortion",
    3,
    "tedm build-distortion",
    {
        "/grid/id": GRID["/grid/id"],
        **AREAS,
        "/D/translation": Dataset(
            ("area", "node", "xyz"), "real", "m/K", "distortion matrix [D]: translation per kelvin of an area", BASIC
        ),
        "/D/offset_node": Dataset(
            ("offset_node",),
            "int",
            "1",
            "rows of /grid from which something with mass is offset",
            values=Values(rows_of="node", ascending=True),
        ),
        "/D/rotation": Dataset(
            ("area", "offset_node", "xyz"), "float", "rad/K", "rotation of these grids per kelvin of an area", BASIC
        ),
        "/optical/name": Dataset(("optical",), "str", "1", "optical element", values=NAMES),
        "/optical/grid": Dataset(("optical",), "int", "1", "Nastran grid that carries the element's motion", values=ID),
        "/optical/position": Dataset(("optical", "xyz"), "float", "m", "position of that grid", BASIC),
        "/D_opt/translation": Dataset(
            ("area", "optical", "xyz"), "float", "m/K", "translation of the optical elements per kelvin", BASIC
        ),
        "/D_opt/rotation": Dataset(
            ("area", "optical", "xyz"), "float", "rad/K", "rotation of the optical elements per kelvin", BASIC
        ),
        "/check/superposition_translation": Dataset(
            (),
            "float",
            "1",
            "largest |sum over areas - uniform| over the largest |uniform|, translations",
            optional=True,
        ),
        "/check/superposition_optics": Dataset(
            (), "float", "1", "the same for the rotations of the optical elements", optional=True
        ),
        "/check/max_translation": Dataset(("area",), "float", "m/K", "largest translation of any grid"),
        "/check/rigid_translation": Dataset(
            ("area", "xyz"), "float", "m/K", "translation of the best-fit rigid motion at the centre of gravity", BASIC
        ),
        "/check/rigid_rotation": Dataset(
            ("area", "xyz"), "float", "rad/K", "rotation of the best-fit rigid motion", BASIC
        ),
    },
)
