"""Docstrings of this project as Markdown: their sections have a line `name : what it is` for each name."""

from __future__ import annotations

import re
from typing import Any

import griffe

_UNDERLINED = re.compile(r"(?m)^(\w+)\n-{3,}\n")
_ENTRY = re.compile(r"(?m)^([\w*, ]+?) : ")
_SESSION = re.compile(r"(?m)^>>> (?:.+\n?)+")


def markdown(docstring: str) -> str:
    """A docstring whose sections are headed in bold, with names as lists and sessions as code."""
    text, *sections = _UNDERLINED.split(docstring)
    parts = [text.rstrip()]
    for title, body in zip(sections[::2], sections[1::2], strict=True):
        if title in ("Parameters", "Raises"):
            body = _ENTRY.sub(r"* `\1`: ", re.sub(r"(?m)^ +", "  ", body))
        elif title == "Examples":
            body = _SESSION.sub(lambda session: f"~~~ pycon\n{session[0].rstrip()}\n~~~\n", body)
        parts.append(f"**{title}**\n\n{body.rstrip()}")
    return "\n\n".join(parts)


class HouseStyle(griffe.Extension):
    """Rewrites every docstring before it is rendered."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        if obj.docstring is not None:
            obj.docstring.value = markdown(obj.docstring.value)
