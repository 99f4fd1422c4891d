"""dynamics.h5 and simulationNN.h5: the drag-free loop, and the noise of its outputs."""

from __future__ import annotations

from tedm_cli.contracts.spec import AREAS, BASIC, TM_FRAME, Dataset, FileKind

DYNAMICS = FileKind(
    "dynamics",
    1,
    "tedm build-dynamics",
    {
        "/label/coordinate": Dataset(("coordinate",), "str", "1", "coordinates p: attitude, then each test mass"),
        "/label/coordinate_unit": Dataset(("coordinate",), "str", "1", "unit of the coordinates"),
        "/label/input": Dataset(("input",), "str", "1", "forces and torques w on the spacecraft and each test mass"),
        "/label/input_unit": Dataset(("input",), "str", "1", "unit of the inputs"),
        "/label/body_coordinate": Dataset(
            ("body",), "str", "1", "rows and columns of M, K: spacecraft, then test masses"
        ),
        "/label/tm_motion": Dataset(("tm_motion",), "str", "1", "rows and columns of /stiffness/mutual"),
        "/spacecraft/mass": Dataset((), "float", "kg", "mass without the test masses"),
        "/spacecraft/inertia": Dataset(("xyz", "xyz_column"), "float", "kg m^2", "inertia about the centre", BASIC),
        "/spacecraft/centre_of_mass": Dataset(("xyz",), "float", "m", "centre of mass without the test masses", BASIC),
        "/test_mass/name": Dataset(("test_mass",), "str", "1", "names in the model; TM1 and TM2 in the labels"),
        "/test_mass/mass": Dataset(("test_mass",), "float", "kg", "mass"),
        "/test_mass/inertia": Dataset(("test_mass", "xyz"), "float", "kg m^2", "principal moments of inertia"),
        "/test_mass/position": Dataset(("test_mass", "xyz"), "float", "m", "nominal centre", BASIC),
        "/test_mass/axes": Dataset(("test_mass", "xyz", "xyz_column"), "float", "1", "unit vectors (rows)", BASIC),
        "/stiffness/source": Dataset(("source",), "str", "1", "what moves with the spacecraft, electrostatics last"),
        "/stiffness/by_source": Dataset(
            ("test_mass", "source", "motion", "motion_column"),
            "float",
            None,
            "force per mass and torque per moment by motion of the test mass; positive: destabilising",
            TM_FRAME,
        ),
        "/stiffness/mutual": Dataset(
            ("tm_motion", "tm_motion_column"), "float", None, "the same of the other test mass alone", TM_FRAME
        ),
        "/M": Dataset(("body", "body_column"), "float", None, "mass matrix of M q'' = K q + U w"),
        "/K": Dataset(("body", "body_column"), "float", None, "stiffness of the 18 degrees of freedom"),
        "/U": Dataset(("body", "input"), "float", None, "inputs of the 18 degrees of freedom"),
        "/E": Dataset(("coordinate", "input"), "float", None, "p'' by w: p'' = K_p p + E w"),
        "/K_p": Dataset(("coordinate", "coordinate_column"), "float", None, "p'' by p"),
        "/controller/origin": Dataset((), "str", "1", "the default loops, or the file of one's own"),
        "/controller/period": Dataset((), "float", "s", "sampling period; 0: continuous"),
        "/controller/delay": Dataset(
            (), "float", "s", "delay of all commands beside A, B, C, D of a sampled controller"
        ),
        "/controller/A": Dataset(("state", "state_column"), "float", None, "controller, delays (Padé 3, 3) included"),
        "/controller/B": Dataset(("state", "coordinate"), "float", None, "by the read-outs y = p + n"),
        "/controller/C": Dataset(("input", "state"), "float", None, "commands u = C x + D y"),
        "/controller/D": Dataset(("input", "coordinate"), "float", None, "commands u = C x + D y"),
        "/actuation": Dataset(
            ("input", "loop"), "float", None, "u = - actuation x acceleration demands of the loops", optional=True
        ),
        "/loop/name": Dataset(("loop",), "str", "1", "where the loops are broken: by name, or at the read-outs"),
        "/loop/crossover": Dataset(("loop",), "float", "Hz", "highest frequency of open-loop gain 1; nan: none"),
        "/loop/phase_margin": Dataset(("loop",), "float", "deg", "smallest, the other loops closed; inf: no crossover"),
        "/loop/gain_margin": Dataset(("loop",), "float", "dB", "how much more gain is borne"),
        "/loop/gain_reduction": Dataset(("loop",), "float", "dB", "how much less gain is borne (negative)"),
        "/loop/peak_sensitivity": Dataset(("loop",), "float", "1", "largest 1 / |1 + L|"),
        "/loop/frequency": Dataset(("loop_frequency",), "float", "Hz", "of the open loops"),
        "/loop/open_real": Dataset(("loop", "loop_frequency"), "float", "1", "open loop L, the others closed"),
        "/loop/open_imaginary": Dataset(("loop", "loop_frequency"), "float", "1", "open loop L, imaginary part"),
        "/pole/real": Dataset(("pole",), "float", "rad/s", "poles of the closed loop, real part"),
        "/pole/imaginary": Dataset(("pole",), "float", "rad/s", "poles of the closed loop, imaginary part"),
        "/label/disturbance": Dataset(
            ("disturbance",),
            "str",
            "1",
            "w_ forces and torques, n_ read-out noise, s_ accelerations of the test masses",
        ),
        "/label/disturbance_unit": Dataset(("disturbance",), "str", "1", "unit of the disturbances"),
        "/noise/name": Dataset(("noise",), "str", "1", "noise sources"),
        "/noise/group": Dataset(("noise",), "str", "1", "group each is told with"),
        "/noise/spectrum": Dataset(("noise",), "str", "1", "spectrum in words"),
        "/noise/origin": Dataset(("noise",), "str", "1", "where the level is from"),
        "/noise/gain": Dataset(("disturbance", "noise"), "float", None, "disturbances by the sources"),
        "/read_out/set": Dataset((), "str", "1", "set of photodiodes that the controller hears"),
        "/at_rest": Dataset(("tm_motion",), "float", None, "accelerations at rest that the actuation levels are from"),
    },
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

SIMULATION = FileKind(
    "simulation",
    1,
    "tedm simulate",
    {
        **AREAS,
        "/case/id": Dataset((), "str", "1", "case whose temperatures act"),
        "/case/title": Dataset((), "str", "1", "which temperatures move together"),
        "/case/role": Dataset((), "str", "1", "likely in flight, possible, or diagnostic"),
        "/case/safety_factor": Dataset((), "float", "1", "factor on amplitudes when judged (not applied to /psd)"),
        "/temperature/model": Dataset((), "str", "1", "temperature model and its parameters"),
        "/read_out/set": Dataset((), "str", "1", "set of photodiodes that the controller hears"),
        "/frequency": Dataset(("frequency",), "float", "Hz", "frequency"),
        "/output/label": Dataset(("output",), "str", "1", "outputs of the closed loop"),
        "/output/unit": Dataset(("output",), "str", "1", "unit of the output"),
        "/psd/{output}": Dataset(("frequency",), "float", None, "one-sided power spectral density of the output"),
        "/group/name": Dataset(("group",), "str", "1", "groups of noise sources, the temperatures last"),
        "/contribution/{group}/{output}": Dataset(("frequency",), "float", None, "part of a group in the PSD"),
        "/thermal/incoherent/{output}": Dataset(
            ("frequency",), "float", None, "PSD of the temperatures if gravity and read-out added without their phases"
        ),
        "/thermal/gravity/{output}": Dataset(("frequency",), "float", None, "PSD of the temperatures by gravity alone"),
        "/source/name": Dataset(("source",), "str", "1", "noise sources"),
        "/source/group": Dataset(("source",), "str", "1", "group of each source"),
        "/verdict/requirement": Dataset(("verdict",), "str", "1", "requirement"),
        "/verdict/output": Dataset(("verdict",), "str", "1", "output that is judged"),
        "/verdict/ratio": Dataset(("verdict",), "float", "1", "largest ratio of safety factor x ASD to requirement"),
        "/verdict/binding_frequency": Dataset(("verdict",), "float", "Hz", "frequency of the largest ratio"),
        "/verdict/noise": Dataset(("verdict",), "float", None, "ASD there, without the safety factor"),
        "/verdict/limit": Dataset(("verdict",), "float", None, "limit there"),
        "/verdict/passed": Dataset(("verdict",), "int", "1", "1 where the ratio is at most 1"),
        "/verdict/group_share": Dataset(("verdict", "group"), "float", "1", "part of the group in the PSD there"),
        "/verdict/source_share": Dataset(("verdict", "source"), "float", "1", "part of the source in the PSD there"),
        "/verdict/area_share": Dataset(("verdict", "area"), "float", "1", "signed part of the area in the PSD there"),
        "/verdict/incoherent": Dataset(
            ("verdict",), "float", "1", "temperatures there without the phases of gravity and read-out, over with them"
        ),
        "/improvement/silenced": Dataset(("verdict", "group"), "float", "1", "ratio without the group"),
        "/improvement/factor": Dataset(
            ("verdict", "group"),
            "float",
            "1",
            "factor on the group's amplitude that just meets the requirement; inf: not felt, nan: not by it alone",
        ),
        "/requirement/name": Dataset(("requirement",), "str", "1", "requirements that were applied"),
        "/requirement/source": Dataset(("requirement",), "str", "1", "document they are from"),
        "/requirement/unit": Dataset(("requirement",), "str", "1", "unit of the amplitude"),
        "/requirement/amplitude": Dataset(
            ("requirement", "frequency"), "float", None, "limit on the ASD; nan outside the band"
        ),
        "/realisation/output": Dataset(("realised",), "str", "1", "outputs realised in time", optional=True),
        "/realisation/frequency": Dataset(("bin",), "float", "Hz", "frequency of the estimate", optional=True),
        "/realisation/psd": Dataset(
            ("realised", "bin"), "float", None, "estimate of the one-sided PSD from a realisation", optional=True
        ),
        "/realisation/exact": Dataset(
            ("realised", "bin"), "float", None, "its expectation by the exact spectra", optional=True
        ),
        "/realisation/degrees_of_freedom": Dataset(
            ("bin",), "float", "1", "equivalent degrees of freedom of the estimate (chi-square)", optional=True
        ),
        "/realisation/rate": Dataset((), "float", "Hz", "samples per second of the realisation", optional=True),
        "/realisation/samples": Dataset((), "int", "1", "samples of the realisation", optional=True),
        "/realisation/seed": Dataset((), "int", "1", "seed of the random numbers", optional=True),
    },
)
