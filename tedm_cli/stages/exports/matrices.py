"""export: the small matrices of the build folder for other programs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tedm_cli.errors import InputError, UsageError
from tedm_cli.exports.tables import TABLES
from tedm_cli.exports.write import write_matrices
from tedm_cli.files.build_folder import require_up_to_date
from tedm_cli.files.store import open_checked
from tedm_cli.matrix_files.named import Format, NamedMatrix


@dataclass(frozen=True)
class Exported:
    """The files, and the matrices in them."""

    paths: tuple[Path, ...]
    matrices: tuple[NamedMatrix, ...]


def export(build_dir: Path, what: Sequence[str], fmt: Format, output: Path | None) -> Exported:
    """Write the matrices of the kinds `what` (all that the build folder holds, where none is named).

    `output` is a folder, or for NPZ and MAT a file that takes them all.

    Raises
    ------
    UsageError : an unknown kind, or a single file for CSV.
    InputError : there is nothing to export, or a file is missing, stale or breaks its contract.
    """
    unknown = [name for name in what if name not in TABLES]
    if unknown:
        raise UsageError(
            f"there are no matrices to export from {', '.join(unknown)}",
            hint=f"known: {', '.join(TABLES)}; cases: tedm export-case",
        )
    single = output is not None and output.suffix.lower() in (".csv", ".npz", ".mat")
    if single and output is not None and (fmt == "csv" or output.suffix.lower() != f".{fmt}"):
        raise UsageError(
            f"{output} cannot take the matrices as {fmt}",
            hint="name a folder: CSV makes one file per matrix" if fmt == "csv" else f"end its name in .{fmt}",
        )
    kinds = list(dict.fromkeys(what)) or [name for name in TABLES if (build_dir / f"{name}.h5").exists()]
    if not kinds:
        raise InputError("holds nothing to export", where=str(build_dir), hint="`tedm run` makes what can be exported")
    by_kind: dict[str, list[NamedMatrix]] = {}
    for name in kinds:
        kind, matrices = TABLES[name]
        with open_checked(build_dir / f"{name}.h5", kind) as file:
            require_up_to_date(file)
            by_kind[name] = matrices(file)
            if what and not by_kind[name]:
                raise InputError("holds no optical elements to export", where=str(file.path))
    if not any(by_kind.values()):
        raise InputError("holds nothing to export", where=str(build_dir), hint="`tedm run` makes what can be exported")
    if output is not None and single:
        by_kind = {output.stem: [m for matrices in by_kind.values() for m in matrices]}
    folder = build_dir / "export" if output is None else output.parent if single else output
    paths = [path for stem, matrices in by_kind.items() for path in write_matrices(folder, stem, matrices, fmt)]
    return Exported(tuple(paths), tuple(m for matrices in by_kind.values() for m in matrices))
