"""All cases: a matrix of ratios, every verdict with its ranges, the spectra, and what the cases stand for."""

from __future__ import annotations

from collections.abc import Sequence

from tedm_cli.report.document import (
    Block,
    Cell,
    Figure,
    Paragraph,
    Piece,
    Ref,
    Row,
    Section,
    Table,
    columns,
    row,
    verdict_cell,
)
from tedm_cli.report.evidence import case_head
from tedm_cli.report.verdicts import Titles
from tedm_cli.results.cases.deciding import without_repeats
from tedm_cli.results.cases.noise import CaseNoise
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import capital, ratio_text, span


def cases_section(cases: Sequence[CaseNoise], figures: Sequence[Figure]) -> Section:
    """Ratios of all cases at a glance, and their spectra in one figure for each quantity."""
    text: list[Piece] = [
        "A case says which temperatures move together. Ratio: largest safety factor × noise / limit over the band, met"
        " where it is at most 1."
    ]
    if not cases[0].judged:
        return Section("cases", "Evidence: every case", "Every case", (Paragraph(tuple(text)), *figures))
    text += [" Every verdict with its ranges is in ", Ref("every verdict"), "."]
    blocks: list[Block] = [Paragraph(tuple(text)), _matrix(cases)]
    return Section("cases", "Evidence: every case", "Every case", (*blocks, *figures))


def every_case_section(cases: Sequence[CaseNoise], figures: Sequence[Figure], titles: Titles) -> Section:
    """All verdicts of all cases, and small multiples of their spectra."""
    blocks: list[Block] = [] if not cases[0].judged else [_verdicts(cases, titles)]
    return Section("every-case", "Every case", "Every case", (*blocks, *figures))


def what_cases_stand_for(cases: Sequence[CaseNoise]) -> Table:
    """Each case with its role, and why it is looked at."""
    reasons = tuple(row(c.id, c.role, c.title, c.reason) for c in cases)
    head = columns("Case", "Role", "Correlation", "Why it is looked at", text=(0, 1, 2, 3))
    caption = (
        "What the cases stand for. Likely cases decide; possible ones can occur; diagnostic ones isolate a part and"
        " decide nothing."
    )
    return Table(head, reasons, caption, tight=True, key="roles")


def _matrix(cases: Sequence[CaseNoise]) -> Table:
    """Cases by judged outputs."""
    rows: list[Row] = []
    for case in (merged := without_repeats(cases)):
        cells = [
            Cell(ratio_text(j.ratio) + ("" if j.passed else " FAIL"), "met" if j.passed else "violated")
            for j in case.judged
        ]
        rows.append(row(case.id, case.title, case.role, *cells))
    titles = [
        capital(output_title(j.output)).replace(", ", ",\n").replace(" of test", "\nof test") for j in merged[0].judged
    ]
    caption = "Ratio of noise to limit in every case."
    return Table(columns("Case", "Correlation", "Role", *titles, text=(0, 1, 2)), tuple(rows), caption, tight=True)


def _verdicts(cases: Sequence[CaseNoise], titles: Titles) -> Table:
    head = columns(
        *("Output", "Verdict", "Ratio\n(1)", "Binds at\n(mHz)", "Requirement"),
        *("Other filters\n(ratio)", "Other correlations\n(ratio)"),
        text=(0, 1, 4),
    )
    rows: list[Row] = []
    for case in without_repeats(cases):
        rows.append(case_head(case))
        for j in case.judged:
            filters = j.filter_ratio
            rows.append(
                row(
                    Cell(capital(output_title(j.output)), label=j.output),
                    verdict_cell(j.passed),
                    ratio_text(j.ratio),
                    f"{j.binding_hz * 1e3:.3g}",
                    titles(j.requirement),
                    "no low-pass" if filters is None else span(float(filters.min()), float(filters.max())),
                    span(*j.correlation_ratio),
                )
            )
    caption = "Every verdict, with its frequency and its ranges over other temperature filters and other correlations."
    return Table(head, tuple(rows), caption, tight=True, key="every verdict")


def spectra_section(figures: Sequence[Figure]) -> Section:
    """The figure of every case."""
    text = (
        "Amplitude spectral densities, square roots of one-sided power spectral densities, multiplied by the safety"
        " factor. The light envelope holds every correlation of the areas that are active in the case, for the output"
        " with the largest ratio."
    )
    return Section("figures", "Spectra by case", "Spectra by case", (Paragraph(text), *figures))
