"""Temperatures of grids that follow from those of thermal nodes; the name of the file is the user's."""

from __future__ import annotations

from tedm_cli.contracts.spec import BASIC, NAMES, Dataset, FileKind, Values


class TemperaturesFile(FileKind):
    """Its datasets by name; `TEMPERATURES` is the kind of file."""

    GRID_ID = Dataset(
        "/grid/id",
        ("node",),
        "int",
        "1",
        "Nastran id of the grids that the map reaches",
        values=Values(ascending=True, least=1),
    )
    GRID_POSITION = Dataset("/grid/position", ("node", "xyz"), "float", "m", "grid position", BASIC)
    MAP_NODE = Dataset("/map/node", ("map_node",), "str", "1", "thermal nodes", values=NAMES)
    SET_NAME = Dataset("/set/name", ("set",), "str", "1", "sets of temperatures", values=NAMES)
    GIVEN = Dataset(
        "/given", ("set", "map_node"), "float", "K", "temperatures of the thermal nodes above the reference"
    )
    TEMPERATURE = Dataset(
        "/temperature", ("set", "node"), "float", "K", "temperatures of the grids above the reference"
    )


TEMPERATURES = TemperaturesFile("temperatures", 1, "tedm map-temperatures")
