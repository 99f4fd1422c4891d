"""Datasets of sensitivity.h5 on test masses that are not where they should be."""

from __future__ import annotations

from tedm_cli.contracts.spec import BASIC, NAMES, Dataset


class MovedOperators:
    """Changes of G by uncertain positions of test masses."""

    MOVED_NAME = Dataset(
        "/moved/name",
        ("moved",),
        "str",
        "1",
        "test mass and axis of the basic frame of each uncertain position, TM1_x; of projects with a thermal model",
        optional=True,
        values=NAMES,
    )
    MOVED_OPERATOR = Dataset(
        "/moved/dG",
        ("moved", "component", "node", "xyz"),
        "float",
        "1/s^2 or 1/(m s^2), per m",
        "change of the six rows of G of that test mass by this position",
        BASIC,
        optional=True,
    )
    MOVED_ROTATION = Dataset(
        "/moved/dG_rotation",
        ("moved", "component", "offset_node", "xyz"),
        "float",
        "m/s^2 or 1/s^2 per rad, per m",
        "the same of the rows by rotations of grids with levers",
        BASIC,
        optional=True,
    )
