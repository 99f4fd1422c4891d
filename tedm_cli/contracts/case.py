"""caseNN.h5: spectra, bounds and verdicts of a correlation case."""

from __future__ import annotations

from tedm_cli.contracts.disturbances import NETWORK, DisturbanceDatasets
from tedm_cli.contracts.resemblance import ResemblanceDatasets
from tedm_cli.contracts.spec import (
    COUNT,
    FLAG,
    NAMES,
    QUANTITIES,
    UNITS_OF_AREA,
    AreaDatasets,
    Dataset,
    FileKind,
    Values,
)
from tedm_cli.contracts.uncertainty import UncertaintyDatasets


class _NoiseDatasets(AreaDatasets):
    """Spectra, verdicts, and where they come from."""

    CASE_ID = Dataset("/case/id", (), "str", "1", "case number")
    CASE_TITLE = Dataset("/case/title", (), "str", "1", "which temperatures move together")
    CASE_ROLE = Dataset(
        "/case/role",
        (),
        "str",
        "1",
        "likely in flight, possible, or diagnostic (not physical, it isolates a part)",
        values=Values(words=("likely", "possible", "diagnostic")),
    )
    CASE_REASON = Dataset(
        "/case/reason", (), "str", "1", "why the case is there, empty where the configuration does not say"
    )
    CASE_SAFETY_FACTOR = Dataset(
        "/case/safety_factor", (), "float", "1", "factor on amplitudes when judged (not applied to /psd)"
    )
    CASE_BLOCK = Dataset(
        "/case/block",
        ("area",),
        "int",
        "1",
        "block of each area, uncorrelated to other blocks; -1: silent",
        values=Values(rows_of="area", none=True),
    )
    CORRELATION_REAL = Dataset(
        "/correlation/real", ("area", "area_column"), "float", "1", "correlation before delays, real part"
    )
    CORRELATION_IMAGINARY = Dataset(
        "/correlation/imaginary",
        ("area", "area_column"),
        "float",
        "1",
        "imaginary part, where there is one",
        optional=True,
    )
    CORRELATION_DELAY = Dataset(
        "/correlation/delay", ("area",), "float", "s", "R_ij is turned by exp(-2 pi i f (delay_i - delay_j))"
    )
    CORRELATION_FREQUENCY = Dataset(
        "/correlation/frequency",
        (),
        "float",
        "Hz",
        "the frequency that the correlation is of, where it depends on it: temperatures of the thermal network",
        optional=True,
        group=NETWORK,
    )
    FREQUENCY = Dataset("/frequency", ("frequency",), "float", "Hz", "frequency")
    TEMPERATURE_SPECTRUM = Dataset(
        "/temperature/spectrum",
        ("area",),
        "int",
        "1",
        "row of /temperature/asd that each area has; gradients without a spectrum have one of zeros",
        values=Values(rows_of="spectrum"),
    )
    TEMPERATURE_ASD = Dataset(
        "/temperature/asd",
        ("spectrum", "frequency"),
        "float",
        "K/sqrt(Hz); K/m/sqrt(Hz) of gradients",
        "one-sided amplitude spectral densities of the areas, each of areas of one kind",
    )
    TEMPERATURE_MODEL = Dataset("/temperature/model", (), "str", "1", "temperature model and its parameters")
    OUTPUT_LABEL = Dataset("/output/label", ("output",), "str", "1", "outputs", values=NAMES)
    OUTPUT_UNIT = Dataset("/output/unit", ("output",), "str", "1", "unit of the output")
    OUTPUT_KIND = Dataset("/output/kind", ("output",), "str", "1", "quantity of the output", values=QUANTITIES)
    PSD = Dataset("/psd/{output}", ("frequency",), "float", None, "one-sided power spectral density of the output")
    BOUNDS_MAXIMUM = Dataset(
        "/bounds/maximum/{output}",
        ("frequency",),
        "float",
        None,
        "largest PSD over all correlations of the active areas, also between means and gradients",
    )
    BOUNDS_MAXIMUM_NON_NEGATIVE = Dataset(
        "/bounds/maximum_non_negative/{output}",
        ("frequency",),
        "float",
        None,
        "largest PSD over all correlations without a negative entry",
    )
    BOUNDS_KNOWN_BLOCKS = Dataset(
        "/bounds/known_blocks/{output}",
        ("frequency",),
        "float",
        None,
        "largest PSD when only the correlation between the blocks is unknown",
    )
    BOUNDS_KNOWN_BLOCKS_MINIMUM = Dataset(
        "/bounds/known_blocks_minimum/{output}",
        ("frequency",),
        "float",
        None,
        "smallest PSD when only the correlation between the blocks is unknown",
    )
    BOUNDS_MINIMUM = Dataset(
        "/bounds/minimum/{output}", ("frequency",), "float", None, "smallest PSD over all correlations"
    )
    EXTREMAL = Dataset(
        "/extremal/{bound}",
        ("output", "area", "plane"),
        "float",
        "1",
        "vectors V at /contribution/frequency: R_ij = V_i . V_j reaches the bound (known blocks: between blocks)",
    )
    CONTRIBUTION_FREQUENCY = Dataset(
        "/contribution/frequency", ("output",), "float", "Hz", "frequency of the contributions"
    )
    CONTRIBUTION_WEIGHT = Dataset(
        "/contribution/weight",
        ("output", "area"),
        "float",
        "K/sqrt(Hz) over /output/unit per sqrt(Hz)",
        "of a case of the thermal network: the share of a term of the output in its PSD is this times its row per K",
        optional=True,
        group="weight",
    )
    CONTRIBUTION_AMPLITUDE = Dataset(
        "/contribution/amplitude/{output}",
        ("area",),
        "float",
        None,
        "signed contribution: sensitivity times amplitude spectral density",
    )
    CONTRIBUTION_SHARE = Dataset(
        "/contribution/share", ("output", "area"), "float", "1", "share of the PSD; the shares of a row sum to 1"
    )
    CONTRIBUTION_BAND = Dataset("/contribution/band", ("output", "band_edge"), "float", "Hz", "band of band_share")
    CONTRIBUTION_BAND_SHARE = Dataset(
        "/contribution/band_share", ("output", "area"), "float", "1", "share of the power in the band"
    )
    PATH_NAME = Dataset(
        "/path/name",
        ("path",),
        "str",
        "1",
        "what outputs are sums of: optical elements that move; "
        "glass of plates, self-gravity, effects of the user's own",
        "",
        True,
        NAMES,
    )
    PATH_SHARE = Dataset(
        "/path/share/{output}", ("path",), "float", "1", "share of the PSD at /contribution/frequency", "", True
    )
    PATH_BAND_SHARE = Dataset(
        "/path/band_share/{output}", ("path",), "float", "1", "share of the power in the band", "", True
    )
    EFFECT_NAME = Dataset("/effect/name", ("effect",), "str", "1", "effects of the user's own", "", True, NAMES)
    EFFECT_ROW = Dataset(
        "/effect/row/{output}",
        ("effect", "area"),
        "float",
        None,
        "what each makes of the output per /area/unit of an area; it is in all spectra",
        "",
        True,
    )
    VERDICT_REQUIREMENT = Dataset(
        "/verdict/requirement", ("verdict",), "str", "1", "requirement", values=Values(of="/requirement/name")
    )
    VERDICT_OUTPUT = Dataset(
        "/verdict/output", ("verdict",), "str", "1", "output that is judged", values=Values(of="/output/label")
    )
    VERDICT_RATIO = Dataset(
        "/verdict/ratio", ("verdict",), "float", "1", "largest ratio of safety factor x ASD to the requirement"
    )
    VERDICT_BINDING_FREQUENCY = Dataset(
        "/verdict/binding_frequency", ("verdict",), "float", "Hz", "frequency of the largest ratio"
    )
    VERDICT_PASSED = Dataset("/verdict/passed", ("verdict",), "int", "1", "1 where the ratio is at most 1", values=FLAG)
    VERDICT_ALLOWED_SAFETY_FACTOR = Dataset(
        "/verdict/allowed_safety_factor",
        ("verdict",),
        "float",
        "1",
        "safety factor at which the ratio is 1; infinite without noise",
        open_ended=True,
    )
    VERDICT_DISTORTION_RATIO = Dataset(
        "/verdict/distortion_ratio",
        ("verdict",),
        "float",
        "1",
        "ratio without the motion of the bench as one; NaN for other outputs than read-outs, and with gradients within",
        open_ended=True,
    )
    BOUND_RATIO_BOUND = Dataset("/bound_ratio/bound", ("bound",), "str", "1", "bounds, as under /bounds", values=NAMES)
    BOUND_RATIO_RATIO = Dataset(
        "/bound_ratio/ratio", ("verdict", "bound"), "float", "1", "ratio of each verdict at the bound"
    )
    IMPROVEMENT_COUNT = Dataset(
        "/improvement/count",
        ("count",),
        "int",
        "1",
        "number of areas improved, the worst first",
        values=Values(least=0, ascending=True),
    )
    IMPROVEMENT_AREA = Dataset(
        "/improvement/area",
        ("verdict", "rank"),
        "int",
        "1",
        "worst areas, each after those before it were silenced; -1: no relief left",
        values=Values(rows_of="area", none=True),
    )
    IMPROVEMENT_SILENCED = Dataset(
        "/improvement/silenced", ("verdict", "count"), "float", "1", "ratio with these areas silent"
    )
    IMPROVEMENT_QUIETER = Dataset(
        "/improvement/quieter", ("verdict", "count"), "float", "1", "ratio with a tenth of their noise"
    )
    IMPROVEMENT_MATCHED_BLOCK = Dataset(
        "/improvement/matched_block",
        ("verdict", "rank"),
        "int",
        "1",
        "blocks to share one temperature fluctuation: the best pair, then one after the other; -1: no further helps",
        values=Values(rows_of="area", none=True),
    )
    IMPROVEMENT_MATCHED = Dataset(
        "/improvement/matched",
        ("verdict", "count"),
        "float",
        "1",
        "ratio with the first of these blocks, as many as /improvement/count, fully correlated; others as they are",
    )
    IMPROVEMENT_GROUP = Dataset(
        "/improvement/group",
        ("group",),
        "str",
        "1",
        "groups with noise; one whose means and gradients both have noise is there twice",
        values=Values(of="/area/group"),
    )
    IMPROVEMENT_GROUP_UNIT = Dataset(
        "/improvement/group_unit",
        ("group",),
        "str",
        "1",
        "unit of the group's temperatures: K of its means, K/m of its gradients",
        values=Values(words=UNITS_OF_AREA),
    )
    IMPROVEMENT_GROUP_FACTOR = Dataset(
        "/improvement/group_factor",
        ("verdict", "group"),
        "float",
        "1",
        "factor on the group's temperatures that just meets the requirement; NaN: none does; infinite: it has no part",
        open_ended=True,
    )
    IMPROVEMENT_ALL_FACTOR = Dataset(
        "/improvement/all_factor",
        ("verdict",),
        "float",
        "1",
        "the same for all groups together; infinite without noise",
        open_ended=True,
    )
    FILTER_SENSITIVITY_ORDER = Dataset(
        "/filter_sensitivity/order", ("order",), "float", "1", "order of the low-pass filter", optional=True
    )
    FILTER_SENSITIVITY_CORNER = Dataset(
        "/filter_sensitivity/corner", ("corner",), "float", "Hz", "corner of the low-pass filter", optional=True
    )
    FILTER_SENSITIVITY_RATIO = Dataset(
        "/filter_sensitivity/ratio",
        ("verdict", "order", "corner"),
        "float",
        "1",
        "ratio of each verdict with that filter",
        optional=True,
    )
    REQUIREMENT_NAME = Dataset("/requirement/name", ("requirement",), "str", "1", "requirement")
    REQUIREMENT_SOURCE = Dataset(
        "/requirement/source", ("requirement",), "str", "1", "where the requirement comes from"
    )
    REQUIREMENT_UNIT = Dataset("/requirement/unit", ("requirement",), "str", "1", "unit of the amplitude")
    REQUIREMENT_APPLIES_TO = Dataset(
        "/requirement/applies_to",
        ("requirement",),
        "str",
        "1",
        "outputs of a test mass, or their differences",
        values=Values(words=("single", "differential")),
    )
    REQUIREMENT_BAND = Dataset(
        "/requirement/band", ("requirement", "band_edge"), "float", "Hz", "band of the requirement"
    )
    REQUIREMENT_AMPLITUDE = Dataset(
        "/requirement/amplitude",
        ("requirement", "frequency"),
        "float",
        None,
        "amplitude spectral density; NaN outside the band",
        open_ended=True,
    )
    REALISATION_FREQUENCY = Dataset(
        "/realisation/frequency", ("bin",), "float", "Hz", "frequency of the estimate from a realisation", optional=True
    )
    REALISATION_PSD = Dataset(
        "/realisation/psd", ("output", "bin"), "float", None, "estimate of the one-sided PSD", optional=True
    )
    REALISATION_EXACT = Dataset(
        "/realisation/exact",
        ("output", "bin"),
        "float",
        None,
        "its expectation: the exact PSD through the window",
        optional=True,
    )
    REALISATION_DEGREES_OF_FREEDOM = Dataset(
        "/realisation/degrees_of_freedom",
        ("bin",),
        "float",
        "1",
        "equivalent degrees of freedom of the estimate (chi-square)",
        optional=True,
    )
    REALISATION_METHOD = Dataset(
        "/realisation/method",
        (),
        "str",
        "1",
        "estimate: welch (Kaiser's window, beta = 22), or log (log-spaced by speckit, beta = 25.4)",
        values=Values(words=("welch", "log")),
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


class CaseFile(UncertaintyDatasets, ResemblanceDatasets, DisturbanceDatasets, _NoiseDatasets, FileKind):
    """Its datasets by name; `CASE` is the kind of file."""


CASE = CaseFile(
    "case",
    5,
    "tedm run-case",
    fixed_dims={"band_edge": 2, "plane": 2, "factor": 2, "estimate": 4, "probability": 99},
    derived_dims={
        "area_column": ("area", 1, 0),
        "parameter_column": ("parameter", 1, 0),
        "node_group_column": ("node_group", 1, 0),
    },
    families={"output": "/output/label", "bound": "/bound_ratio/bound"},
)
