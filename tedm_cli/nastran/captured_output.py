"""Keep what pyNastran prints out of our output, and turn its complaints into one line."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from io import StringIO
from typing import Any


@contextmanager
def captured_output() -> Iterator[StringIO]:
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
    printed = re.search(r"problem adding \['(\w+)', '(\w+)'", chatter)
    card = " ".join(printed.groups()) if printed else _card_of(exc)
    return f"{fact} ({type(exc).__name__}{f' at {card}' if card else ''})"


def card_lines_of(exc: BaseException) -> Any:
    """The list of lines of the bulk data card that pyNastran was adding; None where it was adding none."""
    return _added(exc)[1]


def _card_of(exc: BaseException) -> str:
    """Name and number of the bulk data card that pyNastran was adding, which it does not always say."""
    name, lines = _added(exc)
    fields = re.findall(r"[^\s,*]+", str(lines[0])) if lines else []
    return f"{name} {fields[1] if len(fields) > 1 else ''}".strip()


def _added(exc: BaseException) -> tuple[str, Any]:
    trace = exc.__traceback__
    while trace is not None:
        here = trace.tb_frame.f_locals
        if "card_name" in here and here.get("card_lines"):
            return str(here["card_name"]), here["card_lines"]
        trace = trace.tb_next
    return "", None
