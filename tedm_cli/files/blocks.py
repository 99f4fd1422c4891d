"""Numeric datasets of an open file that stages fill and read piece by piece."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tedm_cli.arrays import AnyArray, FloatArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.files.held_file import Sink

BLOCK_NODES = 16384  # grids in a chunk of the files
_AT_ONCE = 4 * BLOCK_NODES  # grids of one area that a stage holds: few calls, and still in a processor's cache


class PrecisionLossError(Exception):
    """A number that single precision does not hold exactly was to be written to a dataset in single precision."""


class Allocated:
    """An empty dataset that is filled where it is indexed."""

    def __init__(self, dataset: Any, sink: Sink, check: Callable[[AnyArray], None]) -> None:
        self._dataset, self._check = dataset, check
        self._single = dataset.dtype == np.float32
        self._sink = sink

    def __setitem__(self, index: Any, value: Any) -> None:
        """Write a piece.

        Raises
        ------
        PrecisionLossError : the dataset is in single precision and cannot hold a value as it is.
        PhysicsError : a number is not finite where the contract has finite ones.
        """
        value = np.asarray(value)
        self._check(value)
        widened = self._single and value.dtype != np.float32
        self._dataset[index] = narrowed(value) if widened else value
        self._sink.check()


def narrowed(value: AnyArray) -> NDArray[np.float32]:
    """`value` in single precision; `PrecisionLossError` when a number changes by that."""
    with np.errstate(over="ignore"):  # what overflows has changed
        narrow = value.astype(np.float32)
    if not np.array_equal(narrow, value):
        raise PrecisionLossError
    return narrow


def node_blocks(n_nodes: int, length: int = _AT_ONCE) -> Iterator[slice]:
    """The grids in order, `length` (whole chunks) at a time."""
    for start in range(0, n_nodes, length):
        yield slice(start, min(start + length, n_nodes))


class Blocks:
    """A numeric dataset that is read where it is indexed, as float64, int64 or complex128 whatever the file holds."""

    def __init__(self, dataset: Any, file: Path) -> None:
        self._dataset = dataset
        self._file = file

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(self._dataset.shape)

    @property
    def single(self) -> bool:
        """Whether the file holds it in single precision."""
        return bool(self._dataset.dtype == np.float32)

    def __getitem__(self, index: Any) -> AnyArray:
        data = self.held(index)
        return data.astype(np.float64) if data.dtype == np.float32 else data

    def held(self, index: Any) -> AnyArray:
        """A piece in the precision of the file, to be passed on as it is."""
        with reading(self._file, self._dataset.name):
            return np.asarray(self._dataset[index])

    def read_into(self, out: AnyArray, index: Any) -> None:
        """Fill `out`, contiguous and in the precision of the file (`empty`), with a piece of its shape."""
        with reading(self._file, self._dataset.name):
            self._dataset.read_direct(out, index)

    def empty(self, shape: tuple[int, ...]) -> AnyArray:
        """An array for `read_into`, in the precision of the file."""
        return np.empty(shape, self._dataset.dtype)


class SomeNodes:
    """Some grids of an array that comes in `node_blocks`, in an order of their own."""

    def __init__(self, rows: IntArray) -> None:
        self._order = np.argsort(rows, kind="stable")
        self._sorted = rows[self._order]
        chunk = self._sorted // BLOCK_NODES
        cuts = [*np.flatnonzero(np.diff(chunk, prepend=-1)).tolist(), len(rows)]
        self._runs = [slice(*ends) for ends in itertools.pairwise(cuts)]

    def within(self, block: slice) -> tuple[IntArray, IntArray]:
        """Which of them a block holds, and where in the block they are."""
        first, last = np.searchsorted(self._sorted, (block.start, block.stop))
        return self._order[first:last], self._sorted[first:last] - block.start

    def read(self, dataset: Blocks, area: int) -> FloatArray:
        """Their rows [n,3] of one area of a dataset [k,N,3]; of each chunk no more than from the first to the last."""
        out = np.empty((len(self._order), 3))
        for run in self._runs:
            rows = self._sorted[run]
            first = int(rows[0])
            out[self._order[run]] = dataset[area, first : int(rows[-1]) + 1][rows - first]
        return out


@contextlib.contextmanager
def reading(file: Path, path: str = "", hint: str = "rebuild it") -> Iterator[None]:
    """HDF5's complaints about a damaged file as an `InputError` that names it, lest a writer take them for its own."""
    try:
        yield
    except (OSError, RuntimeError, KeyError, ValueError, TypeError) as exc:
        fact = f"{path}: " * bool(path) + f"cannot be read, the file is damaged ({exc})"
        raise InputError(fact, where=str(file), hint=hint) from exc
