"""What goes wrong with decks: damage by machines, and the slips of people who edit them."""

from __future__ import annotations

import re
from collections.abc import Callable
from random import Random

Mutation = Callable[[Random, bytes], bytes]
TEXT: dict[str, Mutation] = {}

_NUMBERS = ("0", "-1", "1", "2147483648", "99999999999999999999", "1.", "-1.", "1.+38", "1.+400", "4.9-324", "1.d0")
_WORDS = (
    "NaN",
    "nan",
    "Inf",
    "-inf",
    "1.2.3",
    "1e",
    "abc",
    "THRU",
    "ALL",
    "*",
    "+",
    "=",
    "'",
    '"',
    "$",
    "\t",
    "(",
    "1,2",
)
_NAMES = ("GRID", "TEMP", "TEMPD", "CHEXA", "RBE2", "CORD2R", "SPC1", "MAT1", "CONM2", "XGRID", "CXYZ", "ENDDATA")
_CONTROL = (
    "LABEL = ROOT",
    "LABEL = UNIFORM",
    "LABEL",
    "SUBCASE 1",
    "SUBCASE 2",
    "SUBCASE 0",
    "SUBCASE -3",
    "SUBCASE x",
    "SUBCASE 99999999999",
    "TEMPERATURE(LOAD) = 2",
    "TEMPERATURE = 1",
    "TEMPERATURE(INITIAL) = 3",
    "TEMPERATURE(LOAD) = x",
    "SPC = 99",
    "SUBCOM 9",
    "SUBSEQ = 1.,1.",
    "DISPLACEMENT = 5",
    "SET 5 = 1 THRU 4",
    "SET 5 = 1 THRU",
    "LOAD = 1",
    "ANALYSIS = HEAT",
    "BEGIN BULK",
    "CEND",
    "SOL 103",
    "OUTPUT(XYPLOT)",
    "ECHO = SORT(",
    "$ = ",
)


def text(change: Callable[[Random, list[str]], list[str] | None]) -> Mutation:
    """A mutation of a deck's lines; None leaves the lines it was given, changed in place."""

    def mutate(random: Random, data: bytes) -> bytes:
        lines = data.decode("latin-1").split("\n")
        return "\n".join(change(random, lines) or lines).encode("latin-1")

    TEXT[change.__name__] = mutate
    return mutate


def raw(change: Mutation) -> Mutation:
    TEXT[change.__name__] = change
    return change


def _line(random: Random, lines: list[str]) -> int:
    return random.randrange(len(lines) - 1)


def _data_line(random: Random, lines: list[str], pattern: str = r"[A-Z*, ]") -> int:
    """A line that is no comment."""
    return random.choice([i for i, s in enumerate(lines) if re.match(pattern, s) and s.strip()])


def _fields(line: str) -> tuple[list[str], Callable[[list[str]], str]]:
    """The fields of a bulk data line, and what joins them again."""
    if "," in line:
        return line.split(","), ",".join
    width = 16 if "*" in line[:8] else 8
    out = [line[:8]] + [line[i : i + width] for i in range(8, max(len(line), 9), width)]
    return out, lambda f: "".join([f[0][:8].ljust(8), *(x.rjust(width) for x in f[1:])])


def _cards(lines: list[str]) -> list[tuple[int, int]]:
    """First line and end of every bulk data card."""
    begin = next((i for i, s in enumerate(lines) if s.startswith("BEGIN")), 0) + 1
    starts = [i for i in range(begin, len(lines)) if re.match(r"[A-Z]", lines[i])]
    return [(a, b) for a, b in zip(starts, [*starts[1:], len(lines) - 1], strict=True)]


# --- damage ----------------------------------------------------------------------------------------------------------


@raw
def cut(random: Random, data: bytes) -> bytes:
    return data[: random.randrange(len(data))]


@raw
def cut_front(random: Random, data: bytes) -> bytes:
    return data[random.randrange(len(data)) :]


@raw
def flip_bit(random: Random, data: bytes) -> bytes:
    out = bytearray(data)
    for _ in range(random.choice((1, 1, 1, 4))):
        out[random.randrange(len(out))] ^= 1 << random.randrange(8)
    return bytes(out)


@raw
def set_byte(random: Random, data: bytes) -> bytes:
    out = bytearray(data)
    out[random.randrange(len(out))] = random.choice((0, 9, 10, 13, 26, 32, 36, 39, 44, 45, 46, 127, 255))
    return bytes(out)


