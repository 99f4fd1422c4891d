"""series_NAME.h5: outputs as time series, from measured or simulated temperatures."""

from __future__ import annotations

from tedm_cli.contracts.spec import AREAS, FLAG, NAMES, QUANTITIES, Dataset, FileKind, Values

SERIES = FileKind(
    "series",
    2,
    "tedm run-series",
    {
        **AREAS,
        "/temperature/column": Dataset(
            ("area",), "str", "1", "column of the temperature series that the area follows; empty: constant"
        ),
        "/temperature/source": Dataset((), "str", "1", "name of the temperature series and of its file"),
        "/temperature/treatment": Dataset((), "str", "1", "what was removed and how the series was resampled"),
        "/time": Dataset(("sample",), "float", "s", "time of the samples"),
        "/output/label": Dataset(("output",), "str", "1", "outputs", values=NAMES),
        "/output/unit": Dataset(("output",), "str", "1", "unit of the output"),
        "/output/kind": Dataset(("output",), "str", "1", "quantity of the output", values=QUANTITIES),
        "/output/rms": Dataset(("output",), "float", None, "root mean square of the series"),
        "/output/peak": Dataset(("output",), "float", None, "largest absolute value of the series"),
        "/series/{output}": Dataset(("sample",), "float", None, "time series of the output"),
        "/frequency": Dataset(("frequency",), "float", "Hz", "frequency of the estimates"),
        "/psd/{output}": Dataset(("frequency",), "float", None, "estimated one-sided power spectral density"),
        "/degrees_of_freedom": Dataset(
            ("frequency",), "float", "1", "equivalent degrees of freedom of the estimate (chi-square)"
        ),
        "/verdict/safety_factor": Dataset((), "float", "1", "factor on amplitudes when judged, not applied elsewhere"),
        "/verdict/requirement": Dataset(("verdict",), "str", "1", "requirement"),
        "/verdict/output": Dataset(
            ("verdict",), "str", "1", "output that is judged", values=Values(of="/output/label")
        ),
        "/verdict/ratio": Dataset(
            ("verdict",), "float", "1", "largest ratio of safety factor x estimated ASD to the requirement"
        ),
        "/verdict/binding_frequency": Dataset(("verdict",), "float", "Hz", "frequency of the largest ratio"),
        "/verdict/passed": Dataset(("verdict",), "int", "1", "1 where the ratio is at most 1", values=FLAG),
        "/verdict/band_rms": Dataset(("verdict",), "float", None, "rms of the output in the band"),
        "/verdict/band_limit": Dataset(("verdict",), "float", None, "rms of noise at the requirement in the band"),
    },
    families={"output": "/output/label"},
)
