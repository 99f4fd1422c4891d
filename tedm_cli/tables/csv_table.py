"""Strict reading of small CSV tables: an exact header, numbers that are numbers, and the line of what is wrong.

What a spreadsheet would take for a formula (`=cmd`, `+x`, `@sum`) is written behind an apostrophe, and read without.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from tedm_cli.errors import InputError

_NUMBER = re.compile(r"[+-]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|inf|nan)")
_FORMULA = re.compile("'*[=+\\-@\t\r\n\uff0b\uff0d\uff1d\uff20]")


@dataclass(frozen=True)
class Row:
    """One line of a table: its number in the file, its text and its numbers by column."""

    line: int
    text: dict[str, str]
    number: dict[str, float]


def read_table(path: Path, header: Sequence[str], *, text: Sequence[str] = ()) -> list[Row]:
    """Rows of a CSV file whose first line is `header`; the columns in `text` are words, all others finite numbers.

    Blank lines are skipped.

    Raises
    ------
    InputError : no such file, not a CSV in UTF-8, another header, a line with another number of fields, an empty word,
        a field that is no finite number; names the line and the column.
    """
    lines = csv_lines(path)
    wanted = ",".join(header)
    if not lines or lines[0][1] != list(header):
        found = ",".join(lines[0][1]) if lines else ""
        missing = [c for c in header if not lines or c not in lines[0][1]]
        what = f"misses {', '.join(missing)}" if missing else f"found {found[:80]!r}"
        raise InputError(f"must begin with the header {wanted}; {what}", where=f"{path}:1")
    rows = []
    for number, fields in lines[1:]:
        if not any(fields):
            continue
        if len(fields) != len(header):
            raise InputError(f"{len(fields)} fields, wanted {len(header)} ({wanted})", where=f"{path}:{number}")
        words, numbers = {}, {}
        for column, field in zip(header, fields, strict=True):
            if column in text:
                words[column] = field
                if not field:
                    raise InputError(f"{column} is empty", where=f"{path}:{number}")
            else:
                numbers[column] = finite_number(column, field, f"{path}:{number}")
        rows.append(Row(number, words, numbers))
    if not rows:
        raise InputError("holds a header and nothing else", where=str(path))
    return rows


def csv_lines(path: Path) -> list[tuple[int, list[str]]]:
    """Lines of a CSV file in UTF-8, each with its number in the file and its fields without surrounding blanks.

    Raises
    ------
    InputError : no such file, or not a CSV in UTF-8.
    """
    try:
        with open(path, newline="", encoding="utf-8-sig") as stream:
            reader = csv.reader(stream, strict=True)
            return [(reader.line_num, [plain_cell(field) for field in fields]) for fields in reader]
    except OSError as exc:
        raise InputError(f"cannot be read ({exc.strerror})", where=str(path)) from exc
    except (UnicodeDecodeError, csv.Error) as exc:
        raise InputError(f"not a CSV in UTF-8 ({exc})", where=str(path)) from exc


def finite_number(column: str, field: str, where: str) -> float:
    """The number in a field of the column, or an `InputError` that names both."""
    try:
        # Python reads 1_000 as a number; nobody means it in a table.
        value = math.nan if "_" in field else float(field)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{column} must be a finite number, found {field[:40]!r}", where=where)
    return value


def plain_cell(field: str) -> str:
    """A field without surrounding blanks, and without the apostrophe that `csv_line` puts before a formula."""
    field = field.strip()
    return field[1:] if field.startswith("'") and _FORMULA.match(field) else field


def csv_line(cells: Iterable[object]) -> str:
    """A line of a CSV, with its end. Text that is no number is not left to be taken for a formula."""
    fields = [_cell(str(cell)) for cell in cells]
    return (",".join(fields) if fields != [""] else '""') + "\n"


def _cell(text: str) -> str:
    if _FORMULA.match(text) and not _NUMBER.fullmatch(text):
        text = f"'{text}"
    return '"' + text.replace('"', '""') + '"' if re.search('[",\r\n]', text) else text
