"""What all formats hold, and how a file is read whatever its format."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import ConfigError, InputError

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
    """`value` as real numbers in two dimensions."""
    array = np.asarray(value)
    if array.ndim != 2 or array.dtype.kind not in "fiu" or 0 in array.shape:
        raise InputError(
            f"{name} is {array.dtype} of shape {array.shape}; a matrix of real numbers is needed", where=str(path)
        )
    return array.astype(np.float64)


def parsed_declaration(text: str, name: str, path: Path) -> dict[str, Any]:
    """The declaration that a file holds of one of its matrices."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as exc:
        raise ConfigError([(f"{name}.{DECLARATION}", f"not valid TOML: {exc}")], where=str(path)) from exc


def text_list(value: Any) -> list[str]:
    """Strings of a list, a cell array or a padded character array."""
    return [str(v).strip() for v in np.atleast_1d(np.asarray(value, dtype=object)).reshape(-1)]
