"""optics.h5: the optical matrices and the read-out by each area."""

from __future__ import annotations

from tedm_cli.contracts.spec import (
    COUNT,
    DOFS,
    LAYOUT,
    MOTIONS,
    NAMES,
    TM_FRAME,
    AreaDatasets,
    AreaPlaces,
    Dataset,
    FileKind,
    Values,
)

_UNITS = Values(words=("m", "rad"))
_PLATES = "plates"


class OpticsFile(AreaPlaces, AreaDatasets, FileKind):
    """Its datasets by name; `OPTICS` is the kind of file."""

    S_BW = Dataset("/S_BW", ("ray_output", "element_dof"), "float", None, "optical sensitivity matrix", LAYOUT)
    P = Dataset("/P", ("laser_output", "ray_output"), "float", None, "optics law: photodiode outputs to read-out")
    O_IDEAL = Dataset(
        "/O_ideal", ("laser_output", "test_mass_dof"), "float", None, "test mass motion to laser read-out", TM_FRAME
    )
    D = Dataset("/D", ("laser_output", "area"), "float", None, "laser read-out per /area/unit of an area")
    N = Dataset("/N/{set}", ("read_out", "area"), "float", None, "read-out noise per /area/unit of an area", TM_FRAME)
    N_RIGID = Dataset(
        "/N_rigid/{set}",
        ("read_out", "area"),
        "float",
        None,
        "part of N: each bench moves as one against the test masses",
        TM_FRAME,
    )
    N_DISTORTION = Dataset(
        "/N_distortion/{set}",
        ("read_out", "area"),
        "float",
        None,
        "part of N: the rest of the motion, the benches distort",
        TM_FRAME,
    )
    N_PLATES = Dataset(
        "/N_plates/{set}",
        ("read_out", "area"),
        "float",
        None,
        "part of N: the glass of plates changes; N = N_rigid + N_distortion + N_plates",
        TM_FRAME,
        optional=True,
        group=_PLATES,
    )
    PLATE_NAME = Dataset(
        "/plate/name",
        ("plate",),
        "str",
        "1",
        "plates whose glass changes with temperature",
        optional=True,
        values=Values(of="/element/name", unique=True),
        group=_PLATES,
    )
    PLATE_BY_INDEX = Dataset(
        "/plate/by_index",
        ("ray_output", "plate"),
        "float",
        None,
        "outputs of the beams by the refractive index of each plate",
        LAYOUT,
        optional=True,
        group=_PLATES,
    )
    PLATE_BY_THICKNESS = Dataset(
        "/plate/by_thickness",
        ("ray_output", "plate"),
        "float",
        None,
        "outputs of the beams by its thickness, the middle plane held",
        LAYOUT,
        optional=True,
        group=_PLATES,
    )
    PLATE_INDEX_CHANGE = Dataset(
        "/plate/index_change",
        ("plate", "area"),
        "float",
        "1/K; none of gradients",
        "change of its index per kelvin of a thermal area",
        optional=True,
        group=_PLATES,
    )
    PLATE_THICKNESS_CHANGE = Dataset(
        "/plate/thickness_change",
        ("plate", "area"),
        "float",
        "m/K; none of gradients",
        "change of its thickness per kelvin of a thermal area",
        optional=True,
        group=_PLATES,
    )
    MOTION = Dataset(
        "/motion",
        ("element_dof", "area"),
        "float",
        None,
        "motion of the elements at their grids per /area/unit of an area; of a test mass that of its expanding face",
        LAYOUT,
    )
    RIGID_MOTION = Dataset(
        "/rigid_motion",
        ("element_dof", "area"),
        "float",
        None,
        "the part of it in which each bench moves as one",
        LAYOUT,
    )
    INVERSE = Dataset(
        "/inverse/{set}",
        ("read_out", "laser_output"),
        "float",
        None,
        "laser read-out to test mass motion: N = inverse D",
    )
    GAIN = Dataset(
        "/gain/{set}",
        ("read_out", "element_dof"),
        "float",
        None,
        "motion of an element at its grid to read-out: N = gain motion, and N_plates where there are plates",
    )
    COMMON_MODE_MOTION = Dataset(
        "/common_mode/motion",
        ("rigid_motion", "area"),
        "float",
        None,
        "rigid motion nearest to that of each bench: ux uy uz rx ry rz",
        LAYOUT,
    )
    COMMON_MODE_ABOUT = Dataset(
        "/common_mode/about", ("bench_xyz",), "float", "m", "points whose translations these are: x y z", LAYOUT
    )
    BENCH_NAME = Dataset(
        "/bench/name", ("bench",), "str", "1", "benches, each of which may move as a rigid body by itself", values=NAMES
    )
    ELEMENT_BENCH = Dataset(
        "/element/bench",
        ("element",),
        "str",
        "1",
        "bench that the element is on; empty for a test mass",
    )
    LABEL_RAY_OUTPUT = Dataset(
        "/label/ray_output",
        ("ray_output",),
        "str",
        "1",
        "rows of S_BW",
        values=Values(ends=("x", "y", "opl", "z1", "z2"), unique=True),
    )
    LABEL_RAY_OUTPUT_UNIT = Dataset(
        "/label/ray_output_unit", ("ray_output",), "str", "1", "unit of the rows of S_BW", values=_UNITS
    )
    LABEL_ELEMENT_DOF = Dataset(
        "/label/element_dof",
        ("element_dof",),
        "str",
        "1",
        "columns of S_BW (m, rad)",
        values=Values(parts_of="/element/name", ends=MOTIONS, unique=True),
    )
    LABEL_LASER_OUTPUT = Dataset(
        "/label/laser_output",
        ("laser_output",),
        "str",
        "1",
        "rows of P, O_ideal and D",
        values=Values(ends=("OPD", "WFT1", "WFT2"), unique=True),
    )
    LABEL_LASER_OUTPUT_UNIT = Dataset(
        "/label/laser_output_unit", ("laser_output",), "str", "1", "unit of the rows of P, O_ideal and D", values=_UNITS
    )
    LABEL_TEST_MASS_DOF = Dataset(
        "/label/test_mass_dof",
        ("test_mass_dof",),
        "str",
        "1",
        "columns of O_ideal (m, rad)",
        values=Values(of="/element/name", ends=MOTIONS, unique=True),
    )
    LABEL_READ_OUT = Dataset(
        "/label/read_out",
        ("read_out",),
        "str",
        "1",
        "rows of N",
        values=Values(of="/element/name", ends=DOFS, unique=True),
    )
    LABEL_READ_OUT_UNIT = Dataset(
        "/label/read_out_unit", ("read_out",), "str", "1", "unit of the read-out", values=_UNITS
    )
    SET_NAME = Dataset("/set/name", ("set",), "str", "1", "redundant sets of photodiodes", values=NAMES)
    SET_CONDITION = Dataset("/set/condition", ("set",), "float", "1", "condition number of O of the set (m, rad)")
    RANK = Dataset("/rank", (), "int", "1", "rank of O_ideal", values=COUNT)
    SINGULAR_VALUES = Dataset(
        "/singular_values", ("test_mass_dof_singular",), "float", "1", "singular values of O_ideal"
    )
    RESIDUAL_NAME = Dataset(
        "/residual/name", ("residual",), "str", "1", "invariance that the matrices must keep", values=NAMES
    )
    RESIDUAL_VALUE = Dataset("/residual/value", ("residual",), "float", "1", "dimensionless residual of the invariance")
    RESIDUAL_LIMIT = Dataset(
        "/residual/limit",
        ("residual",),
        "float",
        "1",
        "largest residual allowed; infinite: not judged",
        open_ended=True,
    )
    ORIGIN_S_BW = Dataset(
        "/origin/S_BW", (), "str", "1", "where S_BW comes from: ray trace, or the name of an imported file"
    )
    ORIGIN_P = Dataset("/origin/P", (), "str", "1", "where P comes from: layout, or the name of an imported file")
    ELEMENT_NAME = Dataset(
        "/element/name",
        ("element",),
        "str",
        "1",
        "optical elements and test masses, six columns of S_BW each",
        values=NAMES,
    )
    TEST_MASS_NAME = Dataset(
        "/test_mass/name", ("test_mass",), "str", "1", "test masses", values=Values(of="/element/name", unique=True)
    )
    TEST_MASS_AXES = Dataset(
        "/test_mass/axes",
        ("test_mass", "xyz", "xyz_column"),
        "float",
        "1",
        "axes of the test masses as rows, along and about which they are read",
        LAYOUT,
    )
    ELEMENT_PIVOT = Dataset(
        "/element/pivot", ("element", "xyz"), "float", "m", "point that the rotations of each element are about", LAYOUT
    )
    REFERENCE_POINT_OFFSET = Dataset(
        "/reference_point_offset",
        ("optical", "xyz"),
        "float",
        "m",
        "layout reference point minus finite-element grid",
        LAYOUT,
    )
    NOTE = Dataset(
        "/note",
        ("note",),
        "str",
        "1",
        "warnings about the layout, or about differences between layout and model",
        optional=True,
    )
    OPTICAL_NAME = Dataset("/optical/name", ("optical",), "str", "1", "optical element", values=NAMES)


OPTICS = OpticsFile(
    "optics",
    5,
    "tedm build-optics",
    fixed_dims={"xyz": 3, "xyz_column": 3},
    derived_dims={
        "element_dof": ("element", 6, 0),
        "rigid_motion": ("bench", 6, 0),
        "bench_xyz": ("bench", 3, 0),
        "test_mass_dof": ("test_mass", 6, 0),
    },
    families={"set": "/set/name"},
)
