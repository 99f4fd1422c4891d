"""What may be the name of a thermal area, wherever it comes from: areas.csv, a definition, the LABEL of a subcase."""

from __future__ import annotations

import re

LONGEST = 56  # of a LABEL, Nastran keeps as many beside what it appends
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_.+/:()-]*( [A-Za-z0-9_.+/:()-]+)*")


def area_name_fact(name: str) -> str:
    """What is wrong with a name, in words; empty where nothing is.

    No commas, which part the fields of tables, and no signs of name patterns (* ? [ ]).
    """
    if len(name) <= LONGEST and _NAME.fullmatch(name):
        return ""
    return (
        "a name of an area must begin with a letter and hold letters, digits, single blanks and _ . - + / : ( )"
        f" (at most {LONGEST}), found {name[:60]!r}"
    )
