"""Correlation matrices from files, CSV or NPZ with the arrays `area` and `R`, and as the text of a CSV."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tedm_cli.arrays import AnyArray, FloatArray
from tedm_cli.errors import InputError
from tedm_cli.matrix_files.npz_archive import read_arrays
from tedm_cli.noise.correlation import LabelledMatrix
from tedm_cli.quantities import MATRIX_ENTRY
from tedm_cli.regular_file import require_regular_file
from tedm_cli.tables.csv_table import csv_line, plain_cell


def read_matrix(path: Path) -> LabelledMatrix:
    """A correlation matrix with the names of its areas.

    A CSV begins with `area` and the names of the columns; each line begins with the name of its row. Rows may be in
    another order than columns. Entries are real or complex (`0.5-0.2j` or `0.5-0.2i`). An NPZ holds `area` [n] and
    `R` [n, n].

    Raises
    ------
    InputError : no such file, another form, an entry that is no finite number (with its line), rows that are not the
        columns.
    """
    require_regular_file(path)
    try:
        names, value = _read_npz(path) if path.suffix.lower() == ".npz" else _read_csv(path)
    except OSError as exc:
        raise InputError(f"cannot be read ({exc.strerror or exc})", where=str(path)) from None
    real = value.real if np.iscomplexobj(value) and not value.imag.any() else value
    return LabelledMatrix(tuple(names), real, str(path))


def matrix_csv(names: Sequence[str], value: FloatArray) -> str:
    """A real matrix [n, n] as the CSV that `read_matrix` takes, without loss."""
    rows = ([name, *map(repr, row)] for name, row in zip(names, value.tolist(), strict=True))
    return "".join(csv_line(row) for row in (["area", *names], *rows))


def _read_npz(path: Path) -> tuple[list[str], AnyArray]:
    held, found = read_arrays(path, lambda key: key in ("area", "R"))
    missing = [key for key in ("area", "R") if key not in held]
    if missing:
        fact = f"holds no array {missing[0]!r}, only {', '.join(found[:8]) or 'nothing'}"
        raise InputError(fact, where=str(path), hint="np.savez(file, area=names, R=matrix)")
    names, value = [str(n) for n in held["area"].reshape(-1)], held["R"]
    if value.shape != (len(names), len(names)) or value.dtype.kind not in "fciu":
        raise InputError(f"R is {value.dtype} {value.shape} for {len(names)} areas", where=str(path))
    value = value.astype(np.complex128 if value.dtype.kind == "c" else np.float64)
    for part in (value.real, value.imag):
        if (at := MATRIX_ENTRY.first_outside(part)) is not None:
            fact = f"R of {names[at[0]]} and {names[at[1]]}: {MATRIX_ENTRY.fact(float(part[at]))}"
            raise InputError(fact, where=str(path))
    return names, value


def _read_csv(path: Path) -> tuple[list[str], AnyArray]:
    try:
        with open(path, newline="", encoding="utf-8-sig") as stream:
            reader = csv.reader(stream, strict=True)
            lines = [(reader.line_num, [plain_cell(f) for f in fields]) for fields in reader]
    except (UnicodeDecodeError, csv.Error) as exc:
        raise InputError(f"not a CSV in UTF-8 ({exc})", where=str(path)) from None
    lines = [(number, fields) for number, fields in lines if any(fields)]
    if not lines or lines[0][1][0] != "area" or len(lines[0][1]) < 2:
        raise InputError("must begin with the header area,NAME,NAME,...", where=f"{path}:1")
    columns = lines[0][1][1:]
    rows: dict[str, list[complex]] = {}
    for number, fields in lines[1:]:
        where = f"{path}:{number}"
        if len(fields) != len(columns) + 1:
            raise InputError(f"{len(fields)} fields, wanted {len(columns) + 1}", where=where)
        if fields[0] in rows:
            raise InputError(f"area {fields[0]!r} has two rows", where=where)
        rows[fields[0]] = [_entry(f, c, where) for f, c in zip(fields[1:], columns, strict=True)]
    lost = [name for name in columns if name not in rows] + [name for name in rows if name not in columns]
    if lost:
        raise InputError(f"area {lost[0]!r} has no {'row' if lost[0] in columns else 'column'}", where=str(path))
    return columns, np.array([rows[name] for name in columns])


def _fact(value: complex) -> str:
    """What is implausible about an entry. What is only more than 1 is said better by the check of the whole matrix."""
    return MATRIX_ENTRY.fact(value.real) or MATRIX_ENTRY.fact(value.imag)


def _entry(field: str, column: str, where: str) -> complex:
    try:
        value = complex(np.nan if "_" in field else field.replace(" ", "").replace("i", "j"))
    except ValueError:
        value = complex(np.nan)
    if not np.isfinite(value):
        raise InputError(f"{column} must be a finite number, real or complex, found {field[:40]!r}", where=where)
    if fact := _fact(value):
        raise InputError(f"{column}: {fact}", where=where)
    return value
