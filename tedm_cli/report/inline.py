"""SVG figures as part of a page: read back, checked against what they were drawn from, and made to live together."""

from __future__ import annotations

import html
import re
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

from tedm_cli.errors import InputError

# What draws. Whatever else SVG has runs, links, animates or holds a page.
_DRAWN = {"svg", "g", "defs", "title", "style", "path", "use", "text", "tspan", "rect", "circle", "ellipse", "line"} | {
    *("polyline", "polygon", "image", "clipPath", "mask", "pattern", "marker", "symbol", "linearGradient"),
    *("radialGradient", "stop"),
}
_INSIDE = ("#", "data:image/png;base64,")
_FOREIGN = re.compile(r"url\(\s*[\"']?[^#\"')\s]|@import")


def figure_sources(text: str) -> str:
    """What an SVG figure says it was drawn from; empty where it says nothing."""
    found = re.search(r"<dc:source>(.*?)</dc:source>", text, flags=re.DOTALL)
    return html.unescape(found[1]) if found else ""


def read_figure(path: Path, sources: Sequence[str]) -> str:
    """Text of a figure.

    Raises
    ------
    InputError : it is missing, was drawn from other results than `sources`, is no whole SVG, or asks for what is
        outside of it: a report is complete in itself, whoever has edited its figures.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as exc:
        raise InputError("no such figure", where=str(path), hint="draw it with `tedm plot`") from exc
    except UnicodeDecodeError as exc:
        raise InputError(f"is no SVG figure ({exc})", where=str(path), hint="redraw it with `tedm plot`") from exc
    if figure_sources(text) != "; ".join(sources):
        raise InputError(
            "is stale: not drawn from the results as they are now", where=str(path), hint="redraw it with `tedm plot`"
        )
    if fact := _unfit(text):
        raise InputError(fact, where=str(path), hint="redraw it with `tedm plot`")
    return text


def _unfit(text: str) -> str:
    """Why an SVG cannot be part of a report, in words; empty where it can."""
    if "<!--" in text or "<!ENTITY" in text or "<![CDATA[" in text or text.count("<?") > 1:
        return "holds a comment, an entity or an instruction"  # XML and HTML end them at different places
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as exc:
        return f"is no SVG figure ({exc})"
    box = root.get("viewBox", "").split()
    if _local(root.tag) != "svg" or len(box) != 4 or not all(re.fullmatch(r"-?[0-9.]+", v) for v in box):
        return "is no SVG figure with a viewBox"
    for data in root.findall("{http://www.w3.org/2000/svg}metadata"):
        root.remove(data)  # is not part of the page
    for element in root.iter():
        if element.tag.removeprefix("{http://www.w3.org/2000/svg}") not in _DRAWN:
            return f"holds a {_local(element.tag)}, which no figure of tedm does"
        for name, value in element.attrib.items():
            if _local(name) == "href" and not value.strip().startswith(_INSIDE):
                return f"asks for something outside of it: {value[:80]!r}"
            if _local(name).startswith("on"):
                return f"holds a script ({_local(name)})"
        styled = [*element.attrib.values(), (element.text or "") if _local(element.tag) == "style" else ""]
        if outside := [v for v in styled if _FOREIGN.search(v)]:
            return f"asks for something outside of it: {outside[0].strip()[:80]!r}"
    return ""


def _local(name: object) -> str:
    """A name without its namespace."""
    return str(name).rpartition("}")[2]


def size_of(svg: str) -> tuple[float, float]:
    """Width and height of a figure in points."""
    found = re.search(r'viewBox="\S+ \S+ (\S+) (\S+)"', svg)
    assert found, "figures of matplotlib have a viewBox"
    return float(found[1]), float(found[2])


def inline_svg(text: str, prefix: str, label: str) -> str:
    """An SVG file as an element of a page: scalable, described by `label`, its ids unlike those of others."""
    body = text[text.index("<svg") :]
    body = re.sub(r"\s*<metadata>.*?</metadata>", "", body, flags=re.DOTALL)
    head, rest = body.split(">", 1)
    head = re.sub(r'\s(width|height)="[^"]*"', "", head)
    size = f"--width: {size_of(head)[0] / 72:.2f}in"
    body = f'{head} role="img" aria-label="{html.escape(label)}" style="{size}">{rest}'
    return re.sub(r'(\sid="|url\(#|href="#)', lambda m: m[1] + prefix, body).strip()
