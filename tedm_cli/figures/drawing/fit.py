"""Fit texts from the user's files into the width there is for them: broken into lines, never cut."""

from __future__ import annotations

import re

from tedm_cli.figures.drawing.labels import text_size


def text_width(text: str, size_pt: float) -> float:
    """Width of a line of text in inches."""
    return float(text_size(text, size_pt)[0]) / 72.0 if text.strip() else 0.0


def widest(texts: list[str], size_pt: float) -> float:
    """Width of the widest line of some texts, which may have several lines each, in inches."""
    return max((text_width(line, size_pt) for text in texts for line in text.split("\n")), default=0.0)


def line_count(text: str) -> int:
    """Lines of a text."""
    return text.count("\n") + 1


def wrapped(text: str, inches: float, size_pt: float) -> str:
    """The text in lines of at most so many inches: broken at spaces, else after signs within a word, else anywhere."""
    lines = [""]
    for word in re.split(r"[ \n\t]+", text.strip()):  # what a no-break space joins stays together
        joined = f"{lines[-1]} {word}" if lines[-1] else word
        if text_width(joined, size_pt) <= inches:
            lines[-1] = joined
            continue
        if lines[-1]:
            lines.append("")
        for piece in _pieces(word, inches, size_pt):
            if lines[-1] and text_width(lines[-1] + piece, size_pt) > inches:
                lines.append("")
            lines[-1] += piece
    return "\n".join(lines)


def _pieces(word: str, inches: float, size_pt: float) -> list[str]:
    """A word in parts that fit: whole, by the signs inside of it, or by characters."""
    if text_width(word, size_pt) <= inches:
        return [word]
    pieces = []
    for part in re.findall(r"[^_\-./:]*[_\-./:]|[^_\-./:]+", word):
        pieces += [part] if text_width(part, size_pt) <= inches else list(part)
    return pieces
