"""What pyNastran passes over within a card: made to be refused as the card is read."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tedm_cli.errors import InputError

_MOST_IDS = 10_000_000  # a range is written out as it is read
_LARGEST_EXPONENT = 300
LARGEST_INTEGER = 2**31 - 1  # Nastran's integers have 32 bits, and so have ids in results
_LONG = re.compile(r"\d{10}")
_SUSPECT = re.compile(r"nan|inf|[+-]\d{3}|thru", re.I)
_NO_NUMBER = re.compile(r"[+-]?(nan|inf|infinity)", re.I)
_EXPONENT = re.compile(r"[+-]?[\d.]+[eEdD]?([+-]?\d+)")
_FRAME_FIELDS = 12  # name, CID, RID and three points


def refuse_lost_fields(model: Any, path: Path) -> None:
    """Have a pyNastran model, before it reads a deck, refuse what it would pass over.

    These are fields behind the tenth of a line in free form; a CORD2R, CORD2C or CORD2S without its continuation, whose
    third point would be the origin, or with another's; NaN, infinity, what overflows and integers of more than
    32 bits; ranges (THRU) of more ids than
    there can be. The model then raises `InputError`.
    """
    create = model.create_card_object

    def checked(card_lines: Any, card_name: str, is_list: bool = True, has_none: bool = True) -> Any:
        made, fields = create(card_lines, card_name, is_list=is_list, has_none=has_none)
        problem = "" if is_list else _line_problem(card_lines)
        if made is not card_lines:
            problem = problem or _frame_problem(fields)
            if _LONG.search(" ".join(str(line) for line in card_lines)):
                problem = problem or _integer_problem(fields)
            if _SUSPECT.search(" ".join(str(line) for line in card_lines)):
                problem = problem or _number_problem(fields)
        if problem:
            number = str(fields[1]) if made is not card_lines and len(fields) > 1 else ""
            raise InputError(f"{card_name} {number}".strip() + f": {problem}", where=str(path))
        return made, fields

    model.create_card_object = checked


def _line_problem(lines: Sequence[str]) -> str:
    for line in lines:
        if "," in line:
            fields = line.split(",")
            holds = 6 if "*" in fields[0] else 10
            if any(f.strip() for f in fields[holds:]):
                return f"has {len(fields)} fields in a line, which holds {holds}"
    return ""


def _frame_problem(fields: Sequence[str | None]) -> str:
    if fields[0] not in ("CORD2R", "CORD2C", "CORD2S"):
        return ""
    if not any(fields[9:_FRAME_FIELDS]):
        return "lacks its third point (is its continuation lost?)"
    return "has more fields than three points" if any(fields[_FRAME_FIELDS:]) else ""


def _number_problem(fields: Sequence[str | None]) -> str:
    for field in fields:
        text = (field or "").strip()
        exponent = _EXPONENT.fullmatch(text)
        if _NO_NUMBER.fullmatch(text) or (exponent and "." in text and int(exponent[1]) > _LARGEST_EXPONENT):
            return f"{text} is no number"
    return range_problem([(field or "").strip().upper() for field in fields])


def _integer_problem(fields: Sequence[str | None]) -> str:
    for field in fields:
        text = (field or "").strip()
        if text.lstrip("+-").isdecimal() and abs(int(text)) > LARGEST_INTEGER:
            return f"{text} is larger than any id"
    return ""


def range_problem(words: Sequence[str]) -> str:
    """What is wrong with the ranges (THRU) among the words of a list of ids."""
    for i in range(1, len(words) - 1):
        first, last = words[i - 1], words[i + 1]
        if words[i] == "THRU" and first.isdecimal() and last.isdecimal() and int(last) - int(first) > _MOST_IDS:
            return f"{first} THRU {last} names more ids than can be read"
    return ""