@raw
def drop_bytes(random: Random, data: bytes) -> bytes:
    at = random.randrange(len(data))
    return data[:at] + data[at + random.choice((1, 1, 2, 8, 16, 80)) :]


@raw
def insert_garbage(random: Random, data: bytes) -> bytes:
    at = random.randrange(len(data))
    return (
        data[:at] + random.choice((random.randbytes(8), b"\n", b"7", b" ", b"-", b"\0" * 20, b"\xff\xfe")) + data[at:]
    )


@raw
def other_encoding(random: Random, data: bytes) -> bytes:
    text = data.decode("latin-1")
    return random.choice(
        (
            text.encode("utf-16"),
            text.encode("utf-8-sig"),
            text.replace("\n", "\r\n").encode(),
            text.replace("\n", "\r").encode(),
            text.lower().encode(),
            text.replace("\n", "\n\n").encode(),
            text.replace(",", "\t").encode(),
        )
    )


# --- lines and cards -------------------------------------------------------------------------------------------------


@text
def drop_line(random: Random, lines: list[str]) -> None:
    del lines[_line(random, lines)]


@text
def repeat_line(random: Random, lines: list[str]) -> None:
    at = _line(random, lines)
    lines.insert(at, lines[at])


@text
def swap_lines(random: Random, lines: list[str]) -> None:
    a, b = _line(random, lines), _line(random, lines)
    lines[a], lines[b] = lines[b], lines[a]


@text
def move_line(random: Random, lines: list[str]) -> None:
    line = lines.pop(_line(random, lines))
    lines.insert(_line(random, lines), line)


@text
def join_lines(random: Random, lines: list[str]) -> None:
    at = _line(random, lines)
    lines[at] += lines.pop(at + 1)


@text
def split_line(random: Random, lines: list[str]) -> None:
    at = _data_line(random, lines)
    cut = random.randrange(1, len(lines[at]) + 1)
    lines[at : at + 1] = [lines[at][:cut], lines[at][cut:]]


@text
def comment_out(random: Random, lines: list[str]) -> None:
    at = _line(random, lines)
    column = random.choice((0, random.randrange(len(lines[at]) + 1)))
    lines[at] = lines[at][:column] + "$" + lines[at][column:]


@text
def drop_card(random: Random, lines: list[str]) -> None:
    a, b = random.choice(_cards(lines))
    del lines[a:b]


@text
def repeat_card(random: Random, lines: list[str]) -> None:
    a, b = random.choice(_cards(lines))
    at = random.choice(_cards(lines))[0]
    lines[at:at] = lines[a:b]


@text
def repeat_card_changed(random: Random, lines: list[str]) -> None:
    a, b = random.choice(_cards(lines))
    copy = lines[a:b]
    row = random.randrange(len(copy))
    fields, join = _fields(copy[row])
    fields[random.randrange(1, len(fields))] = random.choice(_NUMBERS)
    copy[row] = join(fields)
    lines[b:b] = copy


@text
def rename_card(random: Random, lines: list[str]) -> None:
    at = random.choice(_cards(lines))[0]
    fields, join = _fields(lines[at])
    fields[0] = random.choice((*_NAMES, fields[0].strip() + "*", fields[0].strip()[:-1], "X" + fields[0].strip()[:6]))
    lines[at] = join(fields)


