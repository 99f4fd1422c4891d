"""A dollar sign among the fields of a card makes the rest of its line a comment.

One flipped bit makes a dollar of a blank, and what was lost is a comment of numbers alone, each still at the edge of a
field. Of fixed fields that can be seen; people's comments have words, or numbers anywhere.
"""

from __future__ import annotations

import re

_NUMBERS = re.compile(r"[\s\d.+\-EeDd]*\d[\s\d.+\-EeDd]*")
_NUMBER = re.compile(r"[+-]?(\d+|\d+\.\d*|\.\d+)([EeDd]?[+-]?\d+)?")


def has_lost_fields(before: str, line: str) -> bool:
    """Whether the comment of a line is what was its fields; `before` is the line above.

    A line that is a comment as a whole goes on a card only where the line above is no comment.
    """
    at = line.index("$")
    comment = line[at + 1 :]
    if not _NUMBERS.fullmatch(comment) or "," in line[:at] or "\t" in line:
        return False
    if not line[:at].strip() and (not before.strip() or before.lstrip().startswith("$")):
        return False
    widths = (16,) if "*" in line[:8] else (8,) if line[:at].strip() else (8, 16)
    return any(_is_of_fields(comment, at + 1, width) for width in widths)


def _is_of_fields(comment: str, start: int, width: int) -> bool:
    """Whether each word of a comment that begins in column `start` is a number at the edge of a field."""
    for word in re.finditer(r"\S+", comment):
        first, end = start + word.start(), start + word.end()
        at_edge = (end - 8) % width == 0 or (first - 8) % width == 0
        if end <= 8 or not at_edge or not _NUMBER.fullmatch(word[0]) or len(word[0]) > width:
            return False
    return True
