"""A document as PDF, set by Typst: A4, vector figures, bookmarks and tags."""

from __future__ import annotations

import json
import re
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
    Link,
    Listing,
    Paragraph,
    Strong,
    Table,
    Text,
    VerdictCard,
)

_WIDEST_PT, _HIGHEST_PT = 178 / 25.4 * 72, 205 / 25.4 * 72  # what a page leaves to a figure and its caption
_SCALE = 0.8  # of figures made for a screen


def to_pdf(document: Document, font_folder: str) -> bytes:
    """The PDF, with the fonts in a folder alone; the same document gives the same bytes."""
    import typst

    figures: dict[str, str] = {}
    content = {
        "title": document.title,
        "subject": document.subject,
        "version": document.version,
        "notes": [_inline(note) for note in document.notes],
        "sections": [
            {"id": s.id, "title": s.title, "blocks": [_block(b, figures) for b in s.blocks]} for s in document.sections
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
        return kind | {"file": f"{block.key}.svg", "caption": block.caption, "width": _width_pt(block.svg)}
    if isinstance(block, VerdictCard):
        facts = [[name, _inline(value)] for name, value in block.facts]
        return kind | {"state": block.state, "word": block.word, "lead": _inline(block.lead), "rows": facts}
    inner = [_block(b, figures) for b in block.blocks]
    if isinstance(block, Columns):
        return kind | {"blocks": inner}
    assert isinstance(block, Folded)
    return kind | {"summary": block.summary, "blocks": inner}


def _table(table: Table) -> dict[str, Any]:
    return {
        "caption": table.caption,
        "tight": table.tight,
        "columns": [{"title": c.title, "text": c.text} for c in table.columns],
        "rows": [
            {
                "kind": row.kind,
                "cells": [
                    {"text": c.text, "state": c.state or "", "rounding": c.rounding, "long": c.long} for c in row.cells
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
        elif isinstance(piece, Link):
            out.append({"mark": "link", "text": piece.text, "target": piece.target})
        else:
            out.append({"mark": "", "text": piece})
    return out


def _width_pt(svg: str) -> float:
    """Width on paper, no wider than the page and no higher than leaves room for a caption."""
    found = re.search(r'viewBox="\S+ \S+ (\S+) (\S+)"', svg)
    assert found, "figures of matplotlib have a viewBox"
    width, height = float(found[1]), float(found[2])
    return min(_SCALE * width, _WIDEST_PT, _HIGHEST_PT * width / height)
