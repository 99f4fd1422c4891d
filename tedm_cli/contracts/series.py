"""series_NAME.h5 and simulation_NAME.h5: outputs as time series, without the drag-free loop and with it."""

from __future__ import annotations

from tedm_cli.contracts.spec import FLAG, NAMES, QUANTITIES, AreaDatasets, Dataset, FileKind, Values


class SeriesDatasets(AreaDatasets):
    """What both kinds of file hold."""

    TEMPERATURE_COLUMN = Dataset(
        "/temperature/column",
        ("area",),
        "str",
        "1",
        "column of the temperature series that the area, or the thermal node in its place, follows; empty: constant",
    )
    TEMPERATURE_SOURCE = Dataset(
        "/temperature/source", (), "str", "1", "name of the temperature series and of its file"
    )
    TEMPERATURE_TREATMENT = Dataset(
        "/temperature/treatment", (), "str", "1", "what was removed and how the series was resampled"
    )
    TIME = Dataset("/time", ("sample",), "float", "s", "time of the samples")
    OUTPUT_LABEL = Dataset("/output/label", ("output",), "str", "1", "outputs", values=NAMES)
    OUTPUT_UNIT = Dataset("/output/unit", ("output",), "str", "1", "unit of the output")
    OUTPUT_KIND = Dataset("/output/kind", ("output",), "str", "1", "quantity of the output", values=QUANTITIES)
    OUTPUT_RMS = Dataset("/output/rms", ("output",), "float", None, "root mean square of the series")
    OUTPUT_PEAK = Dataset("/output/peak", ("output",), "float", None, "largest absolute value of the series")
    SERIES = Dataset("/series/{output}", ("sample",), "float", None, "time series of the output")
    FREQUENCY = Dataset("/frequency", ("frequency",), "float", "Hz", "frequency of the estimates")
    PSD = Dataset("/psd/{output}", ("frequency",), "float", None, "estimated one-sided power spectral density")
    DEGREES_OF_FREEDOM = Dataset(
        "/degrees_of_freedom",
        ("frequency",),
        "float",
        "1",
        "equivalent degrees of freedom of the estimate (chi-square)",
    )
    VERDICT_SAFETY_FACTOR = Dataset(
        "/verdict/safety_factor", (), "float", "1", "factor on amplitudes when judged, not applied elsewhere"
    )
    VERDICT_REQUIREMENT = Dataset("/verdict/requirement", ("verdict",), "str", "1", "requirement")
    VERDICT_OUTPUT = Dataset(
        "/verdict/output", ("verdict",), "str", "1", "output that is judged", values=Values(of="/output/label")
    )
    VERDICT_RATIO = Dataset(
        "/verdict/ratio",
        ("verdict",),
        "float",
        "1",
        "largest ratio of safety factor x estimated ASD to the requirement, over what is judged of its band",
    )
    VERDICT_BINDING_FREQUENCY = Dataset(
        "/verdict/binding_frequency", ("verdict",), "float", "Hz", "frequency of the largest ratio"
    )
    VERDICT_PASSED = Dataset("/verdict/passed", ("verdict",), "int", "1", "1 where the ratio is at most 1", values=FLAG)
    VERDICT_BAND_RMS = Dataset(
        "/verdict/band_rms", ("verdict",), "float", None, "rms of the output over what is judged of the band"
    )
    VERDICT_BAND_LIMIT = Dataset(
        "/verdict/band_limit", ("verdict",), "float", None, "rms of noise at the requirement over the same"
    )
    VERDICT_LOWEST = Dataset("/verdict/lowest", ("verdict",), "float", "Hz", "lowest frequency that is judged")
    VERDICT_HIGHEST = Dataset("/verdict/highest", ("verdict",), "float", "Hz", "highest frequency that is judged")
    VERDICT_WHOLE_BAND = Dataset(
        "/verdict/whole_band",
        ("verdict",),
        "int",
        "1",
        "1 where the whole band of the requirement is judged",
        values=FLAG,
    )
    UNJUDGED = Dataset("/unjudged", ("unjudged",), "str", "1", "what is not judged of the requirements, and why")


class SeriesFile(SeriesDatasets, FileKind):
    """`SERIES` is the kind of file."""


class SimulatedSeriesFile(SeriesDatasets, FileKind):
    """Its datasets by name; `SIMULATED_SERIES` is the kind of file. The loop is linear: two parts make each output."""

    READ_OUT_SET = Dataset("/read_out/set", (), "str", "1", "set of photodiodes that the controller uses")
    GRAVITY_SERIES = Dataset(
        "/gravity/series/{output}", ("sample",), "float", None, "part of the accelerations of the test masses"
    )
    GRAVITY_PSD = Dataset("/gravity/psd/{output}", ("frequency",), "float", None, "estimated PSD of that part")
    GRAVITY_RMS = Dataset("/gravity/rms", ("output",), "float", None, "root mean square of that part")
    READ_OUT_SERIES = Dataset(
        "/read_out/series/{output}", ("sample",), "float", None, "part of the read-outs that the controller uses"
    )
    READ_OUT_PSD = Dataset("/read_out/psd/{output}", ("frequency",), "float", None, "estimated PSD of that part")
    READ_OUT_RMS = Dataset("/read_out/rms", ("output",), "float", None, "root mean square of that part")


SERIES = SeriesFile("series", 4, "tedm run-series", families={"output": "/output/label"})
SIMULATED_SERIES = SimulatedSeriesFile(
    "simulated_series", 3, "tedm simulate --series", families={"output": "/output/label"}
)
