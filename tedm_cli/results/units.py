"""Units that a file gives row by row, against what its rows are."""

from __future__ import annotations

from collections.abc import Sequence

from tedm_cli.errors import InputError
from tedm_cli.files.store import Reader


def units_of(file: Reader, path: str, labels: Sequence[str], wanted: Sequence[str]) -> list[str]:
    """The units in `path` of rows with these labels; `InputError` names the first that is not the wanted one."""
    found = file.strings(path)
    for label, unit, right in zip(labels, found, wanted, strict=True):
        if unit != right:
            fact = f"{path}: {label} is in {unit}, wanted {right}"
            raise InputError(fact, where=str(file.path), hint=f"make it again with `{file.kind.made_by}`")
    return found
