"""Real DMIG matrices of pyNastran models, with the labels of their rows and columns, and their cards."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.nastran.library import without_integration

SQUARE, RECTANGULAR, SYMMETRIC = (1,), (2, 9), (6,)


@dataclass(frozen=True, eq=False)
class Entries:
    """Entries [e] of a matrix: grid and component [e, 2] of the row, of the column (its number and 0 where the matrix
    is rectangular), and value."""

    row: IntArray
    column: IntArray
    value: FloatArray

    def dense(self, rows: Sequence[tuple[int, int]], columns: Sequence[tuple[int, int]], what: str) -> FloatArray:
        """The matrix over these labels; `InputError` for an entry with any other."""
        at_row, at_column = ({label: n for n, label in enumerate(labels)} for labels in (rows, columns))
        out = np.zeros((len(rows), len(columns)))
        for row, column, value in zip(self.row.tolist(), self.column.tolist(), self.value.tolist(), strict=True):
            for label, known, side in ((row, at_row, "row"), (column, at_column, "column")):
                if tuple(label) not in known:
                    named = f"grid {label[0]} component {label[1]}" if label[1] else f"{label[0]}"
                    raise InputError(f"{what} has an entry in {side} {named}, which it should not have")
            out[at_row[tuple(row)], at_column[tuple(column)]] = value
        return out


def entries_of(model: Any, name: str, forms: Iterable[int], where: str) -> Entries:
    """Entries of the DMIG `name` of a pyNastran model, both triangles of a symmetric one.

    Raises
    ------
    InputError : no such matrix, a complex one, or one of another form.
    """
    found = model.dmig.get(name)
    if found is None:
        known = ", ".join(sorted(model.dmig)[:8]) or "none"
        raise InputError(f"has no DMIG matrix {name}; there are: {known}", where=where)
    if found.is_complex:
        raise InputError(f"DMIG {name} is complex; matrices of linear statics are real", where=where)
    if found.matrix_form not in forms:
        listed = " or ".join(str(form) for form in forms)
        raise InputError(f"DMIG {name} has form {found.matrix_form}, wanted {listed}", where=where)
    row, column = (np.array(labels, dtype=np.int64).reshape(-1, 2) for labels in (found.GCi, found.GCj))
    value = np.array(found.Real, dtype=np.float64).reshape(-1)
    if not np.isfinite(value).all():
        raise InputError(f"DMIG {name} has entries that are no finite numbers", where=where)
    if found.matrix_form in SYMMETRIC:
        row, column, value = np.vstack([row, column]), np.vstack([column, row]), np.tile(value, 2)
    elif found.matrix_form in RECTANGULAR and found.ncols is None:  # columns are counted, whatever their labels
        _, number = np.unique(column, axis=0, return_inverse=True)
        column = np.column_stack([number.reshape(-1) + 1, np.zeros(len(value), dtype=np.int64)])
    elif found.matrix_form in RECTANGULAR:
        column = np.column_stack([column[:, 0], np.zeros(len(value), dtype=np.int64)])
    return Entries(row, column, value)


def cards(
    name: str,
    matrix: FloatArray,
    rows: Sequence[tuple[int, int]],
    columns: Sequence[tuple[int, int]] | None = None,
) -> list[str]:
    """Lines of a DMIG of 16-digit fields: eleven digits of every entry, ten of a negative one.

    Symmetric (the lower triangle) without `columns`, else rectangular with numbered columns. Entries of zero are left
    out.
    """
    with without_integration():
        from pyNastran.bdf.field_writer_8 import print_card_8
        from pyNastran.bdf.field_writer_double import print_card_double

    form = 6 if columns is None else 9
    header = ["DMIG", name, 0, form, 2, 0, None, None, None if columns is None else matrix.shape[1]]
    lines: list[str] = print_card_8(header).splitlines()
    for j, column in enumerate(rows if columns is None else columns):
        first = j if columns is None else 0
        fields: list[Any] = ["DMIG", name, *column, None]
        for i in first + np.flatnonzero(matrix[first:, j]):
            fields += [*rows[i], float(matrix[i, j]), None]
        if len(fields) > 5:
            lines += print_card_double(fields).splitlines()
    return lines


def numbered(count: int) -> list[tuple[int, int]]:
    """Labels of the columns of a rectangular matrix."""
    return [(n, 0) for n in range(1, count + 1)]


def six(grids: Iterable[int]) -> list[tuple[int, int]]:
    """Labels of the six freedoms of each of some grids."""
    return [(int(grid), component) for grid in grids for component in range(1, 7)]
