"""Users' tables in HDF5: one-dimensional datasets in the root group, read in pieces, once by a process of its own.

Tables that users read again are written in the same form.
"""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.files.blocks import reading
from tedm_cli.files.elsewhere import kept_elsewhere, links_elsewhere
from tedm_cli.files.held_file import HeldFile
from tedm_cli.files.seal import Identity, identity_of
from tedm_cli.files.store import replacing
from tedm_cli.files.trial import REFUSED, trial
from tedm_cli.regular_file import require_regular_file

HDF5_SUFFIXES = (".h5", ".hdf5", ".hdf")
_BLOCK = 1 << 20  # numbers read at once
_CHUNK = 1 << 13  # numbers of a piece of the file


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
def writing_columns(path: Path, names: Sequence[str]) -> Iterator[Callable[[FloatArray], None]]:
    """A function that takes the next values [columns, T] of a table, which is there when all is done.

    Raises
    ------
    InputError : it cannot be written.
    """
    with replacing(path) as temporary, contextlib.closing(HeldFile(temporary)) as sink:
        with h5py.File(sink, "w", libver="v110") as file:
            how = {"maxshape": (None,), "chunks": (_CHUNK,), "fletcher32": True, "track_times": False}
            data = [file.create_dataset(name, (0,), "f8", **how) for name in names]

            def write(values: FloatArray) -> None:
                first = len(data[0])
                for one, row in zip(data, values, strict=True):
                    one.resize((first + len(row),))
                    one[first:] = row
                    sink.check()

            yield write
        sink.check()


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
    trial("tedm_cli.files.columns", path, size=identity[2], hint="write the table again")


def main() -> None:
    """Read all columns of the file that the command line names."""
    try:
        with _opened(Path(sys.argv[1])) as table:
            for name, data in table._data.items():
                for start in range(0, len(data), _BLOCK):
                    table.read(name, slice(start, start + _BLOCK))
    except InputError:
        sys.exit(REFUSED)


if __name__ == "__main__":
    main()
