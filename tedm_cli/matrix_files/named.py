"""What all formats hold, and how a file is read whatever its format."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.quantities import MATRIX_ENTRY
from tedm_cli.strict_toml import parsed_toml

Format = Literal["csv", "npz", "mat"]

#: Fields of a matrix beside its values; the declaration is TOML.
LISTS = ("rows", "columns", "row_units", "column_units")
DECLARATION = "declaration"


@dataclass(frozen=True, eq=False)
class NamedMatrix:
    """A matrix to be written: an entry has the unit of its row per unit of its column.

    Without `row_units` it is a table: an entry has the unit of its column. A table may be without labels of its `rows`.

    `declaration` is TOML that says what an importer must know of it; empty where nothing has to be.
    """

    name: str
    values: FloatArray
    rows: Sequence[str]
    columns: Sequence[str]
    row_units: Sequence[str]
    column_units: Sequence[str]
    description: str
    declaration: str = ""


@dataclass(frozen=True, eq=False)
class RawMatrix:
    """A matrix as found, [rows, columns], and what its file declares of it."""

    values: FloatArray
    declared: dict[str, Any]


def as_matrix(value: Any, name: str, path: Path) -> FloatArray:
    """`value` as real numbers in two dimensions; `InputError` for anything else, and for implausible ones."""
    array = np.asarray(value)
    if array.ndim != 2 or array.dtype.kind not in "fiu" or 0 in array.shape:
        raise InputError(
            f"{name} is {array.dtype} of shape {array.shape}; a matrix of real numbers is needed", where=str(path)
        )
    numbers = array.astype(np.float64)
    if (found := MATRIX_ENTRY.first_outside(numbers)) is not None:
        row, column = found
        fact = f"{name}, row {row + 1}, column {column + 1}: {MATRIX_ENTRY.fact(float(numbers[found]))}"
        raise InputError(fact, where=str(path))
    return numbers


def lacks(name: str, names: Sequence[str], path: Path) -> InputError:
    """The refusal of a file that holds matrices of other names; it names a few of them."""
    listed = ", ".join(n[:40] for n in names[:8]) + (f" and {len(names) - 8} more" if len(names) > 8 else "")
    return InputError(
        f"holds no {name}, but {listed or 'nothing'}", where=str(path), hint="name it with variable = ..."
    )


def parsed_declaration(text: str, name: str, path: Path) -> dict[str, Any]:
    """The declaration that a file holds of one of its matrices."""
    return parsed_toml(text, where=str(path), at=f"{name}.{DECLARATION}")


def text_list(value: Any) -> list[str]:
    """Strings of a list, a cell array or a padded character array."""
    return [str(v).strip() for v in np.atleast_1d(np.asarray(value, dtype=object)).reshape(-1)]
