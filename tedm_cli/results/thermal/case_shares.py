"""What a case file says of the thermal network, where its temperatures are from there: shares by disturbance."""

from __future__ import annotations

from tedm_cli.contracts import CASE
from tedm_cli.errors import UsageError
from tedm_cli.files.store import Reader, Writer
from tedm_cli.noise.disturbances import DisturbanceContributions
from tedm_cli.results.cases.noise import JudgedDisturbances


def of_network(file: Reader) -> bool:
    """Whether an open case file has thermal nodes in place of the model's areas."""
    return file.has(CASE.DISTURBANCE_NAME)


def require_areas(file: Reader, what: str) -> None:
    """Refuse a case with thermal nodes, `UsageError`; `what` cannot take it."""
    if of_network(file):
        fact = f"case {file.string(CASE.CASE_ID)} has thermal nodes in place of areas, and {what}"
        raise UsageError(fact, hint="name a case of areas")


def write_disturbances(writer: Writer, found: DisturbanceContributions) -> None:
    """Put them into a case file."""
    writer.write(CASE.DISTURBANCE_ASD, found.asd, units="see /output/unit")
    writer.write(CASE.DISTURBANCE_NAME, found.names)
    writer.write(CASE.DISTURBANCE_SHARE, found.share)
    writer.write(CASE.DISTURBANCE_BAND_SHARE, found.band_share)
    writer.write(CASE.DISTURBANCE_LEVEL_FACTOR, found.level_factor)


def read_disturbances(file: Reader) -> list[JudgedDisturbances] | None:
    """Of every verdict of an open case file; None where it has none."""
    if not of_network(file):
        return None
    names, labels = tuple(file.strings(CASE.DISTURBANCE_NAME)), file.strings(CASE.OUTPUT_LABEL)
    share, band, level, asd = (
        file.array(d)
        for d in (
            CASE.DISTURBANCE_SHARE,
            CASE.DISTURBANCE_BAND_SHARE,
            CASE.DISTURBANCE_LEVEL_FACTOR,
            CASE.DISTURBANCE_ASD,
        )
    )
    at = [labels.index(output) for output in file.strings(CASE.VERDICT_OUTPUT)]
    return [JudgedDisturbances(names, share[o], band[o], level[v], asd[o]) for v, o in enumerate(at)]
