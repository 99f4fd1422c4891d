"""sensitivity.h5: the self-gravity and its sensitivities."""

from __future__ import annotations

from tedm_cli.contracts.spec import (
    ACCELERATIONS,
    AREAS,
    BASIC,
    COUNT,
    DOFS,
    FLAG,
    GRID,
    NAMES,
    TM_FRAME,
    Dataset,
    FileKind,
    Values,
)

SENSITIVITY = FileKind(
    "sensitivity",
    3,
    "tedm build-sensitivity",
    {
        "/grid/id": GRID["/grid/id"],
        **AREAS,
        "/area/centroid": Dataset(("area", "xyz"), "float", "m", "mean position of the area's grids", BASIC, True),
        "/S": Dataset(("row", "area"), "float", None, "self-gravity sensitivity matrix [S_SG]", TM_FRAME),
        "/row/label": Dataset(
            ("row",),
            "str",
            "1",
            "output of each row of S and of the operator",
            values=Values(of="/test_mass/name", ends=ACCELERATIONS, unique=True),
        ),
        "/row/unit": Dataset(
            ("row",), "str", "1", "unit of each row of S", values=Values(words=("m/s^2/K", "rad/s^2/K"))
        ),
        "/test_mass/name": Dataset(("test_mass",), "str", "1", "name of the test mass", values=NAMES),
        "/test_mass/position": Dataset(("test_mass", "xyz"), "float", "m", "centre of the test mass", BASIC),
        "/test_mass/side": Dataset(("test_mass", "xyz"), "float", "m", "edge lengths"),
        "/test_mass/mass": Dataset(("test_mass",), "float", "kg", "mass"),
        "/test_mass/axes": Dataset(
            ("test_mass", "xyz", "xyz_column"), "float", "1", "unit vectors of the test mass frame (rows)", BASIC
        ),
        "/source/name": Dataset(
            ("source",),
            "str",
            "1",
            "what pulls",
            values=Values(unique=True, words=("structure", "other test mass", "compensation masses")),
        ),
        "/source/quadrature_error": Dataset(
            ("test_mass", "source"),
            "float",
            "1",
            "quadrature error: tolerance per element for the structure (nan: lumped), estimate for the others",
            open_ended=True,
        ),
        "/source/points": Dataset(("test_mass", "source"), "int", "1", "points the source is made of", values=COUNT),
        "/source/mass_model": Dataset(
            (), "str", "1", "how the structure's mass is represented", values=Values(words=("quadrature", "lumped"))
        ),
        "/dc/acceleration": Dataset(
            ("test_mass", "source", "xyz"), "float", "m/s^2", "acceleration of the test mass at rest", TM_FRAME
        ),
        "/dc/angular_acceleration": Dataset(
            ("test_mass", "source", "xyz"),
            "float",
            "rad/s^2",
            "angular acceleration of the test mass at rest",
            TM_FRAME,
        ),
        "/stiffness/gamma_lin": Dataset(
            ("test_mass", "source", "xyz", "xyz_column"), "float", "1/s^2", "force by test mass translation", TM_FRAME
        ),
        "/stiffness/omega_lin": Dataset(
            ("test_mass", "source", "xyz", "xyz_column"),
            "float",
            "1/(m s^2)",
            "torque by test mass translation",
            TM_FRAME,
        ),
        "/stiffness/gamma_ang": Dataset(
            ("test_mass", "source", "xyz", "xyz_column"),
            "float",
            "m/(s^2 rad)",
            "force by test mass rotation",
            TM_FRAME,
        ),
        "/stiffness/omega_ang": Dataset(
            ("test_mass", "source", "xyz", "xyz_column"),
            "float",
            "1/(s^2 rad)",
            "torque by test mass rotation",
            TM_FRAME,
        ),
        "/stiffness/linearised": Dataset(
            ("tm_output", "tm_motion"),
            "float",
            None,
            "linearised equations of motion of all test masses: (F/M, T/I) by small translations and rotations",
            TM_FRAME,
        ),
        "/label/tm_output": Dataset(
            ("tm_output",),
            "str",
            "1",
            "rows of /stiffness/linearised",
            values=Values(of="/test_mass/name", ends=ACCELERATIONS, unique=True),
        ),
        "/label/tm_output_unit": Dataset(
            ("tm_output",), "str", "1", "unit of the rows", values=Values(words=("m/s^2", "rad/s^2"))
        ),
        "/label/tm_motion": Dataset(
            ("tm_motion",),
            "str",
            "1",
            "columns of /stiffness/linearised",
            values=Values(of="/test_mass/name", ends=DOFS, unique=True),
        ),
        "/label/tm_motion_unit": Dataset(
            ("tm_motion",), "str", "1", "unit of the columns", values=Values(words=("m", "rad"))
        ),
        "/operator/G": Dataset(
            ("row", "node", "xyz"),
            "float",
            None,
            "operator of S = -G D: rows in /row, displacement in basic frame",
            BASIC,
        ),
        "/operator/offset_node": Dataset(
            ("offset_node",),
            "int",
            "1",
            "rows of /grid that G_rotation is about",
            values=Values(rows_of="node", ascending=True),
        ),
        "/operator/G_rotation": Dataset(
            ("row", "offset_node", "xyz"),
            "float",
            None,
            "part of the operator that the rotations of these grids contribute",
            BASIC,
        ),
        "/area_contribution/acceleration": Dataset(
            ("test_mass", "area", "xyz"),
            "float",
            "m/s^2",
            "part of the DC acceleration made by the mass that its grids carry",
            TM_FRAME,
        ),
        "/area_contribution/angular_acceleration": Dataset(
            ("test_mass", "area", "xyz"),
            "float",
            "rad/s^2",
            "part of the DC angular acceleration that an area's mass makes",
            TM_FRAME,
        ),
        "/area_contribution/gamma_lin": Dataset(
            ("test_mass", "area", "xyz", "xyz_column"),
            "float",
            "1/s^2",
            "part of the force by test mass translation that an area's mass makes",
            TM_FRAME,
        ),
        "/dc_verdict/test_mass": Dataset(("dc_verdict",), "str", "1", "test mass", values=Values(of="/test_mass/name")),
        "/dc_verdict/quantity": Dataset(
            ("dc_verdict",),
            "str",
            "1",
            "judged quantity at rest",
            values=Values(words=("gamma_xx", "a_x", "a_y", "a_z", "omegadot_theta", "omegadot_eta", "omegadot_phi")),
        ),
        "/dc_verdict/subsystem": Dataset(
            ("dc_verdict",),
            "str",
            "1",
            "inertial sensor of the test mass (IS), rest of the model (LTP), or both",
            values=Values(words=("IS", "LTP", "IS+LTP")),
        ),
        "/dc_verdict/unit": Dataset(
            ("dc_verdict",),
            "str",
            "1",
            "unit of value, lower and upper",
            values=Values(words=("1/s^2", "m/s^2", "rad/s^2")),
        ),
        "/dc_verdict/value": Dataset(("dc_verdict",), "float", None, "value of the quantity", TM_FRAME),
        "/dc_verdict/lower": Dataset(("dc_verdict",), "float", None, "lower end of the allocated range"),
        "/dc_verdict/upper": Dataset(("dc_verdict",), "float", None, "upper end of the allocated range"),
        "/dc_verdict/ratio": Dataset(("dc_verdict",), "float", "1", "value over the end of the range on its side"),
        "/dc_verdict/passed": Dataset(
            ("dc_verdict",), "int", "1", "1 where the value is within the range", values=FLAG
        ),
    },
    derived_dims={
        "row": ("test_mass", 6, 0),
        "tm_output": ("test_mass", 6, 0),
        "tm_motion": ("test_mass", 6, 0),
    },
)
