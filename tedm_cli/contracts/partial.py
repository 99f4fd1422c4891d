"""partial_NAME.h5: what one result file leaves in the matrices, to be put together with the others."""

from __future__ import annotations

from tedm_cli.contracts.distortion import DISTORTION
from tedm_cli.contracts.spec import (
    ACCELERATIONS,
    BASIC,
    FLAG,
    NAMES,
    PER_AREA,
    TM_FRAME,
    TURN_PER_AREA,
    AreaDatasets,
    Dataset,
    FileKind,
    GridIds,
    Values,
)

_POSITIONS = "uncertain positions"


class PartialFile(AreaDatasets, GridIds, FileKind):
    """Its datasets by name; `PARTIAL` is the kind of file. Its areas are those of the result file, in its order."""

    RESULTS_FILE = Dataset("/results/file", (), "str", "1", "the result file, as model.op2 names it")
    RESULTS_SUBCASE = Dataset(
        "/results/subcase",
        ("area",),
        "int",
        "1",
        "subcase of each area in the result file",
        values=Values(unique=True, least=1),
    )
    RESULTS_BY_NUMBER = Dataset(
        "/results/by_number", (), "int", "1", "1 where it has no labels, so that numbers tell the areas", values=FLAG
    )
    RESULTS_PRECISION = Dataset(
        "/results/precision", (), "str", "1", "precision of the results", values=Values(words=("single", "double"))
    )
    S = Dataset("/S", ("row", "area"), "float", None, "columns of [S_SG] per /area/unit", TM_FRAME)
    ROW_LABEL = Dataset(
        "/row/label",
        ("row",),
        "str",
        "1",
        "output of each row",
        values=Values(ends=ACCELERATIONS, unique=True),
    )
    POSITION_CHANGE = Dataset(
        "/position/change",
        ("position_row", "area"),
        "float",
        None,
        "change of rows of S by each uncertain position in turn, six rows for each",
        optional=True,
        group=_POSITIONS,
    )
    OPTICAL_NAME = DISTORTION.OPTICAL_NAME
    D_OPT_TRANSLATION = DISTORTION.D_OPT_TRANSLATION
    D_OPT_ROTATION = DISTORTION.D_OPT_ROTATION
    TIE_BLOCK = Dataset("/tie/block", ("tie",), "str", "1", "compensation mass that follows grids", values=NAMES)
    TIE_TRANSLATION = Dataset(
        "/tie/translation", ("area", "tie", "xyz"), "float", PER_AREA, "translation of its centre", BASIC
    )
    TIE_ROTATION = Dataset("/tie/rotation", ("area", "tie", "xyz"), "float", TURN_PER_AREA, "its rotation", BASIC)
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
    SUM_TRANSLATION = Dataset(
        "/sum/translation", ("node", "xyz"), "float", "m/K", "sum of translations over the mean areas", BASIC
    )
    SUM_SIZE = Dataset("/sum/size", ("node",), "float", "m/K", "sum of their lengths")
    OFFSET_NODE = Dataset(
        "/offset_node",
        ("offset_node",),
        "int",
        "1",
        "rows of /grid from which something with mass is offset, or that turn a tied compensation mass",
        values=Values(rows_of="node", ascending=True),
    )
    SUM_ROTATION = Dataset(
        "/sum/rotation", ("offset_node", "xyz"), "float", "rad/K", "sum of their rotations over the mean areas", BASIC
    )
    SUM_ROTATION_SIZE = Dataset("/sum/rotation_size", ("offset_node",), "float", "rad/K", "sum of their angles")
    SUM_MOVES = Dataset("/sum/moves", ("offset_node",), "int", "1", "1 where one moves under any load", values=FLAG)
    SUM_TURNS = Dataset("/sum/turns", ("offset_node",), "int", "1", "1 where one turns under any load", values=FLAG)
    UNIFORM_SUBCASE = Dataset(
        "/uniform/subcase",
        (),
        "int",
        "1",
        "subcase of the uniform load, in the result file that has it",
        optional=True,
        values=Values(least=1),
    )
    UNIFORM_TRANSLATION = Dataset(
        "/uniform/translation",
        ("node", "xyz"),
        "float",
        "m",
        "translation when all mean areas are loaded",
        BASIC,
        True,
    )
    UNIFORM_ROTATION = Dataset(
        "/uniform/rotation", ("node", "xyz"), "float", "rad", "rotation when all mean areas are loaded", BASIC, True
    )


PARTIAL = PartialFile("partial", 1, "tedm build-sensitivity --partial")
