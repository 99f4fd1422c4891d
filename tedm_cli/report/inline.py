"""SVG figures as part of a page: read back, checked against what they were drawn from, and made to live together."""

from __future__ import annotations

import html
import re
from collections.abc import Sequence
from pathlib import Path

from tedm_cli.errors import InputError


def figure_sources(text: str) -> str:
    """What an SVG figure says it was drawn from; empty where it says nothing."""
    found = re.search(r"<dc:source>(.*?)</dc:source>", text, flags=re.DOTALL)
    return html.unescape(found[1]) if found else ""


def read_figure(path: Path, sources: Sequence[str]) -> str:
    """Text of a figure.

    Raises
    ------
    InputError : it is missing, or was drawn from other results than `sources`.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as exc:
        raise InputError("no such figure", where=str(path), hint="draw it with `tedm plot`") from exc
    if figure_sources(text) != "; ".join(sources):
        raise InputError(
            "is stale: not drawn from the results as they are now", where=str(path), hint="redraw it with `tedm plot`"
        )
    return text


def inline_svg(text: str, prefix: str, label: str) -> str:
    """An SVG file as an element of a page: scalable, described by `label`, its ids unlike those of others."""
    body = text[text.index("<svg") :]
    body = re.sub(r"\s*<metadata>.*?</metadata>", "", body, flags=re.DOTALL)
    head, rest = body.split(">", 1)
    head = re.sub(r'\s(width|height)="[^"]*"', "", head)
    width = re.search(r'viewBox="\S+ \S+ (\S+)', head)
    size = f' style="--width: {float(width[1]) / 72:.2f}in"' if width else ""
    body = f'{head} role="img" aria-label="{html.escape(label)}"{size}>{rest}'
    return re.sub(r'(\sid="|url\(#|href="#)', lambda m: m[1] + prefix, body).strip()
