"""sensitivity.h5: the self-gravity and its sensitivities."""

from __future__ import annotations

from tedm_cli.contracts.moved import MovedOperators
from tedm_cli.contracts.spec import (
    ACCELERATIONS,
    BASIC,
    COUNT,
    DOFS,
    FLAG,
    NAMES,
    PER_AREA,
    TM_FRAME,
    TURN_PER_AREA,
    AreaDatasets,
    AreaPlaces,
    Dataset,
    FileKind,
    GridIds,
    Values,
)

AT_REST = (
    *("gamma_xx", "gamma_xy", "gamma_xz", "gamma_yy", "gamma_yz", "gamma_zz"),
    *("a_x", "a_y", "a_z", "omegadot_theta", "omegadot_eta", "omegadot_phi"),
)


class SensitivityFile(MovedOperators, AreaPlaces, AreaDatasets, GridIds, FileKind):
    """Its datasets by name; `SENSITIVITY` is the kind of file."""

    S = Dataset(
        "/S",
        ("row", "area"),
        "float",
        None,
        "self-gravity sensitivity matrix [S_SG] per /area/unit",
        TM_FRAME,
    )
    ROW_LABEL = Dataset(
        "/row/label",
        ("row",),
        "str",
        "1",
        "output of each row of S and of the operator",
        values=Values(of="/test_mass/name", ends=ACCELERATIONS, unique=True),
    )
    ROW_UNIT = Dataset(
        "/row/unit",
        ("row",),
        "str",
        "1",
        "unit of each row of S by mean areas",
        values=Values(words=("m/s^2/K", "rad/s^2/K")),
    )
    TEST_MASS_NAME = Dataset("/test_mass/name", ("test_mass",), "str", "1", "name of the test mass", values=NAMES)
    TEST_MASS_POSITION = Dataset(
        "/test_mass/position", ("test_mass", "xyz"), "float", "m", "centre of mass of the test mass", BASIC
    )
    DS_DPOSITION = Dataset(
        "/test_mass/dS_dposition",
        ("row", "xyz", "area"),
        "float",
        None,
        "change of S by the nominal position of the row's test mass against the structure, along axes of the basic"
        " frame; there where positions are uncertain",
        BASIC,
        optional=True,
    )
    TEST_MASS_SHAPE = Dataset("/test_mass/shape", ("test_mass",), "str", "1", "what its body is, with its sizes")
    TEST_MASS_SIDE = Dataset(
        "/test_mass/side", ("test_mass", "xyz"), "float", "m", "edge lengths along its axes of the cuboid that holds it"
    )
    TEST_MASS_BOX_CENTRE = Dataset(
        "/test_mass/box_centre", ("test_mass", "xyz"), "float", "m", "centre of the cuboid that holds it", BASIC
    )
    TEST_MASS_INERTIA = Dataset(
        "/test_mass/inertia",
        ("test_mass", "xyz", "xyz_column"),
        "float",
        "kg m^2",
        "inertia about the centre of mass",
        TM_FRAME,
    )
    TEST_MASS_SURFACE = Dataset(
        "/test_mass/surface",
        ("surface_triangle", "corner", "xyz"),
        "float",
        "m",
        "corners of the triangles that draw the bodies; round ones by flat parts, pockets with their openings",
        BASIC,
    )
    TEST_MASS_SURFACE_OWNER = Dataset(
        "/test_mass/surface_owner",
        ("surface_triangle",),
        "int",
        "1",
        "test mass of each triangle",
        values=Values(rows_of="test_mass"),
    )
    TEST_MASS_MASS = Dataset("/test_mass/mass", ("test_mass",), "float", "kg", "mass")
    TEST_MASS_AXES = Dataset(
        "/test_mass/axes",
        ("test_mass", "xyz", "xyz_column"),
        "float",
        "1",
        "unit vectors of the test mass frame (rows)",
        BASIC,
    )
    SOURCE_NAME = Dataset(
        "/source/name",
        ("source",),
        "str",
        "1",
        "what pulls",
        values=Values(unique=True, words=("structure", "other test mass", "compensation masses")),
    )
    SOURCE_QUADRATURE_ERROR = Dataset(
        "/source/quadrature_error",
        ("test_mass", "source"),
        "float",
        "1",
        "quadrature error: tolerance per element for the structure (nan: lumped), estimate for the others",
        open_ended=True,
    )
    SOURCE_POINTS = Dataset(
        "/source/points", ("test_mass", "source"), "int", "1", "points the source is made of", values=COUNT
    )
    SOURCE_MASS_MODEL = Dataset(
        "/source/mass_model",
        (),
        "str",
        "1",
        "how the structure's mass is represented",
        values=Values(words=("quadrature", "lumped")),
    )
    DC_ACCELERATION = Dataset(
        "/dc/acceleration",
        ("test_mass", "source", "xyz"),
        "float",
        "m/s^2",
        "acceleration of the test mass at rest",
        TM_FRAME,
    )
    DC_ANGULAR_ACCELERATION = Dataset(
        "/dc/angular_acceleration",
        ("test_mass", "source", "xyz"),
        "float",
        "rad/s^2",
        "angular acceleration of the test mass at rest",
        TM_FRAME,
    )
    STIFFNESS_GAMMA_LIN = Dataset(
        "/stiffness/gamma_lin",
        ("test_mass", "source", "xyz", "xyz_column"),
        "float",
        "1/s^2",
        "force by test mass translation",
        TM_FRAME,
    )
    STIFFNESS_OMEGA_LIN = Dataset(
        "/stiffness/omega_lin",
        ("test_mass", "source", "xyz", "xyz_column"),
        "float",
        "1/(m s^2)",
        "torque by test mass translation",
        TM_FRAME,
    )
    STIFFNESS_GAMMA_ANG = Dataset(
        "/stiffness/gamma_ang",
        ("test_mass", "source", "xyz", "xyz_column"),
        "float",
        "m/(s^2 rad)",
        "force by test mass rotation",
        TM_FRAME,
    )
    STIFFNESS_OMEGA_ANG = Dataset(
        "/stiffness/omega_ang",
        ("test_mass", "source", "xyz", "xyz_column"),
        "float",
        "1/(s^2 rad)",
        "torque by test mass rotation",
        TM_FRAME,
    )
    STIFFNESS_LINEARISED = Dataset(
        "/stiffness/linearised",
        ("tm_output", "tm_motion"),
        "float",
        None,
        "linearised equations of motion of all test masses: (F/M, T/I) by small translations and rotations",
        TM_FRAME,
    )
    LABEL_TM_OUTPUT = Dataset(
        "/label/tm_output",
        ("tm_output",),
        "str",
        "1",
        "rows of /stiffness/linearised",
        values=Values(of="/test_mass/name", ends=ACCELERATIONS, unique=True),
    )
    LABEL_TM_OUTPUT_UNIT = Dataset(
        "/label/tm_output_unit",
        ("tm_output",),
        "str",
        "1",
        "unit of the rows",
        values=Values(words=("m/s^2", "rad/s^2")),
    )
    LABEL_TM_MOTION = Dataset(
        "/label/tm_motion",
        ("tm_motion",),
        "str",
        "1",
        "columns of /stiffness/linearised",
        values=Values(of="/test_mass/name", ends=DOFS, unique=True),
    )
    LABEL_TM_MOTION_UNIT = Dataset(
        "/label/tm_motion_unit", ("tm_motion",), "str", "1", "unit of the columns", values=Values(words=("m", "rad"))
    )
    OPERATOR_G = Dataset(
        "/operator/G",
        ("row", "node", "xyz"),
        "float",
        None,
        "operator of S = -G D, tied compensation masses in it: rows in /row, displacement in basic frame",
        BASIC,
    )
    OPERATOR_OFFSET_NODE = Dataset(
        "/operator/offset_node",
        ("offset_node",),
        "int",
        "1",
        "rows of /grid that G_rotation is about",
        values=Values(rows_of="node", ascending=True),
    )
    OPERATOR_G_ROTATION = Dataset(
        "/operator/G_rotation",
        ("row", "offset_node", "xyz"),
        "float",
        None,
        "part of the operator that the rotations of these grids contribute",
        BASIC,
    )
    COMPENSATION_NAME = Dataset("/compensation/name", ("block",), "str", "1", "compensation mass", values=NAMES)
    COMPENSATION_CENTRE = Dataset("/compensation/centre", ("block", "xyz"), "float", "m", "centre of the block", BASIC)
    COMPENSATION_SIZE = Dataset("/compensation/size", ("block", "xyz"), "float", "m", "edge lengths of the block")
    COMPENSATION_AXES = Dataset(
        "/compensation/axes", ("block", "xyz", "xyz_column"), "float", "1", "unit vectors of its edges (rows)", BASIC
    )
    COMPENSATION_MASS = Dataset("/compensation/mass", ("block",), "float", "kg", "mass of the block")
    COMPENSATION_TIE = Dataset(
        "/compensation/tie",
        ("block",),
        "str",
        "1",
        "what the configuration ties the block to: grids, or sets of the deck; empty: it does not move",
    )
    COMPENSATION_NODE_OFFSET = Dataset(
        "/compensation/node_offset",
        ("block_edge",),
        "int",
        "1",
        "start of each block in node_index, and its end",
        values=Values(starts_in="block_member"),
    )
    COMPENSATION_NODE_INDEX = Dataset(
        "/compensation/node_index",
        ("block_member",),
        "int",
        "1",
        "rows of /grid that each block follows",
        values=Values(rows_of="node"),
    )
    COMPENSATION_TRANSLATION = Dataset(
        "/compensation/translation",
        ("area", "block", "xyz"),
        "float",
        PER_AREA,
        "translation of the centre of each block per /area/unit of an area",
        BASIC,
    )
    COMPENSATION_ROTATION = Dataset(
        "/compensation/rotation",
        ("area", "block", "xyz"),
        "float",
        TURN_PER_AREA,
        "rotation of each block per /area/unit of an area",
        BASIC,
    )
    AREA_CONTRIBUTION_ACCELERATION = Dataset(
        "/area_contribution/acceleration",
        ("test_mass", "area", "xyz"),
        "float",
        "m/s^2",
        "part of the DC acceleration made by the mass that its grids carry; 0 of gradients",
        TM_FRAME,
    )
    AREA_CONTRIBUTION_ANGULAR_ACCELERATION = Dataset(
        "/area_contribution/angular_acceleration",
        ("test_mass", "area", "xyz"),
        "float",
        "rad/s^2",
        "part of the DC angular acceleration that an area's mass makes",
        TM_FRAME,
    )
    AREA_CONTRIBUTION_GAMMA_LIN = Dataset(
        "/area_contribution/gamma_lin",
        ("test_mass", "area", "xyz", "xyz_column"),
        "float",
        "1/s^2",
        "part of the force by test mass translation that an area's mass makes",
        TM_FRAME,
    )
    DC_VERDICT_TEST_MASS = Dataset(
        "/dc_verdict/test_mass", ("dc_verdict",), "str", "1", "test mass", values=Values(of="/test_mass/name")
    )
    DC_VERDICT_MINUS = Dataset(
        "/dc_verdict/minus",
        ("dc_verdict",),
        "str",
        "1",
        "test mass whose value is subtracted, if a difference is judged; empty: test_mass by itself",
        values=Values(of="/test_mass/name", none=True),
    )
    DC_VERDICT_QUANTITY = Dataset(
        "/dc_verdict/quantity",
        ("dc_verdict",),
        "str",
        "1",
        "judged quantity at rest",
        values=Values(words=AT_REST),
    )
    DC_VERDICT_SUBSYSTEM = Dataset(
        "/dc_verdict/subsystem",
        ("dc_verdict",),
        "str",
        "1",
        "whose field is judged: a subsystem, several joined by +, or all, which is everything in the model",
    )
    DC_VERDICT_WHOLE = Dataset(
        "/dc_verdict/whole", ("dc_verdict",), "int", "1", "1 where that is everything in the model", values=FLAG
    )
    DC_VERDICT_REQUIREMENT = Dataset(
        "/dc_verdict/requirement", ("dc_verdict",), "str", "1", "requirement that the range belongs to"
    )
    DC_VERDICT_SOURCE = Dataset("/dc_verdict/source", ("dc_verdict",), "str", "1", "where the range is from")
    DC_VERDICT_UNIT = Dataset(
        "/dc_verdict/unit",
        ("dc_verdict",),
        "str",
        "1",
        "unit of value, lower and upper",
        values=Values(words=("1/s^2", "m/s^2", "rad/s^2")),
    )
    DC_VERDICT_VALUE = Dataset("/dc_verdict/value", ("dc_verdict",), "float", None, "value of the quantity", TM_FRAME)
    DC_VERDICT_LOWER = Dataset("/dc_verdict/lower", ("dc_verdict",), "float", None, "lower end of the range")
    DC_VERDICT_UPPER = Dataset("/dc_verdict/upper", ("dc_verdict",), "float", None, "upper end of the range")
    DC_VERDICT_RATIO = Dataset(
        "/dc_verdict/ratio", ("dc_verdict",), "float", "1", "value divided by the limit on its side of the range"
    )
    DC_VERDICT_PASSED = Dataset(
        "/dc_verdict/passed", ("dc_verdict",), "int", "1", "1 where the value is within the range", values=FLAG
    )


SENSITIVITY = SensitivityFile(
    "sensitivity",
    7,
    "tedm build-sensitivity",
    derived_dims={
        "row": ("test_mass", 6, 0),
        "tm_output": ("test_mass", 6, 0),
        "tm_motion": ("test_mass", 6, 0),
        "block_edge": ("block", 1, 1),
    },
)
