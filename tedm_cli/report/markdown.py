"""A document as Markdown with pipe tables, for issue trackers and wikis; figures are links to their files."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from urllib.parse import quote

from tedm_cli.report.document import (
    Block,
    Cell,
    Columns,
    Document,
    Facts,
    Figure,
    FileLink,
    Folded,
    Heading,
    Label,
    Link,
    Listing,
    Paragraph,
    Piece,
    Row,
    Strong,
    Table,
    Text,
    VerdictCard,
    plain,
)
from tedm_cli.report.numbering import kind_of


def to_markdown(document: Document, figures: str, other: str = "") -> str:
    """Markdown (CommonMark with tables).

    `figures` is the folder of the figures as seen from the file, `other` the name of the other document beside it, if
    there is one.
    """
    here = _Place(figures, other)
    lines = [f"# {_escape(document.title)}", "", _begin(_escape(document.subject)), ""]
    lines += _facts([(name, value) for name, value in document.front], here)
    for note in document.notes:
        lines += ["", _begin(_inline(note, here))]
    lines += ["", "**Contents**", ""]
    lines += [f"- {_begin(_escape(section.title))}" for section in document.sections]
    for section in document.sections:
        lines += ["", f"## {_escape(section.title)}"]
        for block in section.blocks:
            lines += _block(block, here)
    return "\n".join(lines) + "\n"


@dataclass(frozen=True)
class _Place:
    """The folder of the figures as seen from the file, and the file of the other document."""

    figures: str
    other: str


def _block(block: Block, here: _Place) -> Iterator[str]:
    if isinstance(block, Paragraph):
        yield from ("", _begin(_inline(block.text, here)))
    elif isinstance(block, Heading):
        yield from ("", f"### {_escape(block.text)}")
    elif isinstance(block, Facts):
        yield from ("", *_facts(block.rows, here))
    elif isinstance(block, Table):
        yield from _table(block)
    elif isinstance(block, Figure):
        image = f"![{_escape(block.caption)}]({here.figures}/{block.file})"
        yield from ("", image, "", _caption(block))
    elif isinstance(block, VerdictCard):
        yield from ("", f"**{block.word}**: {_inline(block.lead, here)}", "", *_facts(block.facts, here))
    elif isinstance(block, Columns):
        if block.number:
            yield from ("", _caption(block))
        for inner in block.blocks:
            yield from _block(inner, here)
    elif isinstance(block, Folded):
        yield from ("", f"**{_escape(block.summary)}**")
        for inner in block.blocks:
            yield from _block(inner, here)
    elif isinstance(block, Listing):
        longest = max((len(m) for m in re.findall(r"`+", block.text)), default=0)
        fence = "`" * max(3, longest + 1)
        yield from ("", fence, block.text.rstrip("\n"), fence)


def _caption(block: Figure | Table | Columns) -> str:
    return f"**{kind_of(block)} {block.number}.** {_escape(block.caption)}"


def _facts(rows: Sequence[tuple[str, Text]], here: _Place) -> list[str]:
    return [f"- {_begin(_escape(name))}: {_inline(value, here)}" for name, value in rows]


def _table(table: Table) -> Iterator[str]:
    """Groups become a column of their own: pipe tables have no cells that span."""
    grouped = any(row.kind == "head" for row in table.rows)
    titles = ([" "] if grouped else []) + [c.title.replace("\n", " ") or " " for c in table.columns]
    ruler = (["---"] if grouped else []) + ["---" if c.text else "---:" for c in table.columns]
    if table.number:
        yield from ("", _caption(table))
    elif table.caption:
        yield from ("", f"**{_escape(table.caption)}**")
    yield from ("", _line([_escape(t) for t in titles]), _line(ruler))
    group = ""
    for row in table.rows:
        if row.kind == "head":
            group = ": ".join(c.text for c in row.cells[:2] if c.text)
        else:
            yield _line(([_escape(group)] if grouped else []) + _cells(row))


def _cells(row: Row) -> list[str]:
    return [_cell(c) + (f" ({_escape(c.label)})" if c.label else "") for c in row.cells]


def _cell(cell: Cell) -> str:
    """What is violated or at risk is bold, for pipe tables have no colours."""
    return f"**{_escape(cell.text)}**" if cell.state in ("violated", "open") and cell.text else _escape(cell.text)


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _inline(text: Text, here: _Place) -> str:
    return _escape(text) if isinstance(text, str) else "".join(_piece(p, here) for p in text)


def _piece(piece: Piece, here: _Place) -> str:
    """A piece of a text. What is in the same file is no link: anchors differ from reader to reader."""
    if isinstance(piece, str):
        return _escape(piece)
    words = _escape(plain((piece,)))
    if isinstance(piece, Strong):
        return f"**{words}**"
    if isinstance(piece, Label):
        return f"({words})"
    if isinstance(piece, FileLink):
        return f"[{words}]({quote(piece.name)})"
    if isinstance(piece, Link) and piece.away:
        return f"[{words}]({quote(here.other)})"
    return words


def _escape(text: str) -> str:
    """Signs that Markdown or HTML would take for markup; `_` inside of words is none."""
    text = re.sub(r"([\\`*\[\]|<>$~#])", r"\\\1", text)
    text = re.sub(r"&(?=#?\w+;)", r"\\&", text)
    text = re.sub(r"(?<![^\W_])_|_(?![^\W_])", r"\\_", text)
    return re.sub(r"[\x00-\x1f\x7f-\x9f\u2028\u2029]+", " ", text)  # a line end would begin another block


def _begin(line: str) -> str:
    """A line whose first signs would make a list, a rule or a block of code of it."""
    line = line.lstrip()
    return re.sub(
        r"^(?:([-+])(?=[-\s]|$)|(\d+)([.)])(?=\s|$))", lambda m: f"\\{m[1]}" if m[1] else f"{m[2]}\\{m[3]}", line
    )
