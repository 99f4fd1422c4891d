"""Users' tables in HDF5: one-dimensional datasets in the root group, read in pieces.

Such a file carries no seal, and a damaged one can make the HDF5 library loop for ever or end the process. So it is read
once from end to end in a process of its own that may take some time and no more, before this one opens it.
"""

from __future__ import annotations

import contextlib
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.files.blocks import reading
from tedm_cli.files.elsewhere import kept_elsewhere, links_elsewhere
from tedm_cli.files.seal import Identity, identity_of
from tedm_cli.regular_file import require_regular_file

HDF5_SUFFIXES = (".h5", ".hdf5", ".hdf")
SECONDS = 60.0  # for the start of Python and the reading of a small file
BYTES_PER_SECOND = 10e6  # of a slow disk, for a large one
_BLOCK = 1 << 20  # numbers read at once
_REFUSED = 4


class Columns:
    """The one-dimensional numeric datasets in the root of a user's HDF5 file; made by `open_columns`."""

    def __init__(self, file: Any, path: Path) -> None:
        self._path = path
        hint = "copy the data into the file itself"
        for problem in links_elsewhere(file, soft=False):
            raise InputError(problem, where=str(path), hint=hint)
        datasets = {str(n): item for n in file if isinstance(item := file.get(n), h5py.Dataset)}
        self._data = {n: d for n, d in datasets.items() if d.ndim == 1 and d.dtype.kind in "fiu"}
        for name, data in self._data.items():
            if problem := kept_elsewhere(data):
                raise InputError(f"/{name} {problem}", where=str(path), hint=hint)
        self.columns = list(self._data)
        self.ignored = [name for name in datasets if name not in self._data]
        self.length = 0

    def read(self, name: str, part: slice) -> FloatArray:
        """A piece of a column."""
        with reading(self._path, f"/{name}"):
            return np.asarray(self._data[name][part], dtype=np.float64)

    def _measure(self, key: str) -> None:
        self.length = len(self._data[key]) if key in self._data else 0
        for name, data in self._data.items():
            if key in self._data and len(data) != self.length:
                fact = f"/{name} has {len(data):,} values, /{key} {self.length:,}"
                raise InputError(fact, where=str(self._path), hint="all columns of a table are of one length")


@contextlib.contextmanager
def open_columns(path: Path, key: str) -> Iterator[Columns]:
    """Open a user's HDF5 table: a dataset [n] named `key` and others of its length, in the root group.

    Raises
    ------
    InputError : missing, not HDF5, damaged, with data in other files, or with columns of different lengths.
    """
    require_regular_file(path)
    try:
        _try(path, identity_of(path))
    except FileNotFoundError as exc:
        raise InputError("no such file", where=str(path)) from exc
    with _opened(path) as found:
        found._measure(key)
        yield found


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[Columns]:
    try:
        file = h5py.File(path, "r")
    except OSError as exc:
        raise InputError("not a readable HDF5 file (truncated or damaged)", where=str(path)) from exc
    with file:
        with reading(path):
            found = Columns(file, path)
        yield found


@cache
def _try(path: Path, identity: Identity) -> None:
    """Read all columns in a process of its own; `InputError` when it does not come to an end, or to a bad one."""
    seconds = SECONDS + identity[2] / BYTES_PER_SECOND
    command = [sys.executable, "-m", "tedm_cli.files.columns", str(path)]
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=seconds, check=False)
    except subprocess.TimeoutExpired as exc:
        fact = f"cannot be read within {seconds:.0f} s: the file is damaged, or its disk hangs"
        raise InputError(fact, where=str(path), hint="write the table again") from exc
    if done.returncode not in (0, _REFUSED):  # what was refused is refused here as well, with its reason
        why = f"signal {-done.returncode}" if done.returncode < 0 else f"exit code {done.returncode}"
        fact = f"cannot be read, the file is damaged (a process that tried ended with {why})"
        raise InputError(fact, where=str(path), hint="write the table again")


def main() -> None:
    """Read all columns of the file that the command line names."""
    try:
        with _opened(Path(sys.argv[1])) as table:
            for name, data in table._data.items():
                for start in range(0, len(data), _BLOCK):
                    table.read(name, slice(start, start + _BLOCK))
    except InputError:
        sys.exit(_REFUSED)


if __name__ == "__main__":
    main()
