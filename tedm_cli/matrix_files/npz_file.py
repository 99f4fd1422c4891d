"""NPZ: the matrix under its name, its labels and the rest as `<name>.rows`, `<name>.row_units` and so on."""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

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
from tedm_cli.matrix_files.npz_archive import read_arrays


def read_npz(path: Path, name: str) -> RawMatrix:
    """The matrix `name` of an NPZ file.

    Raises
    ------
    InputError : as `read_arrays` raises it, or an archive without such a matrix.
    """
    held, names = read_arrays(path, lambda key: key == name or key.startswith(f"{name}."))
    if name not in held:
        raise lacks(name, [key for key in names if "." not in key], path)
    declared: dict[str, Any] = {}
    if f"{name}.{DECLARATION}" in held:
        declared |= parsed_declaration(str(held[f"{name}.{DECLARATION}"]), name, path)
    declared |= {key: text_list(held[f"{name}.{key}"]) for key in LISTS if f"{name}.{key}" in held}
    return RawMatrix(as_matrix(held[name], name, path), declared)


def npz_variables(path: Path) -> dict[str, Any]:
    """All plain arrays of an NPZ file by name; raises as `read_arrays` does."""
    return dict(read_arrays(path, lambda key: True)[0])


def write_npz(path: Path, matrices: Sequence[NamedMatrix], notes: Sequence[str] = ()) -> None:
    """All matrices into one file, with the notes as `readme`."""
    arrays: dict[str, Any] = {"readme": np.array("\n".join(notes))} if notes else {}
    for m in matrices:
        arrays[m.name] = m.values
        for key in (k for k in LISTS if len(getattr(m, k))):
            arrays[f"{m.name}.{key}"] = np.array(list(getattr(m, key)), dtype=str)
        arrays[f"{m.name}.description"] = np.array(m.description)
        if m.declaration:
            arrays[f"{m.name}.{DECLARATION}"] = np.array(m.declaration)
    # NumPy's savez leaves an archive that could not be written open, and it fails once more when it is collected.
    with zipfile.ZipFile(path, "w") as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as stream:
                np.lib.format.write_array(stream, array, allow_pickle=False)  # type: ignore[no-untyped-call]
