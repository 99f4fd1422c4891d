"""All cases in the report: a matrix of ratios, every verdict with its ranges, and the spectra."""

from __future__ import annotations

from collections.abc import Sequence

from tedm_cli.report.document import (
    Block,
    Cell,
    Figure,
    Folded,
    Paragraph,
    Row,
    Section,
    Table,
    columns,
    row,
    verdict_cell,
)
from tedm_cli.report.evidence import case_head
from tedm_cli.results.deciding import without_repeats
from tedm_cli.results.noise import CaseNoise
from tedm_cli.results.wording import ratio_text, span


def cases_section(cases: Sequence[CaseNoise], figures: dict[str, list[Figure]]) -> Section:
    """Ratios of all cases at a glance, small multiples of their spectra, and all verdicts."""
    blocks: list[Block] = [
        Paragraph(
            "Ratio: largest safety factor × noise / requirement over the band, met where it is at most 1, with the"
            " frequency that binds. A case says which temperatures move together."
        )
    ]
    matrix = _matrix(cases)
    if matrix is not None:
        blocks.append(matrix)
    blocks += figures["all cases"]
    if matrix is not None:
        blocks.append(Folded("Every verdict, with its frequency and its ranges", (_verdicts(cases),)))
    reasons = tuple(row(c.id, c.role, c.title, c.reason) for c in cases)
    head = columns("Case", "Role", "Correlation", "Why it is looked at", text=(0, 1, 2, 3))
    blocks.append(Folded("What the cases stand for", (Table(head, reasons),)))
    return Section("cases", "Evidence: all cases", "Cases", tuple(blocks))


def _matrix(cases: Sequence[CaseNoise]) -> Table | None:
    """Cases by judged outputs."""
    if not cases[0].judged:
        return None
    rows: list[Row] = []
    for case in (merged := without_repeats(cases)):
        cells = [
            Cell(ratio_text(j.ratio) + ("" if j.passed else " FAIL"), "met" if j.passed else "violated")
            for j in case.judged
        ]
        rows.append(row(f"{case.id}", case.title, "" if case.role == "possible" else case.role, *cells))
    titles = [f"{j.output}\n{j.requirement}".replace(", ", ",\n") for j in merged[0].judged]
    return Table(columns("Case", "Correlation", "Role", *titles, text=(0, 1, 2)), tuple(rows), tight=True)


def _verdicts(cases: Sequence[CaseNoise]) -> Table:
    head = columns(
        *("Output", "Verdict", "Ratio\n(1)", "Binds at\n(mHz)", "Requirement"),
        *("Other filters\n(ratio)", "Other correlations\n(ratio)"),
        text=(0, 1, 4),
    )
    rows: list[Row] = []
    for case in cases:
        rows.append(case_head(case))
        for j in case.judged:
            filters = j.filter_ratio
            rows.append(
                row(
                    j.output,
                    verdict_cell(j.passed),
                    ratio_text(j.ratio),
                    f"{j.binding_hz * 1e3:.3g}",
                    j.requirement,
                    "no low-pass" if filters is None else span(float(filters.min()), float(filters.max())),
                    span(*j.correlation_ratio),
                )
            )
    return Table(head, tuple(rows))


def spectra_section(figures: dict[str, list[Figure]]) -> Section:
    """The figure of every case."""
    text = (
        "Amplitude spectral densities, square roots of one-sided power spectral densities, multiplied by the safety"
        " factor. The light envelope holds every correlation of the areas that are active in the case, for the output"
        " with the largest ratio."
    )
    return Section("figures", "Spectra by case", "Spectra by case", (Paragraph(text), *figures["cases"]))
