"""The page of a trade: which variant is best by what, how they compare, and what has changed and why."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli import __version__
from tedm_cli.report.document import (
    Block,
    Cell,
    Document,
    Facts,
    Figure,
    FileLink,
    Heading,
    Paragraph,
    Row,
    Section,
    Strong,
    Table,
    Text,
    columns,
    row,
)
from tedm_cli.report.numbering import numbered
from tedm_cli.report.provenance import ReportFile, provenance_section
from tedm_cli.report.trade_changes import changes_section, contributors_section, state_of_value
from tedm_cli.results.trade import Cell as Value
from tedm_cli.results.trade import Trade
from tedm_cli.results.wording import and_text, capital, count, number_text, unit_text

EMPTY = "–"
_ACROSS = 4  # criteria beside each other in a table
_SUBJECT = "Trade of variants: criteria, Pareto front, and what has changed"


def trade_document(
    trade: Trade, figures: Sequence[Figure], files: Sequence[ReportFile], reports: Sequence[str]
) -> Document:
    """The page, numbered. `reports`: of each variant the name of its own report beside the page, or "".

    `files`: trade.h5.
    """
    sections = [
        _front_section(trade),
        _table_section(trade, figures),
        *([changes_section(trade)] if len(trade.variants) > 1 else []),
        *([contributors_section(trade)] if any(c.parts for row in trade.cells for c in row) else []),
        _what_section(trade, reports),
        provenance_section(files, figures),
    ]
    front = (
        ("Variants", str(len(trade.variants))),
        ("Criteria", str(len(trade.criteria))),
        ("Made by", f"tedm {__version__}"),
    )
    (document,) = numbered([Document(trade.title, _SUBJECT, __version__, tuple(sections), front=front)])
    return document


def _front_section(trade: Trade) -> Section:
    """What a reader decides by."""
    front, failed = trade.front, [v for v in trade.variants if v.failure]
    blocks: list[Block] = [Paragraph(_front_words(trade))]
    rows: list[tuple[str, Text]] = []
    for c, criterion in enumerate(trade.criteria):
        if best := trade.best_by(c):
            value = trade.cells[trade.names.index(best[0])][c].value
            assert value is not None
            names = Strong(and_text(best)) if trade.marked(c) or len(trade.variants) == 1 else "all alike"
            rows.append((capital(criterion.name), (names, f", {criterion.with_unit(value)}")))
        else:
            rows.append((capital(criterion.name), "no variant has it"))
    if scored := [v for v in trade.variants if v.score is not None]:
        least = min(scored, key=lambda v: v.score or 0.0)
        rows.append(("Weighted score", (Strong(least.name), f", {number_text(least.score or 0.0)} (0 best, 1 worst)")))
    blocks += [Heading("Best by each criterion"), Facts(tuple(rows))]
    others = [
        (v.name, _dominated_words(trade, v.name)) for v in trade.variants if v.name not in front and not v.failure
    ]
    if others:
        blocks += [Heading("Not on the front"), Facts(tuple(others))]
    if failed:
        blocks += [Heading("Without results"), Facts(tuple((v.name, v.failure) for v in failed))]
    blocks.append(
        Paragraph(
            "A variant is on the Pareto front unless another dominates it: one that has every criterion that it has, is"
            " at least as good in each, and better in one. A criterion that a variant lacks is neither good nor bad:"
            " nothing is better for it, and a variant does not dominate one that has a criterion more.",
            quiet=True,
        )
    )
    return Section("front", "Which variant", "Which variant", tuple(blocks))


def _front_words(trade: Trade) -> Text:
    front = trade.front
    if not front:
        return "No variant has results: none can be compared."
    compared = sum(v.front > 0 for v in trade.variants)
    whole = [name for name in front if _meets_all(trade, name)]
    said = " meets every limit by which it is judged." if len(whole) == 1 else " meet every limit."
    limits = any(cell.passed is not None for cells in trade.cells for cell in cells)
    more: tuple[str | Strong, ...] = ()
    if limits:
        more = (" Of these ", Strong(and_text(whole)), said) if whole else (" None of these meets every limit.",)
    verb = "is" if len(front) == 1 else "are"
    return (Strong(and_text(front)), f" {verb} on the Pareto front of {count(compared, 'variant')}.", *more)


def _meets_all(trade: Trade, name: str) -> bool:
    return all(cell.passed is not False for cell in trade.cells[trade.names.index(name)])


def _dominated_words(trade: Trade, name: str) -> str:
    place = trade.names.index(name)
    by = trade.dominated_by(place)
    return f"dominated by {and_text(by)}" if by else "has none of the criteria"


def _table_section(trade: Trade, figures: Sequence[Figure]) -> Section:
    chunks = np.array_split(np.arange(len(trade.criteria)), -(-len(trade.criteria) // _ACROSS))
    blocks: list[Block] = [*(_table(trade, chunk.tolist(), n) for n, chunk in enumerate(chunks)), *figures]
    lacking: list[Row] = []
    for variant, cells in zip(trade.variants, trade.cells, strict=True):
        if not variant.failure:
            pairs = zip(trade.criteria, cells, strict=True)
            lacking += [
                row(variant.name, criterion.name, cell.reason) for criterion, cell in pairs if cell.value is None
            ]
    if lacking:
        head = columns("Variant", "Criterion", "Why it is empty", text=(0, 1, 2))
        blocks.append(Table(head, tuple(lacking), "Criteria that a variant lacks.", heading_column=True))
    return Section("criteria", "Variants by criteria", "Variants by criteria", tuple(blocks))


def _table(trade: Trade, shown: Sequence[int], number: int) -> Table:
    """The values of some criteria; the front, and the score where there is one, stand in the first table."""
    first = number == 0
    has_score = first and any(v.score is not None for v in trade.variants)
    titles = ["Variant", *(["Front"] if first else []), *(["Score"] if has_score else [])]
    for c in shown:
        criterion = trade.criteria[c]
        more = ", ".join(w for w in (unit_text(criterion.unit), criterion.limit_words) if w not in ("", "1"))
        titles.append(f"{criterion.name}\n({more})" if more else criterion.name)
    best = [trade.marked(c) for c in shown]
    rows = []
    for variant, cells in zip(trade.variants, trade.cells, strict=True):
        front = "failed" if variant.failure else "Pareto" if variant.front == 1 else str(variant.front or EMPTY)
        said: list[str | Cell] = [variant.name, *([front] if first else [])]
        said += [EMPTY if variant.score is None else number_text(variant.score)] if has_score else []
        said += [_cell(trade, c, cells[c], variant.name in of) for c, of in zip(shown, best, strict=True)]
        rows.append(row(*said, kind="failed" if variant.failure else ""))
    what = "Variants by criteria" if first else "More criteria"
    caption = f"{what}; what each value is of stands behind it. A star marks the best, bold a limit that is violated."
    return Table(columns(*titles, text=(0,)), tuple(rows), caption, heading_column=True)


def _cell(trade: Trade, c: int, value: Value, is_best: bool) -> Cell:
    if value.value is None:
        return Cell(EMPTY)
    text = f"{trade.criteria[c].text(value.value)}{' *' if is_best else ''}"
    return Cell(text, state_of_value(value), label=value.of)


def _what_section(trade: Trade, reports: Sequence[str]) -> Section:
    """What the variants and the criteria are."""
    of_variants: list[tuple[str, Text]] = []
    for variant, report in zip(trade.variants, reports, strict=True):
        words = variant.differs or variant.title or variant.build
        of_variants.append((variant.name, (f"{words} ", FileLink("Its report", report)) if report else words))
    of_criteria: list[tuple[str, Text]] = []
    for criterion in trade.criteria:
        goal = "less is better" if criterion.goal == "min" else "more is better"
        judged = f"; judged by: {criterion.limit_words}" if criterion.limit_words else ""
        weight = f"; weight {criterion.weight:g}" if criterion.weight else ""
        of_criteria.append((criterion.name, f"{capital(criterion.words)}; {goal}{judged}{weight}"))
    blocks: list[Block] = [
        Heading("Variants"),
        Facts(tuple(of_variants)),
        Heading("Criteria"),
        Facts(tuple(of_criteria)),
    ]
    return Section("what", "What is compared", "What is compared", tuple(blocks))
