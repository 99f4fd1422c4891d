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
    """Words that lead to `target`, the anchor of a section, figure or table; `away`: in the other document."""

    text: str
    target: str
    away: bool = False


@dataclass(frozen=True)
class Ref:
    """A figure or table, by its key, in either document; `numbering` makes "table A3 of the annex" of it."""

    key: str


@dataclass(frozen=True)
class FileLink:
    """Words that lead to a file beside the report."""

    text: str
    name: str


@dataclass(frozen=True)
class Label:
    """What commands and files call the thing just named: in small type."""

    text: str


Piece = str | Strong | Link | Ref | FileLink | Label
Text = str | tuple[Piece, ...]
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
    """`state` of a verdict; `rounding`: nothing but rounding is left of the number; `long`: may be broken anywhere.

    `label`: what commands and files call the thing that `text` names.
    """

    text: str
    state: State | None = None
    rounding: bool = False
    long: bool = False
    label: str = ""


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
    """`tight`: many columns, which need narrow gaps; `heading_column`: the first column says what the row is.

    `key` is what a `Ref` names; `number` is given by `numbering`, to every table with a caption.
    """

    columns: tuple[Column, ...]
    rows: tuple[Row, ...]
    caption: str = ""
    tight: bool = False
    heading_column: bool = False
    key: str = ""
    number: str = ""


@dataclass(frozen=True)
class Figure:
    """`key` is unique in both documents; `svg`: text of an SVG file; `file`: its name in the folder of the figures.

    `number` is given by `numbering`.
    """

    key: str
    caption: str
    svg: str
    file: str
    number: str = ""


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
    """Blocks that may stand beside each other; with a `caption` they are the parts of one numbered table."""

    blocks: tuple[Block, ...]
    caption: str = ""
    key: str = ""
    number: str = ""


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
    """A section with its anchor; `short`: its name where there is little room; `new_page`: begins one in print."""

    id: str
    title: str
    short: str
    blocks: tuple[Block, ...]
    new_page: bool = False


@dataclass(frozen=True)
class Document:
    """The report, or its annex.

    `front`: rows of the title block; `notes` stand below it. `mark` stands before the
    numbers of figures and tables.
    """

    title: str
    subject: str
    version: str
    sections: tuple[Section, ...]
    notes: tuple[Text, ...] = field(default=())
    front: tuple[tuple[str, str], ...] = ()
    mark: str = ""


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
    pieces = (text,) if isinstance(text, str) else text
    return "".join(p if isinstance(p, str) else p.key if isinstance(p, Ref) else p.text for p in pieces)
