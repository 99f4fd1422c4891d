"""A document as PDF, set by Typst: A4, vector figures, bookmarks and tags."""

from __future__ import annotations

import json
import tempfile
from importlib.resources import files
from pathlib import Path
from typing import Any

from tedm_cli.errors import InputError
from tedm_cli.report.document import (
    Block,
    Columns,
    Document,
    Facts,
    Figure,
    Folded,
    Heading,
    Label,
    Link,
    Listing,
    Paragraph,
    Strong,
    Table,
    Text,
    VerdictCard,
    plain,
)
from tedm_cli.report.inline import size_of
from tedm_cli.report.numbering import anchor, kind_of

_WIDEST_PT, _HIGHEST_PT = 178 / 25.4 * 72, 205 / 25.4 * 72  # what a page leaves to a figure and its caption
_HALF_PT = 318.0  # height of a figure of which two fit on a page
_SCALE, _LEAST = 0.8, 0.775  # of figures made for a screen; and where two are to fit on a page: type of 6.8 points


def to_pdf(document: Document, font_folder: str) -> bytes:
    """The PDF, with the fonts in a folder alone; the same document gives the same bytes."""
    import typst

    figures: dict[str, str] = {}
    content = {
        "title": document.title,
        "subject": document.subject,
        "front": [list(pair) for pair in document.front],
        "notes": [_inline(note) for note in document.notes],
        "sections": [
            {"id": s.id, "title": s.title, "new_page": s.new_page, "blocks": [_block(b, figures) for b in s.blocks]}
            for s in document.sections
        ],
    }
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "document.json").write_text(json.dumps(content), encoding="utf-8")
        template = files("tedm_cli.report").joinpath("templates/report.typ").read_text(encoding="utf-8")
        (folder / "report.typ").write_text(template, encoding="utf-8")
        for file, svg in figures.items():
            (folder / file).write_text(svg, encoding="utf-8")
        try:
            pdf: bytes = typst.compile(
                str(folder / "report.typ"), format="pdf", font_paths=[font_folder], ignore_system_fonts=True
            )
        except typst.TypstError as exc:
            fact = " ".join(str(exc).replace(f"{folder}/", "").split())
            raise InputError(
                f"the PDF cannot be set: {fact[:300]}", where="report.pdf", hint="redraw the figures with `tedm plot`"
            ) from exc
    return pdf


def _block(block: Block, figures: dict[str, str]) -> dict[str, Any]:
    """A block as plain data; SVG texts are put into `figures` under the names of their files."""
    kind: dict[str, Any] = {"kind": type(block).__name__}
    if isinstance(block, Paragraph):
        return kind | {"text": _inline(block.text), "quiet": block.quiet}
    if isinstance(block, Heading | Listing):
        return kind | {"text": block.text}
    if isinstance(block, Facts):
        return kind | {"rows": [[name, _inline(value)] for name, value in block.rows]}
    if isinstance(block, Table):
        return kind | _table(block)
    if isinstance(block, Figure):
        figures[f"{block.key}.svg"] = block.svg
        return kind | _caption(block) | {"file": f"{block.key}.svg", "width": _width_pt(block.svg)}
    if isinstance(block, VerdictCard):
        facts = [[name, _inline(value)] for name, value in block.facts]
        return kind | {"state": block.state, "word": block.word, "lead": _inline(block.lead), "rows": facts}
    inner = [_block(b, figures) for b in block.blocks]
    if isinstance(block, Columns):
        return kind | _caption(block) | {"blocks": inner}
    assert isinstance(block, Folded)
    return kind | {"summary": block.summary, "blocks": inner}


def _caption(block: Figure | Table | Columns) -> dict[str, str]:
    named = {"called": f"{kind_of(block)} {block.number}", "anchor": anchor(block)} if block.number else {}
    return {"caption": block.caption, "called": "", "anchor": "", **named}


def _table(table: Table) -> dict[str, Any]:
    return _caption(table) | {
        "heading_column": table.heading_column,
        "tight": table.tight,
        "columns": [{"title": c.title, "text": c.text} for c in table.columns],
        "rows": [
            {
                "kind": row.kind,
                "cells": [
                    {"text": c.text, "state": c.state or "", "rounding": c.rounding, "long": c.long, "label": c.label}
                    for c in row.cells
                ],
            }
            for row in table.rows
        ],
    }


def _inline(text: Text) -> list[dict[str, str]]:
    pieces = (text,) if isinstance(text, str) else text
    out = []
    for piece in pieces:
        if isinstance(piece, Strong):
            out.append({"mark": "strong", "text": piece.text})
        elif isinstance(piece, Link) and not piece.away:  # a PDF is passed on alone: it leads to no other file
            out.append({"mark": "link", "text": piece.text, "target": piece.target})
        else:
            out.append({"mark": "label" if isinstance(piece, Label) else "", "text": plain((piece,))})
    return out


def _width_pt(svg: str) -> float:
    """Width on paper: no wider than the page; of half its height or less, where that leaves the figure legible."""
    width, height = size_of(svg)
    scale = min(_SCALE, _WIDEST_PT / width, _HIGHEST_PT / height)
    if _LEAST * height <= _HALF_PT < scale * height:
        scale = _HALF_PT / height
    return scale * width
