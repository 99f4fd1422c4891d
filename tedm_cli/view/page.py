"""The page: its parts in the package, put together around the payload, with nothing that it would have to fetch."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
from collections.abc import Mapping
from importlib.resources import files
from typing import Any

#: The page's own program, in the order in which its parts need each other.
SCRIPTS = (
    "arithmetic.js",
    "format.js",
    "unpack.js",
    "colours.js",
    "camera.js",
    "shaders.js",
    "scene.js",
    "chart.js",
    "temperatures.js",
    "readings.js",
    "picture.js",
    "play.js",
    "app.js",
    "main.js",
)
_STYLE, _FRAME = "page.css", "page.html"


def page_part(name: str) -> str:
    """One file of the page as the package holds it."""
    return (files("tedm_cli.view") / "page" / name).read_text(encoding="utf-8")


def page(title: str, content: Mapping[str, Any]) -> str:
    """The page as HTML. Its policy lets it run its own program and nothing else, and reach nothing.

    `title` and `content` are anybody's text; in the page they are text.
    """
    program = "\n".join(page_part(name) for name in SCRIPTS)
    style = page_part(_STYLE)
    policy = (
        f"default-src 'none'; script-src {_digest(program)}; style-src {_digest(style)};"
        " base-uri 'none'; form-action 'none'"
    )
    parts = {
        "policy": html.escape(policy, quote=True).replace("&#x27;", "'"),
        "title": html.escape(title),
        "style": style,
        "content": inert_json(content),
        "program": program,
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda m: parts[m[1]], page_part(_FRAME))


def inert_json(content: Mapping[str, Any]) -> str:
    """JSON that no parser of HTML takes for markup, and no parser of JavaScript for the end of a line."""
    text = json.dumps(content, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    for sign in "<>&\u2028\u2029":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return text


def _digest(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
