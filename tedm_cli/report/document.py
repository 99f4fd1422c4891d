"""What a report consists of, apart from how it looks: sections of paragraphs, facts, tables, verdicts and figures.

Texts are plain, or tuples of plain and marked pieces; a renderer for each format escapes them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal


@dataclass(frozen=True)
class Strong:
    """Words that must not be overlooked."""

    text: str


@dataclass(frozen=True)
class Link:
    """Words that lead to the section `target`."""

    text: str
    target: str


Text = str | tuple[str | Strong | Link, ...]
State = Literal["met", "violated", "open"]


@dataclass(frozen=True)
class Paragraph:
    """`quiet`: beside the point, a note."""

    text: Text
    quiet: bool = False


@dataclass(frozen=True)
class Heading:
    """A heading inside a section."""

    text: str


@dataclass(frozen=True)
class Facts:
    """What is said of what."""

    rows: tuple[tuple[str, Text], ...]


@dataclass(frozen=True)
class Cell:
    """`state` of a verdict; `rounding`: nothing but rounding is left of the number; `long`: may be broken anywhere."""

    text: str
    state: State | None = None
    rounding: bool = False
    long: bool = False


@dataclass(frozen=True)
class Column:
    """`title` has its unit on a second line."""

    title: str
    text: bool = False


@dataclass(frozen=True)
class Row:
    """`kind`: a "sum" of those before it, a "failed" one, or the "head" of a group, which spans all columns."""

    cells: tuple[Cell, ...]
    kind: Literal["", "sum", "failed", "head"] = ""


@dataclass(frozen=True)
class Table:
    """`tight`: many columns, which need narrow gaps; `heading_column`: the first column says what the row is."""

    columns: tuple[Column, ...]
    rows: tuple[Row, ...]
    caption: str = ""
    tight: bool = False
    heading_column: bool = False


@dataclass(frozen=True)
class Figure:
    """`key` is unique in a document; `svg`: text of an SVG file; `file`: its name in the folder of the figures."""

    key: str
    caption: str
    svg: str
    file: str


@dataclass(frozen=True)
class VerdictCard:
    """What is decided about the requirement `name`: `lead` in a sentence, then the facts behind it."""

    state: State
    word: str
    name: str
    lead: Text
    facts: tuple[tuple[str, Text], ...] = ()


@dataclass(frozen=True)
class Columns:
    """Blocks that may stand beside each other."""

    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class Folded:
    """Blocks that only some readers want to see."""

    summary: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class Listing:
    """Text of a file, word for word."""

    text: str


Block = Paragraph | Heading | Facts | Table | Figure | VerdictCard | Columns | Folded | Listing


@dataclass(frozen=True)
class Section:
    """A section with its anchor; `short`: its name where there is little room."""

    id: str
    title: str
    short: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class Document:
    """A report; `notes` stand below its title."""

    title: str
    subject: str
    version: str
    sections: tuple[Section, ...]
    notes: tuple[Text, ...] = field(default=())


def row(*cells: str | Cell, kind: Literal["", "sum", "failed", "head"] = "") -> Row:
    """A row of texts and cells."""
    return Row(tuple(c if isinstance(c, Cell) else Cell(c) for c in cells), kind)


def verdict_cell(passed: bool) -> Cell:
    """A verdict in a word."""
    return Cell("pass" if passed else "FAIL", "met" if passed else "violated")


def columns(*titles: str, text: Sequence[int] = ()) -> tuple[Column, ...]:
    """Columns by their titles; those in `text` hold words, the others numbers."""
    return tuple(Column(title, i in text) for i, title in enumerate(titles))


def plain(text: Text) -> str:
    """A text without its marks."""
    return text if isinstance(text, str) else "".join(p if isinstance(p, str) else p.text for p in text)
