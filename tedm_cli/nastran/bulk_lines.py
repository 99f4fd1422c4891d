"""Bulk data lines of a user's model, kept as they are, except for what would spoil a unit-load run."""

from __future__ import annotations

import re
from collections.abc import Sequence

from tedm_cli.errors import InputError
from tedm_cli.nastran.card_names import SUPERELEMENTS
from tedm_cli.nastran.deck_lines import Line
from tedm_cli.nastran.parameters import check_parameter

_NO_POINT = r"[+-]?\d+(?:[eEdD][+-]?|[+-])\d+"
_PERHAPS_NO_POINT = re.compile(r"(?<![\d.])\d+(?:[eEdD][+-]?|[+-])\d")
_MOST_NAMED = 3


def kept_bulk(lines: Sequence[Line]) -> tuple[list[str], list[str]]:
    """Texts of the bulk lines, with PARAM,POST,-1 once, and what was changed.

    Another PARAM,POST (and a repeated one) becomes a comment; every other line stays to the byte.

    Raises
    ------
    InputError : superelement cards, parameters that alter a unit load.
    """
    texts = [line.text for line in lines]
    if texts and not texts[-1].endswith(("\n", "\r")):
        texts[-1] += "\n"
    notes, has_post = [], False
    for i, line in enumerate(lines):
        if not line.text[:1].isalpha():
            continue
        name = re.split(r"[\s,*$]", line.text[:8], maxsplit=1)[0].upper()
        if name in SUPERELEMENTS:
            raise InputError(
                f"{name} card: superelements are not read", where=line.place, hint="write the model in one piece"
            )
        if name != "PARAM":
            continue
        card = _card(lines, i)
        parameter, value = (*_fields(line.code), "", "", "")[1:3]
        parameter = parameter.upper()
        check_parameter(parameter, value, line.place)
        if parameter == "POST":
            if value == "-1" and not has_post:
                has_post = True
                continue
            if value != "-1":
                notes.append(f"PARAM,POST,{value} is now PARAM,POST,-1, so that an OP2 is written")
            for k in card:
                texts[k] = "$ " + texts[k]
    if not has_post:
        texts.append("PARAM,POST,-1\n")
    return texts, notes + _reals_without_point(lines)


def _reals_without_point(lines: Sequence[Line]) -> list[str]:
    """A note of numbers such as 2e-08, which pyNastran takes for reals, and strict readers refuse."""
    found = []
    for line in lines:
        if _PERHAPS_NO_POINT.search(line.text):
            fields = _fields(line.code)[1:9]  # without names of the card and of continuations
            found += [f"{field} ({line.place})" for field in fields if re.fullmatch(_NO_POINT, field)]
    if not found:
        return []
    more = f", and {len(found) - _MOST_NAMED} more" if len(found) > _MOST_NAMED else ""
    named = ", ".join(found[:_MOST_NAMED]) + more
    return [f"reals without a decimal point, which some Nastrans refuse: {named}; write 2.e-08 for 2e-08"]


def _card(lines: Sequence[Line], first: int) -> list[int]:
    """Numbers of the lines of the card that begins in line `first`."""
    out = [first]
    for k in range(first + 1, len(lines)):
        text = lines[k].text
        if text.startswith("$") or not text.strip():
            continue
        if not text.startswith(("+", "*", ",", " ", "\t")):
            break
        out.append(k)
    return out


def _fields(code: str) -> list[str]:
    """Fields of the first line of a card in small, large or free form, with commas or tabs."""
    if "," in code:
        fields = code.split(",")
    else:
        text = code.expandtabs(8)
        width = 16 if "*" in text[:8] else 8
        fields = [text[:8], *(text[k : k + width] for k in range(8, 72, width))]
    return [f.strip().rstrip("*").strip() for f in fields]
