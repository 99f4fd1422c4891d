"""Keep what pyNastran prints out of our output, and turn its complaints into one line."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from typing import Any


@contextmanager
def captured_output() -> Iterator[StringIO]:
    """Collect what pyNastran prints; stdout belongs to our results, stderr to our errors."""
    chatter = StringIO()
    with redirect_stdout(chatter), redirect_stderr(chatter), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield chatter


# What pyNastran says, and the same in words that name no Python.
_PLAIN = tuple(
    (re.compile(pattern), words)
    for pattern, words in (
        (
            r"(\w+) = None \(field #(\d+)\) on card must be (.+?)(?: \(.*\))?\.?",
            r"field \2 (\1) is blank, and must be \3",
        ),
        (r"(\w+) = (.+) \(field #(\d+)\) on card must be (.+?)(?: \(.*\))?\.?", r"field \3 (\1) is \2, and must be \4"),
        (r"This is not a valid msc BDF.*", "has no CEND or no BEGIN BULK line"),
        (r"key=SUBCASE value=(\d+) already exists", r"SUBCASE \1 occurs twice"),
        (r"len\((?:\w+ )?card\) ?= ?(\d+).*", r"has \1 fields, which the card does not have"),
        (r"maximum recursion depth exceeded.*", "its coordinate systems refer to each other in a loop"),
        (r"v=\[.*\] norm\(v\)=0\.0.*", "its three points lie on a line"),
        (r"node_ids = \[(.*)\]", r"its grids are \1, and some of these are none"),
        (r"\w+\.sid=(\d+) old=.*", r"set \1 is there twice"),
        (r"'?(.*?)'? is not an integer; line:.*", r"'\1' is no whole number"),
        (r"card_name='?(.*?)'? was misparsed.*", r"a line begins with \1, which is no card"),
        (r"No spaces allowed in card name '(.*)'.*", r"a line begins with '\1', which is no card"),
        (r"invalid literal for int\(\) with base \d+: '?(.*?)'?", r"'\1' is no whole number"),
        (r"could not convert string to float: '?(.*?)'?", r"'\1' is no number"),
        (r"\w+='?(.*?)'? is not 16 characters long.*", r"\1 has more digits than a field"),
    )
)
# References to what is not there: pattern of its number and of the card that names it, and what it is.
_MISSING = tuple(
    (re.compile(pattern + r".*? required by (\w+) \w+=(\d+).*"), kind)
    for pattern, kind in (
        (r"nid=(\d+) is not a GRID,", "grid"),
        (r"nids=\[([\d ,]+)\] are not a GRID,", "grids"),
        (r"Invalid Material ID: *mid=(\d+)", "material"),
        (r"pid=(\d+) not found,", "property"),
        (r"cid=(\d+) not found,", "coordinate system"),
    )
)
# What says nothing to whoever has the deck alone.
_OF_PYTHON = re.compile(
    r"too many values to unpack|not enough values|index out of range|object (has no|is not)|NoneType"
    r"|unsupported operand|unhashable|referenced before assignment|cannot access local|argument|not supported between"
    r"|^\W*$|card=\["
    r"|^\[|^\w+='?\S*$|Traceback|^\w+$|<class|dict_keys|Python int"
)


def fact_of(exc: Exception, chatter: str) -> str:
    """What is wrong with a deck by pyNastran's report: its first telling line in plain words, and the card or line."""
    lines = [line.strip() for line in str(exc).splitlines() if line.strip(" =-*")]
    telling = [line for line in lines if not line.startswith(("There are cross-reference", "There are duplicate"))]
    found = complaint_of(exc)
    if found is not None:
        return found.fact
    said = _plain_line(telling[0]) if telling else ""
    fact = next((match.expand(words) for form, words in _PLAIN if (match := form.fullmatch(said))), said)[:160]
    printed = re.search(r"problem adding \['(\w+)', '(\w+)'", chatter)
    card = " ".join(printed.groups()) if printed else _card_of(exc)
    line = "" if card else _control_line_of(exc)
    if fact == said and _OF_PYTHON.search(said):
        fact = "is not as Nastran writes it" if card or line else "it is not as Nastran writes decks"
    place = card or line
    return f"{place}: {fact}" if place and not fact.startswith(f"{place} ") else fact


@dataclass(frozen=True)
class Complaint:
    """What is wrong with a card of the deck; `cards` is its name, or those of two cards of the same number."""

    cards: tuple[str, ...]
    number: int
    fact: str


def complaint_of(exc: Exception) -> Complaint | None:
    """A card that refers to what is not there, or whose number another card has; None of any other complaint."""
    lines = [line.strip() for line in str(exc).splitlines() if line.strip(" =-*")]
    if any(re.match(r"old_?\w*=$|self\.\w+ IDs are not unique=", line) for line in lines):
        found = [match for line in lines if (match := re.match(r"([A-Z]\w+)\*? +(\d+)", line))]
        if len(found) > 1:
            (old, number), (new, _) = found[0].groups(), found[1].groups()
            name = old if old == new else f"{old} and {new}"
            return Complaint(
                (old, new), int(number), f"{name} {number}: the number is given twice, with different fields"
            )
    for i, line in enumerate(lines):
        for form, kind in _MISSING:
            match = form.fullmatch(_plain_line(line))
            if match is not None:
                missing, name, number = match.groups()
                # pyNastran gives a material's number for that of some properties; the card itself follows
                card = next((m for after in lines[i:] if (m := re.match(rf"card={name}\*? +(\d+)", after))), None)
                number = card[1] if card is not None else number
                fact = f"{name} {number} names {kind} {missing[:60]}, which the deck does not have"
                return Complaint((name,), int(number), fact)
    return None


def _plain_line(line: str) -> str:
    return re.sub(r"(\\n|\s)+", " ", line).removeprefix("KeyError: ").strip(" '\"")


def _control_line_of(exc: BaseException) -> str:
    """The line of case control that pyNastran was at, in quotes."""
    trace, found = exc.__traceback__, ""
    while trace is not None:
        here = trace.tb_frame
        line = here.f_locals.get("line")
        if isinstance(line, str) and "case" in here.f_code.co_filename and line.strip():
            found = repr(line.strip()[:60])
        trace = trace.tb_next
    return found


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
