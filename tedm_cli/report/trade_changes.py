"""What has changed from the first variant to each other, by what; and contributors of all variants side by side."""

from __future__ import annotations

from collections.abc import Sequence

from tedm_cli.report.document import Block, Cell, Heading, Paragraph, Row, Section, State, Table, columns, row
from tedm_cli.results.trade import Cell as Value
from tedm_cli.results.trade import Trade, TradedCriterion
from tedm_cli.results.wording import percent, sci
from tedm_cli.trade.changes import changes, largest_of_any

_MOST = 3  # changes told of a criterion
_TOP = 5  # contributors of each variant
_ACROSS = 6  # variants beside each other
_LITTLE = 0.01  # of the value: parts that change less are not told
_NONE = "–"


def changes_section(trade: Trade) -> Section:
    """Each variant against the first."""
    first = trade.variants[0]
    words = (
        f"Each variant against the first, {first.name}. Parts of a ratio are of its square, to which they sum: the"
        " share of a contributor times the square. A negative part cancels others."
    )
    blocks: list[Block] = [Paragraph(words)]
    for v, variant in enumerate(trade.variants[1:], start=1):
        said = f": {variant.differs}" if variant.differs else ""
        blocks.append(Heading(f"{variant.name}{said}"))
        pairs = zip(trade.criteria, trade.cells[0], trade.cells[v], strict=True)
        rows = [_change(*found) for found in pairs if found[1].value is not None and found[2].value is not None]
        if not rows:
            blocks.append(Paragraph(f"It has no criterion in common with {first.name}."))
            continue
        head = columns("Criterion", first.name, variant.name, "Factor", "Parts that have changed most", text=(0, 4))
        caption = f"From {first.name} to {variant.name}."
        blocks.append(Table(head, tuple(rows), caption, heading_column=True))
    return Section("changes", "What has changed, and why", "What has changed", tuple(blocks))


def _change(criterion: TradedCriterion, before: Value, after: Value) -> Row:
    assert before.value is not None
    assert after.value is not None
    factor = sci(after.value / before.value, 3) if before.value > 0.0 and after.value > 0.0 else _NONE
    cells = [Cell(criterion.with_unit(v.value or 0.0), state_of_value(v), label=v.of) for v in (before, after)]
    return row(criterion.name, *cells, factor, _parts_words(criterion, before, after))


def state_of_value(value: Value) -> State | None:
    """The verdict on a value, as cells of tables show it."""
    return None if value.passed is None else "met" if value.passed else "violated"


def _parts_words(criterion: TradedCriterion, before: Value, after: Value) -> str:
    """`STRUT_5 35.1 to 4.0, ...` of the parts that have changed most."""
    if not before.parts or not after.parts:
        return _NONE
    size = max(sum(map(abs, parts.values())) for parts in (before.parts, after.parts))
    found = [change for change in changes(before.parts, after.parts) if abs(change.difference) > _LITTLE * size]
    said = [f"{change.name} {_part(change.before)} to {_part(change.after)}" for change in found[:_MOST]]
    return ", ".join(said) or "none by more than a hundredth"


def _part(part: float | None) -> str:
    return "nothing" if part is None else sci(part, 3)


def contributors_section(trade: Trade) -> Section:
    """A table for each criterion that has contributors: those of any variant, side by side."""
    blocks: list[Block] = [
        Paragraph(
            "The largest contributors of each variant, in all of them. A share is of the sum of all parts; a negative"
            " one cancels others. A dash: this variant has no such contributor, or nothing comes of it."
        )
    ]
    for c, criterion in enumerate(trade.criteria):
        shown = [v for v, cells in enumerate(trade.cells) if cells[c].parts]
        for begin in range(0, len(shown), _ACROSS):
            blocks.append(_contributors(trade, c, criterion, shown[begin : begin + _ACROSS]))
    return Section("contributors", "Contributors side by side", "Contributors", tuple(blocks))


def _contributors(trade: Trade, c: int, criterion: TradedCriterion, shown: Sequence[int]) -> Table:
    of = [trade.cells[v][c] for v in shown]
    totals = [sum(cell.parts.values()) for cell in of]
    names = largest_of_any([cell.parts for cell in of], _TOP)
    rows = [
        row(name, *(_share(cell.parts.get(name), total) for cell, total in zip(of, totals, strict=True)))
        for name in names
    ]
    values = [Cell(criterion.with_unit(cell.value or 0.0), state_of_value(cell)) for cell in of]
    head = columns("Contributor", *(trade.names[v] for v in shown), text=(0,))
    caption = f"{criterion.name}: shares of the contributors, {criterion.parts}; the value itself in the last row."
    return Table(head, (*rows, row("value", *values, kind="sum")), caption, heading_column=True)


def _share(part: float | None, total: float) -> str:
    return _NONE if part is None or total == 0.0 else percent(part / total, 1)
