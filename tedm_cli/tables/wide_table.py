"""Users' tables of one key column (time_s, frequency_hz) and many value columns, from CSV or HDF5, read in blocks.

A CSV begins with the names of its columns. An HDF5 file holds one dataset [n] for each column in its root group, with
the same names. Both give the same numbers, and neither is ever held as a whole. A CSV whose header is divided by
semicolons has them throughout, and its numbers may have a decimal comma.
"""

from __future__ import annotations

import contextlib
import csv
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Protocol

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.files.columns import HDF5_SUFFIXES, Columns, open_columns
from tedm_cli.quantities import Quantity
from tedm_cli.regular_file import require_regular_file
from tedm_cli.tables.csv_table import decimal_comma_hint, plain_cell, require_no_tabs

BLOCK_NUMBERS = 1 << 21  # numbers of a block: 16 MB

Quantities = tuple[Quantity, Quantity, Mapping[str, Quantity]]


@dataclass(frozen=True, eq=False)
class Block:
    """Some rows of a table.

    Parameters
    ----------
    key : [B], the key column.
    values : [B, columns].
    places : [B], line or sample of each row, as messages name it.
    """

    key: FloatArray
    values: FloatArray
    places: IntArray


class WideTable(Protocol):
    """An open table."""

    path: Path
    columns: list[str]

    def blocks(self, rows: int = 0) -> Iterator[Block]:
        """All rows, `rows` at a time (as many as fit `BLOCK_NUMBERS` when 0); `InputError` for what is no number."""

    def place(self, number: int) -> str:
        """Where a row of `Block.places` is."""


@contextlib.contextmanager
def open_wide(
    path: Path, key: str, of_key: Quantity, of_values: Quantity, of_others: Mapping[str, Quantity] = {}
) -> Iterator[WideTable]:
    """Open a table by the suffix of its name: HDF5 for .h5, .hdf5 and .hdf, CSV for the rest.

    All its numbers must keep the bounds of the quantities of the key column and of the others; `of_others` are those of
    columns that are of another quantity than the rest, by name.

    Raises
    ------
    InputError : it cannot be read, has no column `key`, no other column, or a column twice.
    """
    if path.suffix.lower() in HDF5_SUFFIXES:
        with open_columns(path, key) as source:
            _require(source.columns, key, str(path), source.ignored)
            yield _Hdf5Table(path, key, source, (of_key, of_values, of_others))
        return
    require_regular_file(path)
    with contextlib.ExitStack() as stack:
        with _reading(path):
            stream = stack.enter_context(open(path, newline="", encoding="utf-8-sig"))
        yield _CsvTable(path, key, stream, (of_key, of_values, of_others))


@contextlib.contextmanager
def _reading(path: Path) -> Iterator[None]:
    """Faults of reading the CSV, as such; what its reader writes meanwhile has faults of its own."""
    try:
        yield
    except OSError as exc:
        raise InputError(f"cannot be read ({exc.strerror})", where=str(path)) from None
    except (UnicodeDecodeError, csv.Error) as exc:
        raise InputError(f"not a CSV in UTF-8 ({exc})", where=str(path)) from None


