"""Characters that stand for no letter: files, pages and terminals break on them; no name, title or path has them."""

from __future__ import annotations


def control_fact(text: str, allowed: str = "") -> str:
    """That `text` holds a control character besides those `allowed`, in words; empty where it holds none.

    Control characters are those of Unicode, what it keeps free of characters (neither may stand in XML), and those that
    break lines or turn the direction of what follows.
    """
    for c in text:
        code = ord(c)
        if c in allowed:
            continue
        is_free = code & 0xFFFE == 0xFFFE or 0xFDD0 <= code <= 0xFDEF
        is_turn = 0x2028 <= code <= 0x202E or 0x2066 <= code <= 0x2069
        if code < 0x20 or 0x7F <= code < 0xA0 or is_free or is_turn:
            return f"holds the control character U+{code:04X}"
    return ""
