"""Strict reading of small CSV tables: an exact header, numbers that are numbers, and the line of what is wrong.

What a spreadsheet would take for a formula (`=cmd`, `+x`, `@sum`) is written behind an apostrophe, and read without.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from tedm_cli.control_characters import control_fact
from tedm_cli.errors import InputError
from tedm_cli.quantities import Quantity
from tedm_cli.regular_file import require_regular_file

_MOST_BYTES = 256_000_000  # of a table that is held as a whole
_LAYOUT = "\t\n"  # of the control characters these alone may stand in a cell, between quotes

_NUMBER = re.compile(r"[+-]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|inf|nan)")
_FORMULA = re.compile("'*[=+\\-@\t\r\n\uff0b\uff0d\uff1d\uff20]")


@dataclass(frozen=True)
class Row:
    """One line of a table: its number in the file, its text and its numbers by column."""

    line: int
    text: dict[str, str]
    number: dict[str, float]


def read_table(path: Path, columns: Mapping[str, Quantity | None], optional: Sequence[str] = ()) -> list[Row]:
    """Rows of a CSV file whose first line names these columns, in their order.

    A column holds numbers of its quantity, or words where it has none. Columns of words that are `optional` may follow,
    and may be empty in any line. Blank lines are skipped. A file whose header is divided by semicolons has them
    throughout, and its numbers may have a decimal comma.

    Raises
    ------
    InputError : no such file, not a CSV in UTF-8, another header, a line with another number of fields, an empty word,
        a field that is no number within the bounds of its quantity; names the line and the column.
    """
    lines = csv_lines(path)
    named = ",".join(lines[0][1]).replace(";", ",").split(",") if lines else []
    columns = {**columns, **{name: None for name in optional if name in map(plain_cell, named)}}
    header = list(columns)
    has_semicolons = bool(lines) and [plain_cell(name) for name in ",".join(lines[0][1]).split(";")] == header
    if has_semicolons and len(header) > 1:
        lines = csv_lines(path, delimiter=";")
        numeric = [quantity is not None for quantity in columns.values()]
        lines[1:] = [
            (n, [f.replace(",", ".") if is_number else f for f, is_number in zip(fields, numeric, strict=False)])
            if len(fields) == len(header)
            else (n, fields)
            for n, fields in lines[1:]
        ]
    wanted = ",".join(header)
    if lines and len(lines[0][1]) == 1:
        require_no_tabs(lines[0][1][0], f"{path}:1")
    if not lines or lines[0][1] != header:
        more = [name for name in optional if name not in header]
        follow = f", which {', '.join(more)} may follow" if more else ""
        fact = _header_fact(lines[0][1] if lines else [], header)
        raise InputError(f"must begin with the header {wanted}{follow}; {fact}", where=f"{path}:1")
    rows = []
    for number, fields in lines[1:]:
        if not any(fields):
            continue
        if len(fields) != len(header):
            raise InputError(
                f"{len(fields)} fields, wanted {len(header)} ({wanted})",
                where=f"{path}:{number}",
                hint="" if has_semicolons else decimal_comma_hint(fields, len(header)),
            )
        words, numbers = {}, {}
        for (column, quantity), field in zip(columns.items(), fields, strict=True):
            if quantity is None:
                words[column] = field
                if not field and column not in optional:
                    raise InputError(f"{column} is empty", where=f"{path}:{number}")
            else:
                numbers[column] = number_of(quantity, column, field, f"{path}:{number}")
        rows.append(Row(number, words, numbers))
    if not rows:
        raise InputError("holds a header and nothing else", where=str(path))
    return rows


def _header_fact(found: Sequence[str], header: Sequence[str]) -> str:
    """What is wrong with a header: columns that it misses, columns that nothing reads, or the first out of place."""
    unknown = [f"{name[:40]!r}" for name in found if name not in header]
    if missing := [name for name in header if name not in found]:
        return f"misses {', '.join(missing)}" + (f", has {', '.join(unknown[:3])}" if unknown and found != [""] else "")
    if unknown:
        return f"has {', '.join(unknown[:3])} besides"
    pairs = enumerate(zip(found, header, strict=False), start=1)
    place, name = next(((i, is_) for i, (is_, should) in pairs if is_ != should), (len(header) + 1, found[-1]))
    return f"column {place} is {name!r}"


def csv_lines(path: Path, *, delimiter: str = ",") -> list[tuple[int, list[str]]]:
    """Lines of a CSV file in UTF-8, each with its number in the file and its fields without surrounding blanks.

    Raises
    ------
    InputError : no such file, not a CSV in UTF-8, larger than 256 MB, or with control characters.
    """
    require_regular_file(path)
    try:
        if (size := path.stat().st_size) > _MOST_BYTES:
            raise InputError(f"has {size:,} bytes; at most {_MOST_BYTES:,} are read", where=str(path))
        with open(path, newline="", encoding="utf-8-sig") as stream:
            reader = csv.reader(stream, strict=True, delimiter=delimiter)
            lines = [(reader.line_num, [plain_cell(field) for field in fields]) for fields in reader]
    except OSError as exc:
        raise InputError(f"cannot be read ({exc.strerror})", where=str(path)) from None
    except (UnicodeDecodeError, csv.Error) as exc:
        raise InputError(f"not a CSV in UTF-8 ({exc})", where=str(path)) from None
    for number, fields in lines:
        if fact := next((fact for field in fields if (fact := control_fact(field, _LAYOUT))), ""):
            raise InputError(fact, where=f"{path}:{number}")
    return lines


def require_no_tabs(header: str, where: str) -> None:
    """Raise `InputError` for a header that is divided by tabs and by nothing else."""
    if "\t" in header.strip() and not any(sign in header for sign in ",;"):
        raise InputError(
            "the columns are divided by tabs", where=where, hint="divide them by commas, or by semicolons, in all lines"
        )


def decimal_comma_hint(fields: Sequence[str], wanted: int) -> str:
    """What to do about a line with more fields between commas than the columns that are `wanted`, if it is of these."""
    is_split = wanted < len(fields) <= 2 * wanted and all(fields)
    return "where commas are decimal, divide the columns by semicolons, in the header too" if is_split else ""


def number_of(quantity: Quantity, column: str, field: str, where: str) -> float:
    """The number in a field of the column, or an `InputError` that names both, and the bounds it breaks."""
    try:
        # Python reads 1_000 as a number; nobody means it in a table.
        value = math.nan if "_" in field else float(field)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{column} must be a finite number, found {field[:40]!r}", where=where)
    if fact := quantity.fact(value):
        raise InputError(f"{column}: {fact}", where=where)
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