class _Hdf5Table:
    def __init__(self, path: Path, key: str, source: Columns, quantities: Quantities) -> None:
        self.path = path
        self.columns = [c for c in source.columns if c != key]
        self._source, self._names, self._quantities = source, [key, *self.columns], quantities

    def place(self, number: int) -> str:
        return f"{self.path}: row {number}"

    def blocks(self, rows: int = 0) -> Iterator[Block]:
        rows = rows or max(1, BLOCK_NUMBERS // len(self._names))
        for start in range(0, self._source.length, rows):
            part = slice(start, min(start + rows, self._source.length))
            numbers = np.stack([self._source.read(name, part) for name in self._names], axis=1)
            yield checked(self, self._quantities, self._names, 0, numbers, np.arange(part.start + 1, part.stop + 1))


class _CsvTable:
    def __init__(self, path: Path, key: str, stream: Iterator[str], quantities: Quantities) -> None:
        self.path = path
        self._stream, self._quantities = stream, quantities
        with _reading(path):
            line = next(self._stream, "")
        require_no_tabs(line, f"{path}:1")
        with _reading(path):
            self._delimiter = _delimiter(line, key)
            head = next(csv.reader([line], delimiter=self._delimiter), [])
        self._head = [plain_cell(name) for name in head]
        _require(self._head, key, f"{path}:1")
        self._at = self._head.index(key)
        for number, name in enumerate(self._head):
            if name in self._head[:number]:
                raise InputError(
                    f"column {name!r} is there twice (columns {self._head.index(name) + 1} and {number + 1})",
                    where=f"{path}:1",
                    hint="keep one of them",
                )
        self.columns = [name for name in self._head if name != key]

    def place(self, number: int) -> str:
        return f"{self.path}:{number}"

    def blocks(self, rows: int = 0) -> Iterator[Block]:
        rows = rows or max(1, BLOCK_NUMBERS // len(self._head))
        first = 2
        while lines := self._lines(rows):
            held = np.array([n for n, line in enumerate(lines) if not line.isspace()], dtype=np.int64)
            if held.size:
                with _reading(self.path):
                    numbers = self._numbers([lines[n] for n in held], held + first)
                yield checked(self, self._quantities, self._head, self._at, numbers, held + first)
            first += len(lines)

    def _lines(self, rows: int) -> list[str]:
        with _reading(self.path):
            return list(islice(self._stream, rows))

    def _numbers(self, lines: list[str], places: IntArray) -> FloatArray:
        plain = [line.replace(",", ".") for line in lines] if self._delimiter == ";" else lines
        try:
            numbers = np.loadtxt(plain, delimiter=self._delimiter, comments=None, ndmin=2)
            if numbers.shape == (len(lines), len(self._head)):
                return numbers
        except ValueError:
            pass
        for line, place in zip(lines, places, strict=True):  # what did not fit, and where
            fields = [field.strip() for field in next(csv.reader([line], delimiter=self._delimiter))]
            if len(fields) != len(self._head):
                fact = f"{len(fields)} fields, wanted {len(self._head)} as in the header"
                hint = decimal_comma_hint(fields, len(self._head)) if self._delimiter == "," else ""
                raise InputError(fact, where=self.place(int(place)), hint=hint)
            for name, field in zip(self._head, fields, strict=True):
                try:
                    float(field.replace(",", ".") if self._delimiter == ";" else field)
                except ValueError:
                    what = repr(field[:40]) if field else "nothing"
                    raise InputError(f"{name} must be a number, found {what}", where=self.place(int(place))) from None
        raise InputError(
            "numbers must be plain, without quotes or underscores", where=f"{self.path}:{places[0]} to {places[-1]}"
        )


def _delimiter(header: str, key: str) -> str:
    """Comma or semicolon: that which makes `key` a column; a comma where neither does, if there is one."""
    by_comma, by_semicolon = (
        [plain_cell(name) for row in csv.reader([header], delimiter=d) for name in row] for d in ",;"
    )
    if key in by_comma or ";" not in header:
        return ","
    return ";" if key in by_semicolon or "," not in header else ","


def _require(columns: list[str], key: str, where: str, ignored: Sequence[str] = ()) -> None:
    """Raise `InputError` without a key column or without another; `ignored` datasets are no columns."""
    besides = (
        f"; no columns, as they are not one-dimensional and of real numbers: {', '.join(ignored)}" if ignored else ""
    )
    if key not in columns:
        shown = ", ".join(columns[:6]) + (" ..." if len(columns) > 6 else "")
        raise InputError(
            f"there is no column {key}" + (f"; there are: {shown}" if columns else "") + besides,
            where=where,
            hint=f"a table has the column {key} and one for each thermal area, group or shield, or one named all",
        )
    if len(columns) < 2:
        raise InputError(f"there is the column {key} and no other{besides}", where=where)


def checked(
    table: WideTable,
    quantities: Quantities,
    names: list[str],
    at: int,
    numbers: FloatArray,
    places: IntArray,
) -> Block:
    """The block [B, names] whose key column is number `at`, if all of its numbers are finite and plausible."""
    finite = np.isfinite(numbers)
    if not finite.all():
        row, column = (int(v) for v in np.argwhere(~finite)[0])
        bad = numbers.size - int(finite.sum())
        raise InputError(
            f"{names[column]} is {numbers[row, column]:g}" + (f" ({bad} such numbers near here)" if bad > 1 else ""),
            where=table.place(int(places[row])),
            hint="cut the table there, or fill the gap before it is propagated",
        )
    block = Block(numbers[:, at].copy(), np.delete(numbers, at, axis=1), places)
    of_key, of_values, of_others = quantities
    columns = [name for i, name in enumerate(names) if i != at]
    other = np.array([name in of_others for name in columns])
    rest = block.values if not other.any() else block.values[:, ~other]
    judged = [(of_key, block.key[:, None], [names[at]])]
    judged.append((of_values, rest, [name for name in columns if name not in of_others]))
    judged += [(of_others[columns[i]], block.values[:, [i]], [columns[i]]) for i in np.flatnonzero(other).tolist()]
    for quantity, values, held in judged:
        if (found := quantity.first_outside(values)) is not None:
            fact = f"{held[found[1]]}: {quantity.fact(float(values[found]))}"
            raise InputError(fact, where=table.place(int(places[found[0]])))
    return block
