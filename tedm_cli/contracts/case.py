"""caseNN.h5: spectra, bounds and verdicts of a correlation case."""

from __future__ import annotations

from tedm_cli.contracts.spec import AREAS, COUNT, FLAG, NAMES, QUANTITIES, Dataset, FileKind, Values

CASE = FileKind(
    "case",
    4,
    "tedm run-case",
    {
        **AREAS,
        "/case/id": Dataset((), "str", "1", "case number"),
        "/case/title": Dataset((), "str", "1", "which temperatures move together"),
        "/case/role": Dataset(
            (),
            "str",
            "1",
            "likely in flight, possible, or diagnostic (not physical, it isolates a part)",
            values=Values(words=("likely", "possible", "diagnostic")),
        ),
        "/case/reason": Dataset((), "str", "1", "why the case is there, empty where the configuration does not say"),
        "/case/safety_factor": Dataset((), "float", "1", "factor on amplitudes when judged (not applied to /psd)"),
        "/case/block": Dataset(
            ("area",),
            "int",
            "1",
            "block of each area, uncorrelated to other blocks; -1: silent",
            values=Values(rows_of="area", none=True),
        ),
        "/correlation/real": Dataset(("area", "area_column"), "float", "1", "correlation before delays, real part"),
        "/correlation/imaginary": Dataset(
            ("area", "area_column"), "float", "1", "imaginary part, where there is one", optional=True
        ),
        "/correlation/delay": Dataset(("area",), "float", "s", "R_ij is turned by exp(-2 pi i f (delay_i - delay_j))"),
        "/frequency": Dataset(("frequency",), "float", "Hz", "frequency"),
        "/temperature/spectrum": Dataset(
            ("area",), "int", "1", "row of /temperature/asd that each area has", values=Values(rows_of="spectrum")
        ),
        "/temperature/asd": Dataset(
            ("spectrum", "frequency"), "float", "K/sqrt(Hz)", "one-sided amplitude spectral densities of the areas"
        ),
        "/temperature/model": Dataset((), "str", "1", "temperature model and its parameters"),
        "/output/label": Dataset(("output",), "str", "1", "outputs", values=NAMES),
        "/output/unit": Dataset(("output",), "str", "1", "unit of the output"),
        "/output/kind": Dataset(("output",), "str", "1", "quantity of the output", values=QUANTITIES),
        "/psd/{output}": Dataset(("frequency",), "float", None, "one-sided power spectral density of the output"),
        "/bounds/maximum/{output}": Dataset(
            ("frequency",), "float", None, "largest PSD over all correlations of the active areas"
        ),
        "/bounds/maximum_non_negative/{output}": Dataset(
            ("frequency",), "float", None, "largest PSD over all correlations without a negative entry"
        ),
        "/bounds/known_blocks/{output}": Dataset(
            ("frequency",), "float", None, "largest PSD when only the correlation between the blocks is unknown"
        ),
        "/bounds/known_blocks_minimum/{output}": Dataset(
            ("frequency",), "float", None, "smallest PSD when only the correlation between the blocks is unknown"
        ),
        "/bounds/minimum/{output}": Dataset(("frequency",), "float", None, "smallest PSD over all correlations"),
        "/extremal/{bound}": Dataset(
            ("output", "area", "plane"),
            "float",
            "1",
            "vectors V at /contribution/frequency: R_ij = V_i . V_j reaches the bound (known blocks: between blocks)",
        ),
        "/contribution/frequency": Dataset(("output",), "float", "Hz", "frequency the contributions are given at"),
        "/contribution/amplitude/{output}": Dataset(
            ("area",), "float", None, "signed contribution: sensitivity times amplitude spectral density"
        ),
        "/contribution/share": Dataset(
            ("output", "area"), "float", "1", "share of the PSD; the shares of a row sum to 1"
        ),
        "/contribution/band": Dataset(("output", "band_edge"), "float", "Hz", "band of band_share"),
        "/contribution/band_share": Dataset(("output", "area"), "float", "1", "share of the power in the band"),
        "/path/name": Dataset(
            ("path",), "str", "1", "optical elements whose motion makes the read-out noise", "", True, NAMES
        ),
        "/path/share/{output}": Dataset(
            ("path",), "float", "1", "share of the PSD at /contribution/frequency", "", True
        ),
        "/path/band_share/{output}": Dataset(("path",), "float", "1", "share of the power in the band", "", True),
        "/verdict/requirement": Dataset(("verdict",), "str", "1", "requirement", values=Values(of="/requirement/name")),
        "/verdict/output": Dataset(
            ("verdict",), "str", "1", "output that is judged", values=Values(of="/output/label")
        ),
        "/verdict/ratio": Dataset(
            ("verdict",), "float", "1", "largest ratio of safety factor x ASD to the requirement"
        ),
        "/verdict/binding_frequency": Dataset(("verdict",), "float", "Hz", "frequency of the largest ratio"),
        "/verdict/passed": Dataset(("verdict",), "int", "1", "1 where the ratio is at most 1", values=FLAG),
        "/verdict/allowed_safety_factor": Dataset(
            ("verdict",), "float", "1", "safety factor at which the ratio is 1; infinite without noise", open_ended=True
        ),
        "/verdict/distortion_ratio": Dataset(
            ("verdict",),
            "float",
            "1",
            "ratio if the bench did not move as one; NaN for what is no read-out",
            open_ended=True,
        ),
        "/bound_ratio/bound": Dataset(("bound",), "str", "1", "bounds, as under /bounds", values=NAMES),
        "/bound_ratio/ratio": Dataset(("verdict", "bound"), "float", "1", "ratio of each verdict at the bound"),
        "/improvement/count": Dataset(
            ("count",), "int", "1", "number of areas improved, the worst first", values=Values(least=0, ascending=True)
        ),
        "/improvement/area": Dataset(
            ("verdict", "rank"),
            "int",
            "1",
            "worst areas, each after those before it were silenced; -1: no relief left",
            values=Values(rows_of="area", none=True),
        ),
        "/improvement/silenced": Dataset(("verdict", "count"), "float", "1", "ratio with these areas silent"),
        "/improvement/quieter": Dataset(("verdict", "count"), "float", "1", "ratio with a tenth of their noise"),
        "/improvement/matched_block": Dataset(
            ("verdict", "rank"),
            "int",
            "1",
            "blocks to share one temperature fluctuation: the best pair, then one after the other; -1: no relief left",
            values=Values(rows_of="area", none=True),
        ),
        "/improvement/matched": Dataset(
            ("verdict", "count"),
            "float",
            "1",
            "ratio with all areas of the first of these blocks fully correlated, the other blocks as they are",
        ),
        "/stability/group": Dataset(
            ("group",), "str", "1", "groups with noise", values=Values(unique=True, of="/area/group")
        ),
        "/stability/factor": Dataset(
            ("verdict", "group"),
            "float",
            "1",
            "factor on the group's temperatures that just meets the requirement; NaN: it cannot; infinite: no part",
            open_ended=True,
        ),
        "/stability/all": Dataset(
            ("verdict",), "float", "1", "the same for all groups together; infinite without noise", open_ended=True
        ),
        "/filter_sensitivity/order": Dataset(("order",), "float", "1", "order of the low-pass filter", optional=True),
        "/filter_sensitivity/corner": Dataset(
            ("corner",), "float", "Hz", "corner of the low-pass filter", optional=True
        ),
        "/filter_sensitivity/ratio": Dataset(
            ("verdict", "order", "corner"), "float", "1", "ratio of each verdict with that filter", optional=True
        ),
        "/requirement/name": Dataset(("requirement",), "str", "1", "requirement"),
        "/requirement/source": Dataset(("requirement",), "str", "1", "where the requirement comes from"),
        "/requirement/unit": Dataset(("requirement",), "str", "1", "unit of the amplitude"),
        "/requirement/applies_to": Dataset(
            ("requirement",),
            "str",
            "1",
            "outputs of a test mass, or their differences",
            values=Values(words=("single", "differential")),
        ),
        "/requirement/band": Dataset(("requirement", "band_edge"), "float", "Hz", "band of the requirement"),
        "/requirement/amplitude": Dataset(
            ("requirement", "frequency"),
            "float",
            None,
            "amplitude spectral density; NaN outside the band",
            open_ended=True,
        ),
        "/realisation/frequency": Dataset(
            ("bin",), "float", "Hz", "frequency of the estimate from a realisation", optional=True
        ),
        "/realisation/psd": Dataset(
            ("output", "bin"),
            "float",
            None,
            "estimate of the one-sided PSD",
            optional=True,
        ),
        "/realisation/exact": Dataset(
            ("output", "bin"), "float", None, "its expectation: the exact PSD through the window", optional=True
        ),
        "/realisation/degrees_of_freedom": Dataset(
            ("bin",), "float", "1", "equivalent degrees of freedom of the estimate (chi-square)", optional=True
        ),
        "/realisation/method": Dataset(
            (),
            "str",
            "1",
            "estimate: welch (Kaiser's window, beta = 22), or log (log-spaced by speckit, beta = 25.4)",
            values=Values(words=("welch", "log")),
            optional=True,
        ),
        "/realisation/rate": Dataset((), "float", "Hz", "samples per second of the realisation", optional=True),
        "/realisation/samples": Dataset((), "int", "1", "samples of the realisation", optional=True, values=COUNT),
        "/realisation/seed": Dataset((), "int", "1", "seed of the random numbers", optional=True, values=COUNT),
    },
    fixed_dims={"band_edge": 2, "plane": 2},
    derived_dims={"area_column": ("area", 1, 0)},
    families={"output": "/output/label", "bound": "/bound_ratio/bound"},
)
