"""What pyNastran passes over in bulk data, card by card and field by field: refused as the deck is read, with its line.

The checks of a card look at its text as a whole first, because decks have millions of lines.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from tedm_cli.errors import InputError
from tedm_cli.nastran.card_names import ELEMENT_TEMPERATURES, REFUSED, WITHOUT_INFLUENCE
from tedm_cli.nastran.comments import has_lost_fields
from tedm_cli.nastran.deck_lines import ends_data
from tedm_cli.nastran.loads.element_temperatures import TemperatureCard, temperature_card

_MOST_IDS = 10_000_000  # a range is written out as it is read
_LARGEST_EXPONENT = 300
LARGEST_INTEGER = 2**31 - 1  # Nastran's integers have 32 bits, and so have ids in results
_LONG = re.compile(r"\d{10}")
_SUSPECT = re.compile(r"nan|inf|[-+ed]\d{3}|thru|_", re.I)
_NO_NUMBER = re.compile(r"[+-]?(nan|inf|infinity)", re.I)
_EXPONENT = re.compile(r"[+-]?[\d.]+(?:[eEdD][+-]?|[+-])(\d+)")
_FRAME_FIELDS = 12  # name, CID, RID and three points
_TWO_LINES = ("GRID", "CONM2")  # in large fields: without the second one a place would be another
_FIELDS = slice(8, 72)  # columns of a line in fixed form that hold data
_COLUMNS = 80


class BulkChecks:
    """Checks that a pyNastran model makes while it reads the bulk data of the deck `path`.

    `passed_over` : cards that were not read, by name with their number; `parameters` : file and line of each PARAM, by
    its name; `element_temperatures` : the cards of temperatures of elements; all once the deck has been read.
    """

    def __init__(
        self,
        model: Any,
        path: Path,
        *,
        allow_missing_enddata: bool,
        number: Callable[[int, int], int] | None = None,
    ) -> None:
        """`number` gives the number of a line in its file where pyNastran has read only some of them."""
        self._number = number or (lambda _, line: line)
        self._model, self._path, self._needs_end = model, path, not allow_missing_enddata
        self._cards: list[Any] = []
        self._split, self._create = model.get_bdf_cards, model.create_card_object
        self.passed_over: dict[str, int] = {}
        self.parameters: dict[str, str] = {}
        self.element_temperatures: tuple[TemperatureCard, ...] = ()
        model.get_bdf_cards, model.create_card_object = self._named, self._checked

    def release(self) -> None:
        """End the checks, and hold the lines of the deck no longer; from then on `place_of` knows the deck alone."""
        self._cards = []
        del self._model.get_bdf_cards, self._model.create_card_object

    def place_of(self, card_lines: Any) -> str:
        """File and line of a card, given the very list of its lines; of the deck where it is not known."""
        found = next((card[3] for card in self._cards if card[2] is card_lines), None)
        return str(self._path) if found is None else self._place(found)

    def _place(self, file_and_line: Any) -> str:
        file, line = (int(i) for i in file_and_line)
        line = self._number(file, line)
        included = [Path(str(name)) for name in self._model.active_filenames]  # the main file is the first
        named = included[file] if 0 < file < len(included) else self._path
        return f"{named if named.is_absolute() or named.exists() else self._path.parent / named}:{line + 1}"

    def _named(self, lines: Sequence[str], places: Any = None) -> Any:
        """Split lines into cards, and refuse names that are not read, and a deck that may have been cut off."""
        ends = [i for i, line in enumerate(lines) if ends_data(line)]
        if ends:  # pyNastran knows it in column 1 alone
            lines = [*lines[: ends[0]], lines[ends[0]].lstrip(), *lines[ends[0] + 1 :]]
        out = self._split(lines, places)
        self._cards, counts = out[0], out[2]
        readable = (self._model.cards_to_read - REFUSED.keys()).union(ELEMENT_TEMPERATURES)
        unknown = {name for name in counts if name not in readable and name not in WITHOUT_INFLUENCE}
        for name, _, _, place in self._cards if unknown else ():
            if name in unknown:
                raise _unread(str(name), self._place(place))
        self.passed_over = {name: counts[name] for name in sorted(counts) if name in WITHOUT_INFLUENCE}
        if not ends and self._needs_end:
            raise no_end(self._path)
        self.parameters = {_parameter(card[2]): self._place(card[3]) for card in self._cards if card[0] == "PARAM"}
        self._refuse_lost_fields(lines[: ends[0]] if ends else lines, places)
        left = [i for i in range(ends[0] + 1, len(lines)) if lines[i].split("$")[0].strip()] if ends else []
        for i in left:
            refuse_card_after_end(self._model, lines[i], str(self._path) if places is None else self._place(places[i]))
        if left:
            self.passed_over["lines after ENDDATA"] = len(left)
        if counts.keys().isdisjoint(ELEMENT_TEMPERATURES):
            return out
        ours = [card for card in self._cards if card[0] in ELEMENT_TEMPERATURES]
        self.element_temperatures = tuple(self._temperature_card(card) for card in ours)
        return [card for card in self._cards if card[0] not in ELEMENT_TEMPERATURES], *out[1:]

    def _temperature_card(self, card: Any) -> TemperatureCard:
        name, _, lines, place = card
        return temperature_card(str(name), self._checked(lines, str(name), is_list=False)[0], self._place(place))

    def _refuse_lost_fields(self, lines: Sequence[str], places: Any) -> None:
        for i, line in enumerate(lines):
            if "$" in line and has_lost_fields(lines[i - 1] if i else "", line):
                raise InputError(
                    "has only numbers behind $, as if fields had been commented out",
                    where=str(self._path) if places is None else self._place(places[i]),
                    hint="if it is a comment, add a word; if these are fields, replace $ by a blank",
                )

    def _checked(self, card_lines: Any, card_name: str, is_list: bool = True, has_none: bool = True) -> Any:
        made, fields = self._create(card_lines, card_name, is_list=is_list, has_none=has_none)
        text = "\n".join(map(str, card_lines))
        problem = "" if is_list else _line_problem(card_lines, text)
        if len(card_lines) == 1 and card_name in _TWO_LINES and "*" in text[:8]:
            problem = problem or "lacks the second line of its large fields"
        if made is not card_lines:
            if "." in fields:
                problem = problem or "a point alone is no number"
            if card_name.startswith("CORD2"):
                problem = problem or _frame_problem(fields)
            if _LONG.search(text):
                problem = problem or _integer_problem(fields)
            if _SUSPECT.search(text):
                problem = problem or _number_problem(fields)
        if problem:
            number = str(fields[1]) if made is not card_lines and len(fields) > 1 else ""
            raise InputError(f"{card_name} {number}".strip() + f": {problem}", where=self.place_of(card_lines))
        return made, fields


def _parameter(lines: Sequence[str]) -> str:
    """Name of the parameter that the card with these lines sets."""
    return (*re.split(r"[\s,*]+", str(lines[0]).strip().upper()), "")[1]


def no_end(path: Path) -> InputError:
    """A deck without ENDDATA may have been cut off, by a full disk or a transfer that broke."""
    return InputError(
        "has no ENDDATA: its end may be lost",
        where=str(path),
        hint="end the main deck with ENDDATA, or set model.allow_missing_enddata = true",
    )


def refuse_card_after_end(model: Any, line: str, place: str) -> None:
    """Refuse a card after ENDDATA, where no solver reads it: a slip has left it behind. Other lines may be remarks."""
    name = re.split(r"[\s,*$]", line.upper(), maxsplit=1)[0]
    if (name in model.cards_to_read or name in ELEMENT_TEMPERATURES) and name != "ENDDATA":
        raise InputError(
            f"{name} card after ENDDATA, where no card is read",
            where=place,
            hint="move ENDDATA to the end, or delete what follows it",
        )


def _unread(name: str, place: str) -> InputError:
    if name in REFUSED:
        return InputError(f"{name} card: {REFUSED[name]}", where=place)
    if name != name.strip():
        return InputError(f"{name.strip()} card: its name does not begin in column 1", where=place)
    hint = "is its name misspelt? it may be a part of the structure, of its mass or its loads; remove it if it is none"
    return InputError(f"{name} card: cards of this name are not read", where=place, hint=hint)


def _line_problem(lines: Sequence[str], text: str) -> str:
    """What is wrong with the lines of a card as lines, in whatever form."""
    if "," in text:
        for number, line in enumerate(lines):
            problem = _free_problem(line, number) if "," in line else ""
            if problem:
                return problem
    if "*" in text and any("*" in line[_FIELDS] and "," not in line for line in lines):
        return "has an asterisk among its fields"
    if len(text) > _COLUMNS and any(len(line.expandtabs().rstrip()) > _COLUMNS for line in lines if "," not in line):
        return f"has a line of more than {_COLUMNS} columns, of which Nastran reads {_COLUMNS}"
    return _continuation_problem(lines) if len(lines) > 1 else ""


def _free_problem(line: str, number: int) -> str:
    """What is wrong with a line in free form, of a card whose line `number` it is."""
    fields = line.split(",")
    holds = 6 if "*" in fields[0] else 10
    if any(f.strip() for f in fields[holds:]):
        return f"has {len(fields)} fields in a line, which holds {holds}"
    name = fields[0].strip()
    if re.search(r"\s", name) or (number and name and name[0] not in "+*"):
        return "has a comma in a line of fixed fields"
    return ""


def _continuation_problem(lines: Sequence[str]) -> str:
    """Continuations that belong to another card by their names, or that are in the middle of a large-field line."""
    large = 0
    for before, line in pairwise(lines):
        here, named = _end_name(before), line[:8].split(",")[0].strip()
        if len(here) > 1 and len(named) > 1 and here.lstrip("+*") != named.lstrip("+*"):
            return f"ends its line with {here}, but {named} follows: are its lines in order?"
        large = large + 1 if "*" in before[:8] else 0
        if large % 2 and "*" not in line[:8] and line[8:].strip():
            return "goes on in small fields in the middle of its large ones"
    return ""


def _end_name(line: str) -> str:
    """The tenth field of a line, or what stands in its place."""
    if "," in line:
        fields = line.split(",")
        holds = 6 if "*" in fields[0] else 10
        return fields[holds - 1].strip() if len(fields) >= holds else ""
    return line[72:80].strip() if "\t" not in line else ""


def _frame_problem(fields: Sequence[str | None]) -> str:
    if not any(fields[9:_FRAME_FIELDS]):
        return "lacks its third point (is its continuation lost?)"
    return "has more fields than three points" if any(fields[_FRAME_FIELDS:]) else ""


def _number_problem(fields: Sequence[str | None]) -> str:
    for field in fields:
        text = (field or "").strip()
        exponent = _EXPONENT.fullmatch(text)
        if _NO_NUMBER.fullmatch(text) or (exponent and int(exponent[1]) > _LARGEST_EXPONENT) or _has_underscore(text):
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
        if words[i] == "THRU" and first.isdecimal() and last.isdecimal():
            if int(last) - int(first) > _MOST_IDS:
                return f"{first} THRU {last} names more ids than can be read"
            if int(last) < int(first):  # pyNastran would keep the first number alone
                return f"{first} THRU {last} runs backwards"
    return "THRU lacks its last number" if words and words[-1] == "THRU" else ""


def _has_underscore(text: str) -> bool:
    """Whether it is a number in Python alone, which allows underscores between digits."""
    return "_" in text and re.fullmatch(r"[+-]?[\d._]+([eEdD]?[+-]?[\d_]+)?", text) is not None
