"""dynamics.h5: the drag-free loop."""

from __future__ import annotations

from tedm_cli.contracts.spec import (
    BASIC,
    NAMES,
    TM_FRAME,
    UNITS_OF_AREA,
    Dataset,
    FileKind,
    Values,
)


class DynamicsFile(FileKind):
    """Its datasets by name; `DYNAMICS` is the kind of file."""

    LABEL_COORDINATE = Dataset(
        "/label/coordinate", ("coordinate",), "str", "1", "coordinates p: attitude, then each test mass", values=NAMES
    )
    LABEL_COORDINATE_UNIT = Dataset("/label/coordinate_unit", ("coordinate",), "str", "1", "unit of the coordinates")
    LABEL_INPUT = Dataset(
        "/label/input",
        ("input",),
        "str",
        "1",
        "forces and torques w on the spacecraft and each test mass",
        values=NAMES,
    )
    LABEL_INPUT_UNIT = Dataset("/label/input_unit", ("input",), "str", "1", "unit of the inputs")
    LABEL_BODY_COORDINATE = Dataset(
        "/label/body_coordinate", ("body",), "str", "1", "rows and columns of M, K: spacecraft, then test masses"
    )
    LABEL_TM_MOTION = Dataset("/label/tm_motion", ("tm_motion",), "str", "1", "rows and columns of /stiffness/mutual")
    SPACECRAFT_MASS = Dataset("/spacecraft/mass", (), "float", "kg", "mass without the test masses")
    SPACECRAFT_INERTIA = Dataset(
        "/spacecraft/inertia", ("xyz", "xyz_column"), "float", "kg m^2", "inertia about the centre", BASIC
    )
    SPACECRAFT_CENTRE_OF_MASS = Dataset(
        "/spacecraft/centre_of_mass", ("xyz",), "float", "m", "centre of mass without the test masses", BASIC
    )
    TEST_MASS_NAME = Dataset(
        "/test_mass/name", ("test_mass",), "str", "1", "names in the model; TM1 and TM2 in the labels", values=NAMES
    )
    TEST_MASS_MASS = Dataset("/test_mass/mass", ("test_mass",), "float", "kg", "mass")
    TEST_MASS_INERTIA = Dataset(
        "/test_mass/inertia",
        ("test_mass", "xyz", "xyz_column"),
        "float",
        "kg m^2",
        "inertia about the centre of mass",
        TM_FRAME,
    )
    TEST_MASS_POSITION = Dataset("/test_mass/position", ("test_mass", "xyz"), "float", "m", "nominal centre", BASIC)
    TEST_MASS_AXES = Dataset(
        "/test_mass/axes", ("test_mass", "xyz", "xyz_column"), "float", "1", "unit vectors (rows)", BASIC
    )
    STIFFNESS_SOURCE = Dataset(
        "/stiffness/source",
        ("source",),
        "str",
        "1",
        "what moves with the spacecraft, electrostatics last",
        values=NAMES,
    )
    STIFFNESS_BY_SOURCE = Dataset(
        "/stiffness/by_source",
        ("test_mass", "source", "motion", "motion_column"),
        "float",
        None,
        "force per mass and torque per moment by motion of the test mass; positive: destabilising",
        TM_FRAME,
    )
    STIFFNESS_MUTUAL = Dataset(
        "/stiffness/mutual",
        ("tm_motion", "tm_motion_column"),
        "float",
        None,
        "the same of the other test mass alone",
        TM_FRAME,
    )
    MATRIX_M = Dataset("/matrix/M", ("body", "body_column"), "float", None, "mass matrix of M q'' = K q + U w")
    MATRIX_K = Dataset("/matrix/K", ("body", "body_column"), "float", None, "stiffness of the 18 degrees of freedom")
    MATRIX_U = Dataset("/matrix/U", ("body", "input"), "float", None, "inputs of the 18 degrees of freedom")
    MATRIX_E = Dataset("/matrix/E", ("coordinate", "input"), "float", None, "p'' by w: p'' = K_p p + E w")
    MATRIX_K_P = Dataset("/matrix/K_p", ("coordinate", "coordinate_column"), "float", None, "p'' by p")
    CONTROLLER_ORIGIN = Dataset("/controller/origin", (), "str", "1", "the default loops, or the file of one's own")
    CONTROLLER_PERIOD = Dataset("/controller/period", (), "float", "s", "sampling period; 0: continuous")
    CONTROLLER_DELAY = Dataset(
        "/controller/delay", (), "float", "s", "delay of all commands beside A, B, C, D of a sampled controller"
    )
    CONTROLLER_A = Dataset(
        "/controller/A", ("state", "state_column"), "float", None, "controller, delays (Padé 3, 3) included"
    )
    CONTROLLER_B = Dataset("/controller/B", ("state", "coordinate"), "float", None, "by the read-outs y = p + n")
    CONTROLLER_C = Dataset("/controller/C", ("input", "state"), "float", None, "commands u = C x + D y")
    CONTROLLER_D = Dataset("/controller/D", ("input", "coordinate"), "float", None, "commands u = C x + D y")
    MATRIX_ACTUATION = Dataset(
        "/matrix/actuation",
        ("input", "loop"),
        "float",
        None,
        "u = - actuation x acceleration demands of the loops",
        optional=True,
    )
    LOOP_NAME = Dataset(
        "/loop/name", ("loop",), "str", "1", "where the loops are broken: by name, or at the read-outs", values=NAMES
    )
    LOOP_CROSSOVER = Dataset(
        "/loop/crossover", ("loop",), "float", "Hz", "highest frequency of open-loop gain 1; nan: none", open_ended=True
    )
    LOOP_PHASE_MARGIN = Dataset(
        "/loop/phase_margin",
        ("loop",),
        "float",
        "deg",
        "smallest, the other loops closed; infinite: no crossover",
        open_ended=True,
    )
    LOOP_GAIN_MARGIN = Dataset(
        "/loop/gain_margin",
        ("loop",),
        "float",
        "dB",
        "how much the gain may rise before the loop is unstable; infinite: any",
        open_ended=True,
    )
    LOOP_GAIN_REDUCTION = Dataset(
        "/loop/gain_reduction",
        ("loop",),
        "float",
        "dB",
        "how much the gain may fall before the loop is unstable (negative; infinite: any)",
        open_ended=True,
    )
    LOOP_PEAK_SENSITIVITY = Dataset("/loop/peak_sensitivity", ("loop",), "float", "1", "largest 1 / |1 + L|")
    LOOP_FREQUENCY = Dataset("/loop/frequency", ("loop_frequency",), "float", "Hz", "of the open loops")
    LOOP_OPEN_REAL = Dataset(
        "/loop/open_real", ("loop", "loop_frequency"), "float", "1", "open loop L, the others closed"
    )
    LOOP_OPEN_IMAGINARY = Dataset(
        "/loop/open_imaginary", ("loop", "loop_frequency"), "float", "1", "open loop L, imaginary part"
    )
    POLE_REAL = Dataset("/pole/real", ("pole",), "float", "rad/s", "poles of the closed loop, real part")
    POLE_IMAGINARY = Dataset("/pole/imaginary", ("pole",), "float", "rad/s", "poles of the closed loop, imaginary part")
    LABEL_DISTURBANCE = Dataset(
        "/label/disturbance",
        ("disturbance",),
        "str",
        "1",
        "w_ forces and torques, n_ read-out noise, s_ accelerations of the test masses",
        values=NAMES,
    )
    LABEL_DISTURBANCE_UNIT = Dataset(
        "/label/disturbance_unit", ("disturbance",), "str", "1", "unit of the disturbances"
    )
    NOISE_NAME = Dataset("/noise/name", ("noise",), "str", "1", "noise sources", values=NAMES)
    NOISE_GROUP = Dataset("/noise/group", ("noise",), "str", "1", "group each is told with")
    NOISE_SPECTRUM = Dataset("/noise/spectrum", ("noise",), "str", "1", "spectrum in words")
    NOISE_ORIGIN = Dataset("/noise/origin", ("noise",), "str", "1", "where the level is from")
    NOISE_GAIN = Dataset("/noise/gain", ("disturbance", "noise"), "float", None, "disturbances by the sources")
    READ_OUT_SET = Dataset("/read_out/set", (), "str", "1", "set of photodiodes that the controller uses")
    TEST_MASS_AT_REST = Dataset(
        "/test_mass/at_rest", ("tm_motion",), "float", None, "accelerations at rest that the actuation levels are from"
    )

    THERMAL_AREA = Dataset("/thermal/area", ("area",), "str", "1", "thermal areas", values=NAMES)
    THERMAL_UNIT = Dataset(
        "/thermal/unit",
        ("area",),
        "str",
        "1",
        "unit of the area's temperature: K of a mean, K/m of a gradient",
        values=Values(words=UNITS_OF_AREA),
    )
    THERMAL_V = Dataset(
        "/thermal/V",
        ("disturbance", "area"),
        "float",
        None,
        "disturbances per /thermal/unit of an area: S in s_, N of the read-outs in n_",
    )
    SYSTEM_STATE = Dataset(
        "/system/state",
        ("state_of_loop",),
        "str",
        "1",
        "p, its rates, states of the controller",
        values=NAMES,
        optional=True,
    )
    SYSTEM_STATE_UNIT = Dataset(
        "/system/state_unit", ("state_of_loop",), "str", "1", "unit of the states", optional=True
    )
    SYSTEM_INPUT = Dataset(
        "/system/input",
        ("input_of_loop",),
        "str",
        "1",
        "disturbances, and second derivatives of the read-out noise that Δg holds",
        values=NAMES,
        optional=True,
    )
    SYSTEM_INPUT_UNIT = Dataset(
        "/system/input_unit", ("input_of_loop",), "str", "1", "unit of the inputs", optional=True
    )
    SYSTEM_OUTPUT = Dataset(
        "/system/output", ("output",), "str", "1", "outputs of the closed loop", values=NAMES, optional=True
    )
    SYSTEM_OUTPUT_UNIT = Dataset("/system/output_unit", ("output",), "str", "1", "unit of the outputs", optional=True)
    SYSTEM_A = Dataset(
        "/system/A",
        ("state_of_loop", "state_of_loop_column"),
        "float",
        None,
        "closed loop x' = A x + B d, y = C x + D d; not of a sampled controller",
        optional=True,
    )
    SYSTEM_B = Dataset(
        "/system/B", ("state_of_loop", "input_of_loop"), "float", None, "states by inputs", optional=True
    )
    SYSTEM_C = Dataset("/system/C", ("output", "state_of_loop"), "float", None, "outputs by states", optional=True)
    SYSTEM_D = Dataset("/system/D", ("output", "input_of_loop"), "float", None, "outputs by inputs", optional=True)


DYNAMICS = DynamicsFile(
    "dynamics",
    3,
    "tedm build-dynamics",
    fixed_dims={
        "xyz": 3,
        "xyz_column": 3,
        "coordinate": 15,
        "coordinate_column": 15,
        "input": 18,
        "body": 18,
        "body_column": 18,
        "test_mass": 2,
        "motion": 6,
        "motion_column": 6,
        "tm_motion": 12,
        "tm_motion_column": 12,
        "disturbance": 45,
    },
)
