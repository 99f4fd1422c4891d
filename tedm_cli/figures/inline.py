"""SVG figures as part of a page: read back, checked against what they were drawn from, and made to live together."""

from __future__ import annotations

import html
import re
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path

from tedm_cli.errors import InputError

# What draws. Whatever else SVG has runs, links, animates or holds a page.
_DRAWN = {"svg", "g", "defs", "title", "style", "path", "use", "text", "tspan", "rect", "circle", "ellipse", "line"} | {
    *("polyline", "polygon", "image", "clipPath", "mask", "pattern", "marker", "symbol", "linearGradient"),
    *("radialGradient", "stop"),
}


def figure_sources(text: str) -> str:
    """What an SVG figure says it was drawn from; empty where it says nothing."""
    found = re.search(r"<dc:source>(.*?)</dc:source>", text, flags=re.DOTALL)
    return html.unescape(found[1]) if found else ""


def read_figure(path: Path, sources: Sequence[str]) -> str:
    """Text of a figure.

    Raises
    ------
    InputError : it is missing, was drawn from other results than `sources`, or holds what is no drawing.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as exc:
        raise InputError("no such figure", where=str(path), hint="draw it with `tedm plot`") from exc
    except UnicodeDecodeError as exc:
        raise InputError("is no SVG", where=str(path), hint="redraw it with `tedm plot`") from exc
    if figure_sources(text) != "; ".join(sources):
        raise InputError(
            "is stale: not drawn from the results as they are now", where=str(path), hint="redraw it with `tedm plot`"
        )
    foreign = _foreign(text)
    if foreign:
        raise InputError(
            f"holds {foreign}, which no figure of tedm does", where=str(path), hint="redraw it with `tedm plot`"
        )
    return text


def _foreign(text: str) -> str:
    """What in an SVG file would do something in a page besides being seen; empty where nothing would."""
    if "<!--" in text or "<!ENTITY" in text or "<![CDATA[" in text or text.count("<?") > 1:
        return "a comment, an entity or an instruction"  # XML and HTML end them at different places
    try:
        root = ET.fromstring(text)
    except ET.ParseError as exc:
        return f"what is no XML ({exc})"
    for data in root.findall("{http://www.w3.org/2000/svg}metadata"):
        root.remove(data)  # is not part of the page
    for element in root.iter():
        name = element.tag.removeprefix("{http://www.w3.org/2000/svg}")
        if name not in _DRAWN or (name in ("title", "style") and len(element)):
            return f"an element {name}"
        for key, value in element.attrib.items():
            key = key.rpartition("}")[2].lower()
            linked = key in ("href", "src") and not value.startswith(("#", "data:image/png;base64,"))
            if key.startswith("on") or linked or re.search(r"url\((?!#)", value):
                return f"an attribute {key}"
        if name == "style" and re.search(r"url|@", element.text or ""):
            return "a style sheet that loads another"
    return ""


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
