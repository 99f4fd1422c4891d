"""A document as Markdown with pipe tables, for issue trackers and wikis; figures are links to their files."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from tedm_cli.report.document import (
    Block,
    Columns,
    Document,
    Facts,
    Figure,
    Folded,
    Heading,
    Listing,
    Paragraph,
    Row,
    Strong,
    Table,
    Text,
    VerdictCard,
)


def to_markdown(document: Document, figures: str) -> str:
    """Markdown (CommonMark with tables); `figures` is the folder of the figures as seen from the file."""
    lines = [
        f"# {_escape(document.title)}",
        "",
        f"{_begin(_escape(document.subject))}. Made by tedm {document.version}.",
    ]
    for note in document.notes:
        lines += ["", _begin(_inline(note))]
    for section in document.sections:
        lines += ["", f"## {_escape(section.title)}"]
        for block in section.blocks:
            lines += _block(block, figures)
    return "\n".join(lines) + "\n"


def _block(block: Block, figures: str) -> Iterator[str]:
    if isinstance(block, Paragraph):
        yield from ("", _begin(_inline(block.text)))
    elif isinstance(block, Heading):
        yield from ("", f"### {_escape(block.text)}")
    elif isinstance(block, Facts):
        yield from ("", *_facts(block.rows))
    elif isinstance(block, Table):
        yield from _table(block)
    elif isinstance(block, Figure):
        yield from ("", f"![{_escape(block.caption)}]({figures}/{block.file})", "", _begin(_escape(block.caption)))
    elif isinstance(block, VerdictCard):
        yield from ("", f"**{block.word}**: {_inline(block.lead)}", "", *_facts(block.facts))
    elif isinstance(block, Columns):
        for inner in block.blocks:
            yield from _block(inner, figures)
    elif isinstance(block, Folded):
        yield from ("", f"**{_escape(block.summary)}**")
        for inner in block.blocks:
            yield from _block(inner, figures)
    elif isinstance(block, Listing):
        longest = max((len(m) for m in re.findall(r"`+", block.text)), default=0)
        fence = "`" * max(3, longest + 1)
        yield from ("", fence, block.text.rstrip("\n"), fence)


def _facts(rows: Sequence[tuple[str, Text]]) -> list[str]:
    return [f"- {_begin(_escape(name))}: {_inline(value)}" for name, value in rows]


def _table(table: Table) -> Iterator[str]:
    """Groups become a column of their own: pipe tables have no cells that span."""
    grouped = any(row.kind == "head" for row in table.rows)
    titles = ([" "] if grouped else []) + [c.title.replace("\n", " ") or " " for c in table.columns]
    ruler = (["---"] if grouped else []) + ["---" if c.text else "---:" for c in table.columns]
    if table.caption:
        yield from ("", f"**{_escape(table.caption)}**")
    yield from ("", _line([_escape(t) for t in titles]), _line(ruler))
    group = ""
    for row in table.rows:
        if row.kind == "head":
            group = " ".join(c.text for c in row.cells[:2])
        else:
            yield _line(([_escape(group)] if grouped else []) + _cells(row))


def _cells(row: Row) -> list[str]:
    return [f"**{_escape(c.text)}**" if c.state == "violated" and c.text else _escape(c.text) for c in row.cells]


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _inline(text: Text) -> str:
    if isinstance(text, str):
        return _escape(text)
    return "".join(
        _escape(p) if isinstance(p, str) else f"**{_escape(p.text)}**" if isinstance(p, Strong) else _escape(p.text)
        for p in text
    )


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
