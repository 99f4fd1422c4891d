"""release.h5: motion and commands of the closed loop after coordinates are let go somewhere."""

from __future__ import annotations

from tedm_cli.contracts.spec import NAMES, Dataset, FileKind


class ReleaseFile(FileKind):
    """Its datasets by name; `RELEASE` is the kind of file."""

    RELEASE_COORDINATE = Dataset(
        "/release/coordinate",
        ("released",),
        "str",
        "1",
        "coordinates that are displaced at the start",
        values=NAMES,
    )
    RELEASE_OFFSET = Dataset("/release/offset", ("released",), "float", None, "where they are then")
    TIME = Dataset("/time", ("sample",), "float", "s", "time since the release")
    OUTPUT_LABEL = Dataset("/output/label", ("output",), "str", "1", "coordinates and commands", values=NAMES)
    OUTPUT_UNIT = Dataset("/output/unit", ("output",), "str", "1", "unit of the output")
    OUTPUT_PEAK = Dataset("/output/peak", ("output",), "float", None, "largest absolute value of the series")
    OUTPUT_SETTLED = Dataset(
        "/output/settled",
        ("output",),
        "float",
        "s",
        "time from which on it stays within a hundredth of its peak; infinite: not before the end",
        open_ended=True,
    )
    SERIES = Dataset("/series/{output}", ("sample",), "float", None, "time series of the output")


RELEASE = ReleaseFile("release", 1, "tedm simulate --release", families={"output": "/output/label"})