@text
def foreign_line(random: Random, lines: list[str]) -> None:
    lines.insert(
        _line(random, lines),
        random.choice(
            (
                "INCLUDE 'unit_loads.bdf'",
                "INCLUDE 'model.bdf'",
                "INCLUDE 'loop.inc'",
                "INCLUDE 'missing.inc'",
                "INCLUDE '.'",
                "INCLUDE",
                "INCLUDE '" + "x" * 5000,
                "INCLUDE '" + "x" * 5000 + "'",
                "INCLUDE '/'",
                "SPC1,1,123,1,THRU,99999999",
                "READ 'model.bdf'",
                "/ 3,5",
                "PARAM,WTMASS,.5",
                "PARAM,WTMASS,abc",
                "PARAM,POST",
                "ENDDATA",
                "+",
                "*",
                ",",
                "        ",
                "GRID,1",
                "SPOINT,1",
                "SPOINT,500,THRU,100000000",
                "TEMP,1,1,1.,2",
                "TEMPD,1,0.,2",
                "TEMPD,1,5.",
                "TEMP,4,THRU,9,1.",
                "TEMPP1,1,1,1.,5.\n,2,THRU,9",
                "TEMPRB,1,278,1.,1.,0.,0.,1.,1.\n,\n,279,THRU,281",
                "TEMPRB,1,278,0.,0.",
                "CORD2R,20,30,0.,0.,0.,0.,0.,1.\n,1.,0.,0.",
                "CORD1R,40,1,2,3",
                "CBAR,77,1,1,2,0.,0.,1.",
                "RBE2,77,1,123456,THRU,9",
                "RBE2,51,900001,123,6",
                "RBE3,78,,900001,123,1.,123,1,2",
                "CONM2,61,900002,,9.",
                "GRDSET,,,,,,20",
                "MAT1,1,7.+10,,.33,2700.,2.3-5",
                "x" * 100000,
            )
        ),
    )


@text
def control_line(random: Random, lines: list[str]) -> None:
    lines.insert(random.randrange(2, 21), random.choice(_CONTROL))


@text
def replace_control_line(random: Random, lines: list[str]) -> None:
    lines[random.randrange(2, 20)] = random.choice(_CONTROL)


@text
def doubled_subcase(random: Random, lines: list[str]) -> None:
    at = [i for i, s in enumerate(lines) if s.startswith("SUBCASE")]
    a, b = random.choice(at), random.choice((*at, at[-1] + 4))
    number = random.choice((lines[a], "SUBCASE 7"))
    lines[b:b] = [number, *lines[a + 1 : a + 4]]


@text
def swapped_labels(random: Random, lines: list[str]) -> None:
    a, b = random.sample([i for i, s in enumerate(lines) if "LABEL" in s], 2)
    lines[a], lines[b] = lines[b], lines[a]


# --- fields ----------------------------------------------------------------------------------------------------------


def _change_field(random: Random, lines: list[str], new: Callable[[str], str]) -> None:
    at = random.choice([i for a, b in _cards(lines) for i in range(a, b) if lines[i].strip() and lines[i][0] != "$"])
    fields, join = _fields(lines[at])
    number = random.randrange(1, len(fields)) if len(fields) > 1 else 0
    fields[number] = new(fields[number])
    lines[at] = join(fields)


@text
def digit(random: Random, lines: list[str]) -> None:
    places = [(i, j) for i, s in enumerate(lines) if s[:1] != "$" for j, c in enumerate(s) if c.isdigit()]
    i, j = random.choice(places)
    lines[i] = lines[i][:j] + random.choice("0123456789") + lines[i][j + 1 :]


@text
def blank_field(random: Random, lines: list[str]) -> None:
    _change_field(random, lines, lambda _: "")


@text
def number_field(random: Random, lines: list[str]) -> None:
    _change_field(random, lines, lambda _: random.choice(_NUMBERS))


@text
def word_field(random: Random, lines: list[str]) -> None:
    _change_field(random, lines, lambda _: random.choice(_WORDS))


@text
def float_for_integer(random: Random, lines: list[str]) -> None:
    _change_field(random, lines, lambda f: f.strip() + ".0" if "." not in f else f.replace(".", ""))


@text
def sign_or_exponent(random: Random, lines: list[str]) -> None:
    _change_field(
        random, lines, lambda f: random.choice(("-" + f.strip(), f.strip() + "+9", f.strip() + "-9", f.strip() + "e5"))
    )


@text
def shift_fields(random: Random, lines: list[str]) -> None:
    at = random.choice(_cards(lines))[0]
    fields, join = _fields(lines[at])
    number = random.randrange(1, len(fields) + 1)
    if random.random() < 0.5:
        fields.insert(number, random.choice(("", "1", "1.")))
    else:
        del fields[min(number, len(fields) - 1)]
    lines[at] = join(fields)


@text
def swap_fields(random: Random, lines: list[str]) -> None:
    at = random.choice(_cards(lines))[0]
    fields, join = _fields(lines[at])
    a, b = random.randrange(1, len(fields) + 1) - 1, random.randrange(1, len(fields) + 1) - 1
    fields[a], fields[b] = fields[b], fields[a]
    lines[at] = join(fields)
