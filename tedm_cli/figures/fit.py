"""Fit texts from the user's files into the space there is for them."""

from __future__ import annotations

from tedm_cli.figures.labels import text_size
from tedm_cli.results.wording import shortened


def text_width(text: str, size_pt: float) -> float:
    """Width of a line of text in inches."""
    return float(text_size(text, size_pt)[0]) / 72.0 if text.strip() else 0.0


def fitted(text: str, inches: float, size_pt: float) -> str:
    """The text, or as much of its two ends as fits."""
    most = len(text)
    while most > 3 and text_width(shortened(text, most), size_pt) > inches:
        most -= 1
    return shortened(text, most)


def wrapped(text: str, inches: float, size_pt: float, lines: int) -> str:
    """The text in at most so many lines; what does not fit makes way for an ellipsis."""
    done: list[str] = []
    words = text.split()
    while words:
        if len(done) == lines - 1:
            rest = " ".join(words)
            done.append(rest if text_width(rest, size_pt) <= inches else _cut(rest, inches, size_pt))
            break
        line = fitted(words.pop(0), inches, size_pt)
        while words and text_width(f"{line} {words[0]}", size_pt) <= inches:
            line = f"{line} {words.pop(0)}"
        done.append(line)
    return "\n".join(done)


def _cut(text: str, inches: float, size_pt: float) -> str:
    while len(text) > 1 and text_width(f"{text}…", size_pt) > inches:
        text = text[:-1].rstrip()
    return f"{text}…"
