"""export-case: spectra, bounds, contributions and verdicts of case files for other programs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from tedm_cli.contracts import CASE
from tedm_cli.errors import InputError, UsageError
from tedm_cli.exports.case import case_matrices, case_notes
from tedm_cli.exports.write import write_matrices
from tedm_cli.files.build_folder import case_file_name, require_up_to_date
from tedm_cli.files.store import open_checked
from tedm_cli.matrix_files.named import Format


def export_cases(build_dir: Path, case_ids: Sequence[str], fmt: Format, output: Path | None) -> list[Path]:
    """Write what the case files hold, one file (for CSV one folder) each; all of the build folder where none is named.

    Raises
    ------
    UsageError : one file for several cases.
    InputError : there is no case file, one is missing, stale, or breaks its contract.
    """
    there = sorted(build_dir.glob("case*.h5"))
    wanted = [build_dir / case_file_name(i) for i in dict.fromkeys(case_ids)] or there
    missing = [p for p in wanted if not p.exists()]
    if missing or not wanted:
        raise InputError(
            "no such file" if missing else "holds no case file",
            where=str(missing[0] if missing else build_dir),
            hint="make it with `tedm run-case`, or `tedm run`; there are:"
            f" {', '.join(p.name for p in there) or 'none'}",
        )
    paths: list[Path] = []
    for path in wanted:
        place = destination(build_dir, path.stem, fmt, output, len(wanted))
        with open_checked(path, CASE) as file:
            require_up_to_date(file)
            paths += write_matrices(*place, case_matrices(file), fmt, case_notes(file))
    return paths


def destination(build_dir: Path, stem: str, fmt: Format, output: Path | None, number: int) -> tuple[Path, str]:
    """Folder and stem of one case's file, of `number` in all; CSV has a folder for each."""
    if output is not None and output.suffix.lower() in (".csv", ".npz", ".mat"):
        if fmt == "csv" or output.suffix.lower() != f".{fmt}" or number > 1:
            fact = f"{output} cannot take {number} cases" if number > 1 else f"{output} cannot take a case as {fmt}"
            raise UsageError(fact, hint="name a folder")
        return output.parent, output.stem
    folder = output if output is not None else build_dir / "export"
    return (folder / stem if fmt == "csv" else folder), stem
