"""CSV: `row,unit,<columns>`, then `unit,,<units of the columns>`, then a line per row with its label and unit.

`unit` may be left out in either place, and a matrix may be bare numbers: what is missing is declared beside the file.
"""

from __future__ import annotations

from pathlib import Path
from typing import TextIO

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.matrix_files.named import NamedMatrix, RawMatrix
from tedm_cli.quantities import MATRIX_ENTRY
from tedm_cli.tables.csv_table import csv_line, csv_lines, number_of


def read_csv(path: Path, name: str) -> RawMatrix:
    """The only matrix of a CSV file.

    Raises
    ------
    InputError : not readable, lines of different lengths, or a field that is no finite number, with its place.
    """
    lines = [(number, fields) for number, fields in csv_lines(path) if any(fields)]
    if not lines:
        raise InputError("is empty", where=str(path))
    width = len(lines[0][1])
    for number, fields in lines:
        if len(fields) != width:
            raise InputError(f"{len(fields)} fields, the first line has {width}", where=f"{path}:{number}")
    head = lines[0][1]
    if _is_number(head[-1]):
        return RawMatrix(_numbers(path, lines, 0, [f"column {k + 1}" for k in range(width)]), {})
    first = 2 if len(head) > 1 and head[1] == "unit" else 1
    declared: dict[str, object] = {"columns": head[first:]}
    body = lines[1:]
    if body and body[0][1][0] == "unit":
        declared["column_units"] = body.pop(0)[1][first:]
    if not body or not head[first:]:
        raise InputError("holds no numbers", where=str(path), hint="separate the fields by commas")
    declared["rows"] = [fields[0] for _, fields in body]
    if first == 2:
        declared["row_units"] = [fields[1] for _, fields in body]
    return RawMatrix(_numbers(path, body, first, head), declared)


def write_csv(path: Path, matrix: NamedMatrix) -> None:
    """Numbers with all their digits: they come back the same."""
    with open(path, "w", newline="", encoding="utf-8") as stream:
        if not matrix.row_units:
            _write_table(stream, matrix)
            return
        stream.write(csv_line(["row", "unit", *matrix.columns]))
        stream.write(csv_line(["unit", "", *matrix.column_units]))
        for label, unit, values in zip(matrix.rows, matrix.row_units, matrix.values, strict=True):
            stream.write(csv_line([label, unit, *(repr(float(v)) for v in values)]))


def _write_table(stream: TextIO, table: NamedMatrix) -> None:
    """A line of names, a line of units, and the numbers, behind the labels of the rows where there are any."""
    labelled = bool(table.rows)
    stream.write(csv_line([*(["row"] if labelled else []), *table.columns]))
    stream.write(csv_line([*(["unit"] if labelled else []), *table.column_units]))
    for i, values in enumerate(table.values):
        stream.write(csv_line([*(table.rows[i : i + 1]), *(repr(float(v)) for v in values)]))


def _numbers(path: Path, lines: list[tuple[int, list[str]]], first: int, names: list[str]) -> FloatArray:
    return np.array(
        [
            [number_of(MATRIX_ENTRY, names[k], fields[k], f"{path}:{number}") for k in range(first, len(fields))]
            for number, fields in lines
        ]
    )


def _is_number(field: str) -> bool:
    try:
        float(field)
    except ValueError:
        return False
    return True
