"""Damage to what holds a deck together: names of cards, words of case control, continuations, its end, forms of fields.

None of it is another model: the deck says the same as before, or is no deck.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from random import Random

from fuzz_text import Mutation

STRUCTURE: dict[str, Mutation] = {}

_OTHER_CARDS = {"CORD2R", "CORD2C", "CORD2S", "MAT9", "MAT5", "RBE3"}  # one bit away from cards of the model
_NO_NUMBERS = (".", "1_0.", "1_0", "nan", "1e999", "1..", "1.+-1", ".e1")


def structure(change: Callable[[Random, list[str]], None]) -> Mutation:
    """A mutation of a deck's lines, in place."""

    def mutate(random: Random, data: bytes) -> bytes:
        lines = data.decode("latin-1").split("\n")
        change(random, lines)
        return "\n".join(lines).encode("latin-1")

    STRUCTURE[change.__name__] = mutate
    return mutate


def _begin(lines: list[str]) -> int:
    return next(i for i, line in enumerate(lines) if line.startswith("BEGIN")) + 1


def _cards(lines: list[str]) -> dict[str, list[tuple[int, int]]]:
    """First line and end of every card, by name."""
    starts = [i for i in range(_begin(lines), len(lines)) if re.match("[A-Z]", lines[i])]
    out: dict[str, list[tuple[int, int]]] = {}
    for a, b in zip(starts, [*starts[1:], len(lines)], strict=True):
        out.setdefault(re.match(r"\w+", lines[a])[0], []).append((a, b))  # type: ignore[index]
    return out


def _card(random: Random, lines: list[str]) -> tuple[int, int]:
    """Every name is as likely as another one."""
    return random.choice(random.choice(list(_cards(lines).values())))


def _flipped(random: Random, line: str, at: int) -> str:
    return line[:at] + chr(ord(line[at]) ^ 1 << random.randrange(7)) + line[at + 1 :]


@structure
def flip_bit_of_name(random: Random, lines: list[str]) -> None:
    at = _card(random, lines)[0]
    end = re.match(r"\w+", lines[at]).end()  # type: ignore[union-attr]
    while True:
        new = _flipped(random, lines[at], random.randrange(end))
        if re.split(r"[\s,*]", new, maxsplit=1)[0] not in _OTHER_CARDS:
            lines[at] = new
            return


@structure
def slip_in_name(random: Random, lines: list[str]) -> None:
    at = _card(random, lines)[0]
    name = re.match(r"\w+", lines[at])[0]  # type: ignore[index]
    where, letter = random.randrange(len(name)), random.choice("BDFHJKQUVWXYZ")
    new = random.choice((name[:where] + letter + name[where + 1 :], name[:where] + letter + name[where:]))
    lines[at] = new + lines[at][len(name) :] if "," in lines[at] else f"{new:<8}" + lines[at][8:]


@structure
def flip_bit_of_word(random: Random, lines: list[str]) -> None:
    at = random.randrange(2, _begin(lines) - 1)
    word = re.match(r"\s*([A-Z]+(\([A-Z]+\))?)", lines[at])
    assert word is not None
    lines[at] = _flipped(random, lines[at], random.randrange(word.start(1), word.end(1)))


@structure
def slip_in_word(random: Random, lines: list[str]) -> None:
    at = random.randrange(2, _begin(lines) - 1)
    word = re.match(r"\s*([A-Z]+)", lines[at])
    assert word is not None
    where, letter = random.randrange(word.start(1), word.end(1)), random.choice("BJKQVWXYZ)(")
    lines[at] = lines[at][:where] + letter + lines[at][where + random.choice((0, 1)) :]


@structure
def foreign_word(random: Random, lines: list[str]) -> None:
    words: tuple[str, ...] = (
        "LAOD = 1",
        "DEFORM = 1",
        "NLPARM = 1",
        "STEP 1",
        "BCONTACT = ALL",
        "INITS = 1",
        "BOLTLD = 1",
        "M2GG = M",
    )
    words += ("SPC 1", "PARAM,INREL,-2", "STATSUB = 1", "ANALYSIS = MODES", "TEMPERATURE(INITAL) = 1", "LOADSET = 1")
    lines.insert(random.randrange(2, _begin(lines) - 1), random.choice(words))


@structure
def two_cards_exchanged(random: Random, lines: list[str]) -> None:
    (a, b), (c, d) = sorted((_card(random, lines), _card(random, lines)))
    if a != c and not {"ENDDATA"} & {line.strip() for line in lines[c:d]}:
        lines[a:d] = lines[c:d] + lines[b:c] + lines[a:b]


@structure
def card_twice(random: Random, lines: list[str]) -> None:
    a, b = _card(random, lines)
    lines[b:b] = lines[a:b]


@structure
def end_moved(random: Random, lines: list[str]) -> None:
    end = lines.index("ENDDATA")
    to = _card(random, lines)[0]
    lines.insert(to, lines.pop(end))


@structure
def cut_off(random: Random, lines: list[str]) -> None:
    del lines[random.randrange(2, lines.index("ENDDATA") + 1) :]


@structure
def first_line_lost(random: Random, lines: list[str]) -> None:
    """Of a brick or a frame, whose continuation then belongs to another card."""
    cards = [c for name, found in _cards(lines).items() if name[0] == "C" for c in found if c[1] - c[0] > 1]
    del lines[random.choice(cards)[0]]


@structure
def continuation_lost(random: Random, lines: list[str]) -> None:
    """Of a brick, a frame or a grid in large fields, which are nothing without."""
    cards = [c for name, found in _cards(lines).items() if name[0] in "CG" for c in found if c[1] - c[0] > 1]
    del lines[random.choice(cards)[1] - 1]


@structure
def lines_joined(random: Random, lines: list[str]) -> None:
    end = random.choice([b for name, found in _cards(lines).items() if name != "ENDDATA" for _, b in found])
    lines[end - 1 : end + 1] = [lines[end - 1] + random.choice("\v\b*J") + lines[end]]


@structure
def no_number(random: Random, lines: list[str]) -> None:
    """In place of a number with a point, in whatever form."""
    places = [
        (i, m.start(), m.end())
        for i in range(_begin(lines), len(lines))
        if lines[i][:1] != "$"
        for m in re.finditer(r"-?(?:\d+\.\d*|\.\d+)(?:[-+]\d+)?", lines[i])
        if m.start() >= 4
    ]
    i, a, b = random.choice(places)
    lines[i] = lines[i][:a] + random.choice(_NO_NUMBERS).rjust(b - a)[-max(b - a, 5) :] + lines[i][b:]


@structure
def flip_bit_of_blank(random: Random, lines: list[str]) -> None:
    """Of a blank between fixed fields, to anything but a digit; a dollar sign there makes a comment of the rest."""
    places = [
        (i, j)
        for i in range(_begin(lines), len(lines))
        if lines[i][:1] != "$" and "," not in lines[i]
        for j, c in enumerate(lines[i].rstrip())
        if c == " "
    ]
    i, j = random.choice(places)
    lines[i] = lines[i][:j] + chr(ord(" ") ^ 1 << random.choice((0, 1, 2, 3, 5, 6, 7))) + lines[i][j + 1 :]
