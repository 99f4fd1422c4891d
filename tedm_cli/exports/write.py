"""Matrices into files: one file per matrix as CSV, all in one as NPZ or MAT."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from tedm_cli.files.store import replacing
from tedm_cli.matrix_files.csv_file import write_csv
from tedm_cli.matrix_files.mat_file import write_mat
from tedm_cli.matrix_files.named import Format, NamedMatrix
from tedm_cli.matrix_files.npz_file import write_npz


def write_matrices(
    folder: Path, stem: str, matrices: Sequence[NamedMatrix], fmt: Format, notes: Sequence[str] = ()
) -> list[Path]:
    """The files written: `<name>.csv` of every matrix, with `<name>.csv.toml` where an importer needs to be told
    something, or `<stem>.npz`, `<stem>.mat`. The notes go into the latter, beside CSV into `readme.txt`."""
    if fmt != "csv":
        path = folder / f"{stem}.{fmt}"
        with replacing(path) as temporary:
            (write_npz if fmt == "npz" else write_mat)(temporary, matrices, notes)
        return [path]
    written = []
    for matrix in matrices:
        path = folder / f"{matrix.name}.csv"
        with replacing(path) as temporary:
            write_csv(temporary, matrix)
        written.append(path)
        if matrix.declaration:
            side = path.with_name(path.name + ".toml")
            text = f"[{matrix.name}]\n" + matrix.declaration.replace("\n[", f"\n[{matrix.name}.")
            with replacing(side) as temporary:
                temporary.write_text(text, encoding="utf-8", newline="\n")
            written.append(side)
    if notes:
        path = folder / "readme.txt"
        with replacing(path) as temporary:
            temporary.write_text("\n".join([*notes, ""]), encoding="utf-8", newline="\n")
        written.append(path)
    return written
