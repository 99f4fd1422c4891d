"""A document as one HTML page that needs nothing but itself."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any
from urllib.parse import quote

import jinja2
from markupsafe import Markup, escape

from tedm_cli.report.document import Block, Document, Figure, FileLink, Label, Link, Strong, Text
from tedm_cli.report.inline import inline_svg, size_of
from tedm_cli.report.numbering import anchor, kind_of

_SMALL_PT = 520.0  # figures no wider than this may stand two abreast


def to_html(document: Document, other: str = "") -> str:
    """The page; figures are scalable, and tables and figures that are too wide scroll by themselves.

    `other`: name of the file that holds the other document, beside this one; "" where there is none.
    """
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("tedm_cli.report"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters.update(
        inline=lambda text: _inline(text, quote(other)),
        lines=_lines,
        svg=_svg,
        kind=lambda block: type(block).__name__,
        kind_of=kind_of,
        anchor=anchor,
        arranged=_arranged,
    )
    return environment.get_template("report.html.j2").render(document=document, other=quote(other))


def _inline(text: Text, other: str) -> Markup:
    pieces: tuple[Any, ...] = (text,) if isinstance(text, str) else text
    out = Markup()
    for piece in pieces:
        if isinstance(piece, Strong):
            out += Markup("<strong>{}</strong>").format(piece.text)
        elif isinstance(piece, Link):
            out += Markup('<a href="{}#{}">{}</a>').format(other if piece.away else "", piece.target, piece.text)
        elif isinstance(piece, FileLink):
            out += Markup('<a href="{}">{}</a>').format(quote(piece.name), piece.text)
        elif isinstance(piece, Label):
            out += Markup('<span class="label">{}</span>').format(piece.text)
        else:
            out += escape(piece)
    return out


def _arranged(blocks: Sequence[Block]) -> list[Block | list[Figure]]:
    """The blocks, with small figures that follow each other put into one list: they may stand two abreast."""
    out: list[Block | list[Figure]] = []
    for block in blocks:
        if isinstance(block, Figure) and size_of(block.svg)[0] <= _SMALL_PT:
            if out and isinstance(out[-1], list):
                out[-1].append(block)
            else:
                out.append([block])
        else:
            out.append(block)
    return out


def _lines(text: str) -> Markup:
    return Markup("<br>").join(text.split("\n"))


def _svg(figure: Figure) -> Markup:
    return Markup(inline_svg(figure.svg, f"{figure.key}-", figure.caption))
