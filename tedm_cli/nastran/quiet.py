"""Keep pyNastran's words off our output, and make one line of its complaints."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from io import StringIO


@contextmanager
def quiet() -> Iterator[StringIO]:
    """Collect what pyNastran prints; stdout belongs to our results, stderr to our errors."""
    chatter = StringIO()
    with redirect_stdout(chatter), redirect_stderr(chatter), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield chatter


def fact_of(exc: Exception, chatter: str) -> str:
    """What is worth showing of pyNastran's report: its first telling line, and the card it was at."""
    lines = [line.strip() for line in str(exc).splitlines() if line.strip(" =-*")]
    telling = [line for line in lines if not line.startswith("There are cross-reference errors")]
    fact = (
        re.sub(r"(\\n|\s)+", " ", telling[0]).removeprefix("KeyError: ").strip(" '")[:160]
        if telling
        else "no reason given"
    )
    card = re.search(r"problem adding \['(\w+)', '(\w+)'", chatter)
    return f"{fact} ({type(exc).__name__}{f' at {card[1]} {card[2]}' if card else ''})"
