"""What is told of a name, as lines of text and as a plain dictionary."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

from tedm_cli.cli.printing.table import table
from tedm_cli.results.cases.chances import probability_text
from tedm_cli.results.explained import Cell, Column, Table, Told
from tedm_cli.results.wording import ratio_text
from tedm_cli.uncertainty.verdicts import Chance

_WIDTH = 118


def told_lines(told: Told, most: int | None) -> list[str]:
    """Facts, then the tables, of ranked ones the first rows."""
    title = f": {told.title}" if told.title != told.name else ""
    lines = [f"{told.name} ({told.sort}){title}", *([told.source] if told.source else []), *_wrapped(told.facts)]
    for one in told.tables:
        rows = one.rows[:most] if one.ranked else one.rows
        head = [_title(c) for c in one.columns]
        right = [i for i, c in enumerate(one.columns) if c.form in ("number", "fixed", "share", "ratio", "chance")]
        cells = [[_text(cell, column) for cell, column in zip(row, one.columns, strict=True)] for row in rows]
        lines += ["", *table(head, cells, right=right)]
        if len(rows) < len(one.rows):
            lines.append(f"and {len(one.rows) - len(rows)} more (--top 0: all)")
    return [*lines, *([""] if told.notes and told.tables else []), *_wrapped(told.notes)]


def _wrapped(lines: Sequence[str]) -> list[str]:
    """What is longer than a line goes on in the next, set in."""
    return [part for line in lines for part in textwrap.wrap(line, _WIDTH, subsequent_indent="  ")]


def told_dict(told: Told, most: int | None) -> dict[str, Any]:
    """What a program needs; shares are fractions."""
    return {
        "name": told.name,
        "sort": told.sort,
        "title": told.title,
        "file": told.source or None,
        "facts": told.facts,
        "notes": told.notes,
        "tables": {one.name: _rows(one, most) for one in told.tables},
    }


def _rows(one: Table, most: int | None) -> list[dict[str, Any]]:
    names = [c.name.replace(" ", "_") for c in one.columns]
    units: dict[str, Any] = {f"{c.name.replace(' ', '_')}_unit": c.unit for c in one.columns if c.unit}
    kept = one.rows[:most] if one.ranked else one.rows
    values = [[cell.probability if isinstance(cell, Chance) else cell for cell in row] for row in kept]
    return [{**dict(zip(names, row, strict=True)), **units} for row in values]


def _title(column: Column) -> str:
    name = f"{column.name} of {column.whole}" if column.whole else column.name
    return name + (f" ({column.unit})" if column.unit else " %" if column.form == "share" else "")


def _text(cell: Cell, column: Column) -> str:
    if cell is None:
        return "-"
    if column.form == "verdict":
        return "pass" if cell else "FAIL"
    if isinstance(cell, Chance):
        return probability_text(cell)
    if not isinstance(cell, float):
        return str(cell)
    if column.form == "share":
        return f"{100.0 * cell:.3g}"
    if column.form == "fixed":
        return f"{cell + 0.0:.1f}".replace("-0.0", "0.0") if abs(cell) < 0.05 else f"{cell:.1f}"
    if column.form == "ratio":
        return ratio_text(cell)
    return f"{cell:g}" if cell.is_integer() and abs(cell) < 1e6 else f"{cell:.3e}"
