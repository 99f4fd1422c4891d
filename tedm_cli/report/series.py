"""Temperature series in the report: what became of each, and its verdicts."""

from __future__ import annotations

from collections.abc import Mapping

from tedm_cli.arrays import FloatArray
from tedm_cli.files.store import Reader
from tedm_cli.report.document import Block, Cell, Facts, Figure, Heading, Paragraph, Section, Table, columns, row
from tedm_cli.results.wording import mhz_text, ratio_text, sci, unit_text


def series_section(files: Mapping[str, Reader], figures: dict[str, list[Figure]]) -> Section:
    """Each series that was run: where it comes from, its figure, and how its outputs stand to the requirements."""
    blocks: list[Block] = [
        Paragraph(
            "Temperature series, measured or simulated, carried to time series and spectra of the outputs. Ratio:"
            " largest safety factor × estimated noise / requirement over the band; it contains the scatter of the"
            " estimate. In band: root mean square of the output there, before the safety factor, beside that of noise"
            " at the limit."
        )
    ]
    for (name, file), figure in zip(files.items(), figures["series"], strict=True):
        time: FloatArray = file.array("/time")
        span = f"{len(time):,} samples over {sci(float(time[-1] - time[0]))} s"
        treatment = f"{file.string('/temperature/treatment')}; {span}"
        facts = Facts((("Temperatures", file.string("/temperature/source")), ("Treatment", treatment)))
        blocks += [Heading(name), facts, figure, _verdicts(file)]
    return Section("series", "Time series", "Time series", tuple(blocks))


def _verdicts(file: Reader) -> Block:
    units = dict(zip(file.strings("/output/label"), file.strings("/output/unit"), strict=True))
    names = [file.strings(f"/verdict/{c}") for c in ("output", "requirement")]
    numbers = [file.array(f"/verdict/{c}") for c in ("ratio", "binding_frequency", "band_rms", "band_limit")]
    if not names[0]:
        return Paragraph("No requirement could be judged: none has its band within the frequencies of the estimate.")
    rows = []
    for output, requirement, ratio, at, rms, limit in zip(*names, *numbers, strict=True):
        passed = ratio <= 1.0
        unit = unit_text(units[output])
        rows.append(
            row(
                output,
                Cell("pass" if passed else "FAIL", "met" if passed else "violated"),
                ratio_text(float(ratio)),
                mhz_text(float(at)),
                requirement,
                f"{sci(float(rms), 3)} {unit}",
                f"{sci(float(limit), 3)} {unit}",
            )
        )
    head = columns(
        *("Output", "Verdict", "Ratio\n(1)", "Binds at", "Requirement", "In band", "At the limit"), text=(0, 1, 4)
    )
    return Table(head, tuple(rows))
