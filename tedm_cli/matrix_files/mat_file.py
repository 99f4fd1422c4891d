"""MAT of MATLAB 5 to 7: a structure per matrix, with fields `value`, `rows`, `row_units` and so on.

Files of MATLAB 4, and matrices that stand in a file without a structure, are read as well.
"""

from __future__ import annotations

import io
import math
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from tedm_cli.errors import InputError
from tedm_cli.matrix_files.mat_structure import MOST_BYTES, MatError, plain_mat
from tedm_cli.matrix_files.named import (
    DECLARATION,
    LISTS,
    NamedMatrix,
    RawMatrix,
    as_matrix,
    lacks,
    parsed_declaration,
    text_list,
)
from tedm_cli.regular_file import require_regular_file

#: MATLAB 5 to 7 hold no larger variable.
LARGEST_BYTES = 2**31
_TITLE = b"MATLAB 5.0 MAT-file, written by tedm".ljust(116)  # the usual one holds the date


def read_mat(path: Path, name: str) -> RawMatrix:
    """The matrix `name` of a MAT file.

    Raises
    ------
    InputError : not a MAT file of MATLAB 4 to 7, one that has not what its headers say, or without such a matrix.
    """
    file = mat_variables(path)
    if name not in file:
        raise lacks(name, list(file), path)
    found = file[name]
    fields: dict[str, Any] = found if isinstance(found, dict) else {"value": found}
    if "value" not in fields:
        raise InputError(f"{name} is a structure without the field value", where=str(path))
    declared: dict[str, Any] = {}
    if DECLARATION in fields:
        declared |= parsed_declaration(str(fields[DECLARATION]), name, path)
    declared |= {key: text_list(fields[key]) for key in LISTS if key in fields}
    value = fields["value"]
    if scipy.sparse.issparse(value):
        if math.prod(value.shape) * 8 > MOST_BYTES:
            fact = f"{name} of shape {value.shape} has more than {MOST_BYTES:,} bytes in full"
            raise InputError(fact, where=str(path))
        value = value.toarray()
    return RawMatrix(as_matrix(value, name, path), declared)


def mat_variables(path: Path) -> dict[str, Any]:
    """All variables of a MAT file of MATLAB 4 to 7 by name, whose structure has been checked."""
    require_regular_file(path)
    try:
        size = path.stat().st_size
        if size > MOST_BYTES:
            raise InputError(f"has {size:,} bytes; at most {MOST_BYTES:,} are read", where=str(path))
        raw = path.read_bytes()
    except OSError as exc:
        raise InputError(f"cannot be read ({exc.strerror or exc})", where=str(path)) from exc
    if raw.startswith((b"MATLAB 7.3", b"\x89HDF")):
        raise InputError("is a MAT file of version 7.3 (HDF5)", where=str(path), hint="save it with save(..., '-v7')")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # of what it would pass over, as a name that is there twice
            file = scipy.io.loadmat(io.BytesIO(plain_mat(raw)), simplify_cells=True)
    except MatError as exc:
        raise InputError(f"not a readable MAT file: it {exc}", where=str(path)) from exc
    except Exception as exc:  # damaged files make it fail in every way
        raise InputError(f"not a readable MAT file ({str(exc)[:200]})", where=str(path)) from exc
    return {key: value for key, value in file.items() if not key.startswith("__")}


def write_mat(path: Path, matrices: Sequence[NamedMatrix], notes: Sequence[str] = ()) -> None:
    """All matrices into one file, with a table `contents` of their names and what they are, and `readme` of the notes.

    Raises
    ------
    InputError : a matrix is larger than the format can hold.
    """
    for m in matrices:
        if m.values.nbytes >= LARGEST_BYTES:
            raise InputError(
                f"{m.name} has {m.values.nbytes / 2**30:.3g} GiB; a MAT file holds matrices below 2 GiB",
                where=str(path),
                hint="export it with --format npz",
            )
    variables: dict[str, Any] = {m.name: _structure(m) for m in matrices}
    variables["contents"] = _cells([text for m in matrices for text in (m.name, m.description)]).reshape(-1, 2)
    if notes:
        variables["readme"] = "\n".join(notes)
    buffer = io.BytesIO()
    scipy.io.savemat(buffer, variables, do_compression=True, long_field_names=True)
    data = buffer.getbuffer()
    data[: len(_TITLE)] = _TITLE
    path.write_bytes(data)


def _structure(m: NamedMatrix) -> dict[str, Any]:
    fields: dict[str, Any] = {"value": m.values}
    fields |= {key: _cells(getattr(m, key)).reshape(-1, 1) for key in LISTS if len(getattr(m, key))}
    fields["description"] = m.description
    if m.declaration:
        fields[DECLARATION] = m.declaration
    return fields


def _cells(texts: Sequence[str]) -> Any:
    """A cell array of strings."""
    out = np.empty(len(texts), dtype=object)
    out[:] = list(texts)
    return out
