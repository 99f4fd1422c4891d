"""Numbers of figures and tables, and references to them by number, from either document to either."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from tedm_cli.report.document import (
    Block,
    Columns,
    Document,
    Facts,
    Figure,
    Folded,
    Link,
    Paragraph,
    Piece,
    Ref,
    Section,
    Table,
    Text,
    VerdictCard,
)

Numbered = Figure | Table | Columns
_OF = {"": "of the report", "A": "of the annex"}  # documents by their mark


@dataclass(frozen=True)
class _Place:
    """Where a target is: the mark of its document, what it is called there, and its anchor."""

    mark: str
    called: str
    anchor: str


def kind_of(block: Numbered) -> str:
    """What a numbered block is called before its number."""
    return "Figure" if isinstance(block, Figure) else "Table"


def anchor(block: Numbered) -> str:
    """Anchor of a numbered block."""
    return f"{kind_of(block)}-{block.number}".lower()


def numbered(documents: Sequence[Document]) -> list[Document]:
    """The documents with their figures and tables numbered in order, and all references made.

    Raises
    ------
    KeyError : a reference to what no document holds.
    """
    counted = []
    places: dict[str, _Place] = {}
    for document in documents:
        sections = _counted(document.sections, document.mark)
        counted.append(replace(document, sections=sections))
        for section in sections:
            places[section.id] = _Place(document.mark, "", section.id)
            for block in _numbered_in(section.blocks):
                key = block.file if isinstance(block, Figure) else block.key
                places[key] = _Place(document.mark, f"{kind_of(block).lower()} {block.number}", anchor(block))
    return [_with_references(d, places) for d in counted]


def held(sections: Sequence[Section], mark: str) -> list[str]:
    """The numbers of the tables and figures in each section of a document, `tables A1 to A3, figure A1`."""
    found = []
    for section in _counted(sections, mark):
        numbers: dict[str, list[str]] = {}
        for block in _numbered_in(section.blocks):
            numbers.setdefault(kind_of(block).lower(), []).append(block.number)
        found.append(", ".join(_range(kind, numbers[kind]) for kind in ("table", "figure") if kind in numbers))
    return found


def _range(kind: str, numbers: Sequence[str]) -> str:
    if len(numbers) == 1:
        return f"{kind} {numbers[0]}"
    return f"{kind}s {numbers[0]} {'and' if len(numbers) == 2 else 'to'} {numbers[-1]}"


def _counted(sections: Sequence[Section], mark: str) -> tuple[Section, ...]:
    count: Counter[str] = Counter()
    return tuple(replace(s, blocks=tuple(_count(b, mark, count) for b in s.blocks)) for s in sections)


def _count(block: Block, mark: str, count: Counter[str]) -> Block:
    if isinstance(block, Folded):
        return replace(block, blocks=tuple(_count(b, mark, count) for b in block.blocks))
    if isinstance(block, Columns) and not block.caption:
        return replace(block, blocks=tuple(_count(b, mark, count) for b in block.blocks))
    if isinstance(block, Figure | Columns) or (isinstance(block, Table) and block.caption):
        kind = kind_of(block)
        count[kind] += 1
        return replace(block, number=f"{mark}{count[kind]}")
    return block


def _numbered_in(blocks: Sequence[Block]) -> Iterator[Numbered]:
    for block in blocks:
        if isinstance(block, Figure | Table | Columns) and block.number:
            yield block
        if isinstance(block, Folded | Columns):
            yield from _numbered_in(block.blocks)


def _with_references(document: Document, places: dict[str, _Place]) -> Document:
    def piece(p: Piece) -> Piece:
        if isinstance(p, Link):
            return replace(p, away=places[p.target].mark != document.mark)
        if not isinstance(p, Ref):
            return p
        place = places[p.key]
        away = place.mark != document.mark
        return Link(f"{place.called} {_OF[place.mark]}" if away else place.called, place.anchor, away)

    def text(t: Text) -> Text:
        return t if isinstance(t, str) else tuple(map(piece, t))

    sections = tuple(replace(s, blocks=tuple(_map_texts(b, text) for b in s.blocks)) for s in document.sections)
    return replace(document, sections=sections, notes=tuple(map(text, document.notes)))


def _map_texts(block: Block, change: Callable[[Text], Text]) -> Block:
    def rows(of: tuple[tuple[str, Text], ...]) -> tuple[tuple[str, Text], ...]:
        return tuple((name, change(value)) for name, value in of)

    if isinstance(block, Paragraph):
        return replace(block, text=change(block.text))
    if isinstance(block, Facts):
        return replace(block, rows=rows(block.rows))
    if isinstance(block, VerdictCard):
        return replace(block, lead=change(block.lead), facts=rows(block.facts))
    if isinstance(block, Columns | Folded):
        return replace(block, blocks=tuple(_map_texts(b, change) for b in block.blocks))
    return block
