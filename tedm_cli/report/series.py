"""Temperature series in the report: what became of each, and its verdicts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tedm_cli.report.document import (
    Block,
    Cell,
    Facts,
    Figure,
    Heading,
    Paragraph,
    Section,
    Table,
    columns,
    row,
    verdict_cell,
)
from tedm_cli.report.verdicts import Titles
from tedm_cli.results.cases.series import SeriesSummary
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import capital, mhz_text, ratio_text, sci, unit_text


def series_section(series: Mapping[str, SeriesSummary], figures: Sequence[Figure], titles: Titles) -> Section:
    """Each series that was run: where it comes from, its figure, and how its outputs stand to the requirements."""
    blocks: list[Block] = [
        Paragraph(
            "Time series and spectra of the outputs, computed from measured or simulated temperature series. Ratio:"
            " largest safety factor × estimated noise / requirement over what the spectrum has of the band; it"
            " contains the scatter of the estimate. In band: root mean square of the output there, before the safety"
            " factor, beside that of noise at the limit."
        )
    ]
    for (name, s), figure in zip(series.items(), figures, strict=True):
        treatment = f"{s.treatment}; {s.samples:,} samples over {sci(s.span_s)} s"
        facts = Facts((("Temperatures", s.source), ("Treatment", treatment)))
        blocks += [Heading(name), facts, figure, *verdict_blocks(name, s, titles)]
    return Section("series", "Time series", "Time series", tuple(blocks))


def verdict_blocks(name: str, s: SeriesSummary, titles: Titles) -> list[Block]:
    """How the outputs of a series stand to their requirements, and what of those is not judged."""
    told = [Paragraph(f"Not judged: {'; '.join(s.unjudged)}.")] if s.unjudged else []
    if not s.verdicts:
        return [Paragraph("No requirement could be judged."), *told]
    rows = [
        row(
            Cell(capital(output_title(v.output)), label=v.output),
            verdict_cell(v.passed),
            ratio_text(v.ratio),
            mhz_text(v.binding_hz),
            v.band_text,
            Cell(titles(v.requirement), label=v.requirement),
            f"{sci(v.band_rms, 3)} {unit_text(v.unit)}",
            f"{sci(v.band_limit, 3)} {unit_text(v.unit)}",
        )
        for v in s.verdicts
    ]
    head = columns(
        *("Output", "Verdict", "Ratio\n(1)", "Binds at", "Judged over", "Requirement", "In band", "At the limit"),
        text=(0, 1, 4, 5),
    )
    return [Table(head, tuple(rows), f"Verdicts on the series {name}.", tight=True), *told]
