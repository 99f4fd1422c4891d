"""Datasets of thermal.h5 on displacements under each thermal node, and on what changes the outputs by these."""

from __future__ import annotations

from typing import Any

from tedm_cli.contracts.spec import BASIC, LAYOUT, NAMES, Dataset, Values

_MOVED, _ON_BENCH, _CHANGED = "moved", "on bench", "changed"


def _moved(path: str, dims: tuple[str, ...], dtype: str, units: str | None, long_name: str, **more: Any) -> Dataset:
    """Of the displacements under the thermal nodes."""
    return Dataset(path, dims, dtype, units, long_name, optional=True, **{"group": _MOVED, **more})


_BY_MATERIAL = ("material", "row", "map_node")


def _changed(path: str, dims: tuple[str, ...], dtype: str, long_name: str, values: Values | None = None) -> Dataset:
    """Of a model whose materials or thicknesses are uncertain."""
    units = "1" if dtype == "int" else "see /row/unit"
    return Dataset(path, dims, dtype, units, long_name, optional=True, values=values or Values(), group=_CHANGED)


class NodeDisplacements:
    """Of projects whose thermal nodes lie on a model with an adjoint."""

    MAP_OF_GRID = _moved(
        "/map/of_grid",
        ("grid",),
        "int",
        "1",
        "number of the thermal node that most of the volume at the grid is in, from 0 on; -1: none",
        values=Values(rows_of="map_node", none=True),
    )
    D_TRANSLATION = _moved(
        "/D/translation",
        ("map_node", "grid", "xyz"),
        "float",
        "m/K",
        "displacement of every grid under 1 K on each of these nodes, with the field that conduction makes of it",
        frame=BASIC,
    )
    D_TURNED_NODE = _moved(
        "/D/turned_node",
        ("turned",),
        "int",
        "1",
        "rows of /map/grid_id whose rotation moves an output: of levers of masses, and of optical elements",
        values=Values(rows_of="grid", ascending=True),
    )
    D_ROTATION = _moved(
        "/D/rotation", ("map_node", "turned", "xyz"), "float", "rad/K", "rotation of these grids", frame=BASIC
    )
    D_BLOCK_TRANSLATION = _moved(
        "/D/block_translation",
        ("map_node", "block", "xyz"),
        "float",
        "m/K",
        "translation of the centre of each compensation mass; 0 of those that stay still",
        frame=BASIC,
    )
    D_BLOCK_ROTATION = _moved(
        "/D/block_rotation", ("map_node", "block", "xyz"), "float", "rad/K", "rotation of each of them", frame=BASIC
    )
    LABEL_ELEMENT_DOF = _moved(
        "/label/element_dof", ("element_dof",), "str", "1", "motions of optical elements", values=NAMES, group=_ON_BENCH
    )
    D_ELEMENT = _moved(
        "/D/element",
        ("element_dof", "map_node"),
        "float",
        "m/K or rad/K",
        "motion of the optical elements at their grids",
        frame=LAYOUT,
        group=_ON_BENCH,
    )
    DIRECT = _moved(
        "/D/direct",
        ("row", "map_node"),
        "float",
        "see /row/unit",
        "of /sensitivity, what is by no displacement: faces of test masses that expand, the glass of plates",
    )
    CHANGE_MATERIAL = _changed(
        "/change/material_id",
        ("material",),
        "int",
        "materials, as in adjoint.h5",
        values=Values(ascending=True, least=1),
    )
    CHANGE_SHELL = _changed(
        "/change/property_id",
        ("shell",),
        "int",
        "properties of shells, as there",
        values=Values(ascending=True, least=1),
    )
    CHANGE_DLNE = _changed("/change/dlnE", _BY_MATERIAL, "float", "change of /sensitivity by ln of a modulus")
    CHANGE_DLNALPHA = _changed("/change/dlnalpha", _BY_MATERIAL, "float", "the same of an expansion")
    CHANGE_DALPHA = _changed("/change/dalpha", _BY_MATERIAL, "float", "the same by an expansion in 1/K")
    CHANGE_DLNRHO = _changed("/change/dlnrho", _BY_MATERIAL, "float", "the same by the logarithm of a density")
    CHANGE_DLNT = _changed(
        "/change/dlnt", ("shell", "row", "map_node"), "float", "the same by the logarithm of the thickness of shells"
    )
    MOVED_NAME = _moved(
        "/position/name",
        ("moved",),
        "str",
        "1",
        "uncertain positions of test masses, as in sensitivity.h5",
        values=NAMES,
        group="positions",
    )
    MOVED_CHANGE = _moved(
        "/position/change",
        ("moved", "component", "map_node"),
        "float",
        "m/s^2/K or rad/s^2/K, per m",
        "change of the six accelerations of that test mass by its position",
        group="positions",
    )
    CHECK_DIFFERENCE = _moved(
        "/check/difference",
        ("row", "map_node"),
        "float",
        "1",
        "|by displacements - /sensitivity| over the largest sensitivity to a node of outputs in the same unit",
    )
    CHECK_UNIFORM = _moved(
        "/check/uniform",
        (),
        "float",
        "1",
        "largest |sum over nodes - that of the field that they make together| of a displacement, over the largest one;"
        " nan: not solved here",
        open_ended=True,
    )
    CHECK_RESIDUAL = _moved(
        "/check/residual",
        (),
        "float",
        "1",
        "largest relative residual |K u - f| / |f|; nan: solved by another solver, or weighted from those of areas",
        open_ended=True,
    )
