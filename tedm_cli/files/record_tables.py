"""Tables of records in HDF5 files of other programs: compound datasets of one dimension, read in pieces.

Such a file is first read in a process of its own (`files.trial`), which at the same time finds where in a table the
rows of each key are.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import sys
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from tedm_cli.arrays import AnyArray
from tedm_cli.errors import InputError
from tedm_cli.files.blocks import reading
from tedm_cli.files.contract_check import attribute_text
from tedm_cli.files.elsewhere import kept_elsewhere, links_elsewhere
from tedm_cli.files.seal import Identity, identity_of
from tedm_cli.files.trial import trial
from tedm_cli.regular_file import require_regular_file

_BLOCK = 1 << 22  # bytes read at once
_MOST_RUNS = 100_000
_SIGNATURE = b"\x89HDF\r\n\x1a\n"
Run = tuple[int, int, int]  # key, first row, row behind the last


def is_hdf5(path: Path) -> bool:
    """Whether a file begins as HDF5 does; what is not there, or no regular file, does not."""
    if not path.is_file():
        return False
    with open(path, "rb") as stream:
        return stream.read(len(_SIGNATURE)) == _SIGNATURE


class RecordTables:
    """The tables of an open file; made by `open_tables`.

    A table is a compound dataset of one dimension. Each method that takes one raises `InputError` where the file has it
    not, in another form, not to its end, or in another file.
    """

    def __init__(self, file: Any, path: Path, hint: str) -> None:
        self._file, self._path, self._hint = file, path, hint
        self._runs: dict[str, list[Run]] = {}
        with self._reading():
            problems = links_elsewhere(file, soft=False)
        for problem in problems:
            raise self.refused(problem)

    def attribute(self, name: str) -> str | None:
        """An attribute of the file as text, or None."""
        with self._reading():
            return attribute_text(self._file, name)

    def has(self, path: str) -> bool:
        with self._reading(path):
            return self._file.get(path) is not None

    def members(self, group: str) -> list[str]:
        """Names in a group; none where there is no such group."""
        with self._reading(group):
            found = self._file.get(group)
            return [str(name) for name in found] if isinstance(found, h5py.Group) else []

    def columns(self, table: str) -> dict[str, np.dtype[Any]]:
        """Columns of a table and their types."""
        dtype = self._table(table).dtype
        return {str(name): dtype[name] for name in dtype.names}

    def blocks(self, table: str, part: slice | None = None) -> Iterator[AnyArray]:
        """The records of a table, or of some of its rows, in pieces of some megabytes."""
        data = self._table(table)
        first, last = (0, len(data)) if part is None else (part.start, part.stop)
        rows = max(1, _BLOCK // max(1, data.dtype.itemsize))
        for start in range(first, last, rows):
            with self._reading(table):
                yield np.asarray(data[start : min(start + rows, last)])

    def runs(self, table: str) -> list[Run]:
        """Where one key follows itself: key, first row and row behind the last of each such run, in their order."""
        return self._runs.get(table, [])

    def _table(self, path: str) -> Any:
        with self._reading(path):
            found = self._file.get(path)
            if found is None:
                raise self.refused(f"has no table {path}")
            if not isinstance(found, h5py.Dataset) or found.ndim != 1 or found.dtype.names is None:
                raise self.refused(f"{path} is no table of records")
            problem = kept_elsewhere(found)
        if problem:
            raise self.refused(f"{path} {problem}")
        return found

    def _reading(self, path: str = "") -> contextlib.AbstractContextManager[None]:
        return reading(self._path, path, self._hint)

    def refused(self, fact: str) -> InputError:
        """The error for a file that is not as it should be."""
        return InputError(fact, where=str(self._path), hint=self._hint)

    def _find_runs(self, table: str, key: str) -> list[Run]:
        found: list[Run] = []
        start = 0
        for rows in self.blocks(table):
            keys = rows[key]
            edges = [0, *(np.flatnonzero(np.diff(keys)) + 1).tolist(), len(keys)]
            for first, last in itertools.pairwise(edges):
                number, at = int(keys[first]), start + first
                if found and found[-1][0] == number:
                    found[-1] = (number, found[-1][1], start + last)
                else:
                    found.append((number, at, start + last))
            if len(found) > _MOST_RUNS:
                raise self.refused(f"{table}: rows of different {key} are mixed, wanted one after the other")
            start += len(rows)
        return found


@contextlib.contextmanager
def open_tables(path: Path, tables: Sequence[str], key: str, hint: str) -> Iterator[RecordTables]:
    """Open an HDF5 file of another program.

    Parameters
    ----------
    tables : those that will be read, where the file has them; all of each is read beforehand.
    key : whole-number column of which `RecordTables.runs` tells where its values are.
    hint : what a user can do about a file that is damaged.

    Raises
    ------
    InputError : missing, not HDF5, damaged, with data in other files, changed meanwhile, or with the keys all mixed.
    """
    require_regular_file(path)
    try:
        identity = identity_of(path)
    except OSError as exc:
        raise InputError(f"cannot be read ({exc.strerror})", where=str(path)) from exc
    told = _walked(path, identity, tuple(tables), key, hint)
    if "refused" in told:
        raise InputError(told["refused"], where=str(path), hint=hint)
    with _opened(path, hint) as found:
        if identity_of(path) != identity:
            raise InputError("was changed while it was read", where=str(path), hint="run again when nothing writes it")
        found._runs = {table: [(k, a, b) for k, a, b in runs] for table, runs in told["runs"].items()}
        yield found


@contextlib.contextmanager
def _opened(path: Path, hint: str) -> Iterator[RecordTables]:
    try:
        file = h5py.File(path, "r")
    except OSError as exc:
        raise InputError("not a readable HDF5 file (truncated or damaged)", where=str(path), hint=hint) from exc
    with file:
        yield RecordTables(file, path, hint)


@cache
def _walked(path: Path, identity: Identity, tables: tuple[str, ...], key: str, hint: str) -> dict[str, Any]:
    """What `main` says of a file."""
    said = trial("tedm_cli.files.record_tables", path, key, *tables, size=identity[2], hint=hint)
    return dict(json.loads(said))


def main() -> None:
    """Read tables of the file that the command line names, and print where their keys are, or why it is refused."""
    name, key, *tables = sys.argv[1:]
    told: dict[str, Any] = {}
    try:
        with _opened(Path(name), "") as file:
            runs: dict[str, list[Run]] = {}
            for table in tables:
                if not file.has(table):
                    continue
                columns = file.columns(table)
                if key in columns and columns[key].kind in "iu" and not columns[key].shape:
                    runs[table] = file._find_runs(table, key)
                else:
                    for _ in file.blocks(table):
                        pass
            told["runs"] = runs
    except InputError as exc:
        told = {"refused": exc.fact}
    print(json.dumps(told))


if __name__ == "__main__":
    main()
