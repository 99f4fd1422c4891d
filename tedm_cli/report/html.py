"""A document as one HTML page that needs nothing but itself."""

from __future__ import annotations

from typing import Any

import jinja2
from markupsafe import Markup, escape

from tedm_cli.report.document import Document, Figure, Link, Strong, Text
from tedm_cli.report.inline import inline_svg


def to_html(document: Document) -> str:
    """The page; figures are scalable, and tables and figures that are too wide scroll by themselves."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("tedm_cli.report"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters.update(inline=_inline, lines=_lines, svg=_svg, kind=lambda block: type(block).__name__)
    return environment.get_template("report.html.j2").render(document=document)


def _inline(text: Text) -> Markup:
    pieces: tuple[Any, ...] = (text,) if isinstance(text, str) else text
    out = Markup()
    for piece in pieces:
        if isinstance(piece, Strong):
            out += Markup("<strong>{}</strong>").format(piece.text)
        elif isinstance(piece, Link):
            out += Markup('<a href="#{}">{}</a>').format(piece.target, piece.text)
        else:
            out += escape(piece)
    return out


def _lines(text: str) -> Markup:
    return Markup("<br>").join(text.split("\n"))


def _svg(figure: Figure) -> Markup:
    return Markup(inline_svg(figure.svg, f"{figure.key}-", figure.caption))
