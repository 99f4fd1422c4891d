"""simulationNN.h5: the noise of the drag-free loop's outputs in a case."""

from __future__ import annotations

from tedm_cli.contracts.disturbances import NETWORK, DisturbanceDatasets
from tedm_cli.contracts.spec import (
    COUNT,
    FLAG,
    NAMES,
    AreaDatasets,
    Dataset,
    FileKind,
    Values,
)


class SimulationFile(AreaDatasets, FileKind):
    """Its datasets by name; `SIMULATION` is the kind of file."""

    CASE_ID = Dataset("/case/id", (), "str", "1", "case whose temperatures act")
    CASE_TITLE = Dataset("/case/title", (), "str", "1", "which temperatures move together")
    CASE_ROLE = Dataset(
        "/case/role",
        (),
        "str",
        "1",
        "likely in flight, possible, or diagnostic",
        values=Values(words=("likely", "possible", "diagnostic")),
    )
    CASE_SAFETY_FACTOR = Dataset(
        "/case/safety_factor", (), "float", "1", "factor on amplitudes when judged (not applied to /psd)"
    )
    TEMPERATURE_MODEL = Dataset("/temperature/model", (), "str", "1", "temperature model and its parameters")
    READ_OUT_SET = Dataset("/read_out/set", (), "str", "1", "set of photodiodes that the controller uses")
    FREQUENCY = Dataset("/frequency", ("frequency",), "float", "Hz", "frequency")
    OUTPUT_LABEL = Dataset("/output/label", ("output",), "str", "1", "outputs of the closed loop", values=NAMES)
    OUTPUT_UNIT = Dataset("/output/unit", ("output",), "str", "1", "unit of the output")
    PSD = Dataset("/psd/{output}", ("frequency",), "float", None, "one-sided power spectral density of the output")
    GROUP_NAME = Dataset(
        "/group/name", ("group",), "str", "1", "groups of noise sources, the temperatures last", values=NAMES
    )
    CONTRIBUTION = Dataset(
        "/contribution/{group}/{output}", ("frequency",), "float", None, "part of a group in the PSD"
    )
    THERMAL_INCOHERENT = Dataset(
        "/thermal/incoherent/{output}",
        ("frequency",),
        "float",
        None,
        "PSD of the temperatures if gravity and read-out added without their phases",
    )
    THERMAL_GRAVITY = Dataset(
        "/thermal/gravity/{output}", ("frequency",), "float", None, "PSD of the temperatures by gravity alone"
    )
    SOURCE_NAME = Dataset("/source/name", ("source",), "str", "1", "noise sources", values=NAMES)
    SOURCE_GROUP = Dataset(
        "/source/group", ("source",), "str", "1", "group of each source", values=Values(of="/group/name")
    )
    VERDICT_REQUIREMENT = Dataset(
        "/verdict/requirement", ("verdict",), "str", "1", "requirement", values=Values(of="/requirement/name")
    )
    VERDICT_OUTPUT = Dataset(
        "/verdict/output", ("verdict",), "str", "1", "output that is judged", values=Values(of="/output/label")
    )
    VERDICT_RATIO = Dataset(
        "/verdict/ratio", ("verdict",), "float", "1", "largest ratio of safety factor x ASD to requirement"
    )
    VERDICT_BINDING_FREQUENCY = Dataset(
        "/verdict/binding_frequency", ("verdict",), "float", "Hz", "frequency of the largest ratio"
    )
    VERDICT_NOISE = Dataset("/verdict/noise", ("verdict",), "float", None, "ASD there, without the safety factor")
    VERDICT_LIMIT = Dataset("/verdict/limit", ("verdict",), "float", None, "limit there")
    VERDICT_PASSED = Dataset("/verdict/passed", ("verdict",), "int", "1", "1 where the ratio is at most 1", values=FLAG)
    VERDICT_GROUP_SHARE = Dataset(
        "/verdict/group_share", ("verdict", "group"), "float", "1", "part of the group in the PSD there"
    )
    VERDICT_SOURCE_SHARE = Dataset(
        "/verdict/source_share", ("verdict", "source"), "float", "1", "part of the source in the PSD there"
    )
    VERDICT_AREA_SHARE = Dataset(
        "/verdict/area_share", ("verdict", "area"), "float", "1", "signed part of the area in the PSD there"
    )
    DISTURBANCE_NAME = DisturbanceDatasets.DISTURBANCE_NAME
    VERDICT_DISTURBANCE_SHARE = Dataset(
        "/verdict/disturbance_share",
        ("verdict", "disturbance"),
        "float",
        "1",
        "part of the disturbance in the PSD there; negative where it cancels others that it is correlated with",
        optional=True,
        group=NETWORK,
    )
    IMPROVEMENT_DISTURBANCE_FACTOR = Dataset(
        "/improvement/disturbance_factor",
        ("verdict", "disturbance"),
        "float",
        "1",
        "factor on the level of the disturbance, all else unchanged, that just meets the requirement; inf: it has no"
        " part, nan: not enough alone",
        optional=True,
        open_ended=True,
        group=NETWORK,
    )
    VERDICT_INCOHERENT = Dataset(
        "/verdict/incoherent",
        ("verdict",),
        "float",
        "1",
        "PSD of the temperatures without the phases of gravity and read-out, over that with them; nan: no part",
        open_ended=True,
    )
    IMPROVEMENT_SILENCED = Dataset(
        "/improvement/silenced", ("verdict", "group"), "float", "1", "ratio without the group"
    )
    IMPROVEMENT_FACTOR = Dataset(
        "/improvement/factor",
        ("verdict", "group"),
        "float",
        "1",
        "factor on the group's amplitude that just meets the requirement; inf: it has no part, nan: not enough alone",
        open_ended=True,
    )
    IMPROVEMENT_TOGETHER = Dataset(
        "/improvement/together", ("verdict", "group"), "int", "1", "1: group needed to meet it together", values=FLAG
    )
    IMPROVEMENT_TOGETHER_FACTOR = Dataset(
        "/improvement/together_factor", ("verdict",), "float", "1", "on their amplitudes; nan: met", open_ended=True
    )
    IMPROVEMENT_TOGETHER_SILENCED = Dataset(
        "/improvement/together_silenced", ("verdict",), "float", "1", "ratio without these groups"
    )
    REQUIREMENT_NAME = Dataset("/requirement/name", ("requirement",), "str", "1", "requirements that were applied")
    REQUIREMENT_SOURCE = Dataset("/requirement/source", ("requirement",), "str", "1", "document they are from")
    REQUIREMENT_UNIT = Dataset("/requirement/unit", ("requirement",), "str", "1", "unit of the amplitude")
    REQUIREMENT_AMPLITUDE = Dataset(
        "/requirement/amplitude",
        ("requirement", "frequency"),
        "float",
        None,
        "limit on the ASD; nan outside the band",
        open_ended=True,
    )
    REALISATION_OUTPUT = Dataset(
        "/realisation/output",
        ("realised",),
        "str",
        "1",
        "outputs realised in time",
        optional=True,
        values=Values(of="/output/label"),
    )
    REALISATION_FREQUENCY = Dataset(
        "/realisation/frequency", ("bin",), "float", "Hz", "frequency of the estimate", optional=True
    )
    REALISATION_PSD = Dataset(
        "/realisation/psd",
        ("realised", "bin"),
        "float",
        None,
        "estimate of the one-sided PSD from a realisation",
        optional=True,
    )
    REALISATION_EXACT = Dataset(
        "/realisation/exact", ("realised", "bin"), "float", None, "its expectation by the exact spectra", optional=True
    )
    REALISATION_DEGREES_OF_FREEDOM = Dataset(
        "/realisation/degrees_of_freedom",
        ("bin",),
        "float",
        "1",
        "equivalent degrees of freedom of the estimate (chi-square)",
        optional=True,
    )
    REALISATION_RATE = Dataset(
        "/realisation/rate", (), "float", "Hz", "samples per second of the realisation", optional=True
    )
    REALISATION_SAMPLES = Dataset(
        "/realisation/samples", (), "int", "1", "samples of the realisation", optional=True, values=COUNT
    )
    REALISATION_SEED = Dataset(
        "/realisation/seed", (), "int", "1", "seed of the random numbers", optional=True, values=COUNT
    )


SIMULATION = SimulationFile(
    "simulation", 3, "tedm simulate", families={"output": "/output/label", "group": "/group/name"}
)
