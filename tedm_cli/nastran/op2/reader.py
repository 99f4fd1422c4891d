"""Displacement tables of an OP2: found in one pass over the file, then read one subcase at a time."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.arrays import AnyArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.nastran.op2.fortran_records import BlockReader
from tedm_cli.nastran.op2.walk import ROW_WORDS, Walk, walked
from tedm_cli.nastran.subcase_table import GridMotion, ReadTable, SubcaseTable

_STRUCTURAL_GRID = 1  # grid type in the OP2; 2 marks scalar points


@contextmanager
def open_op2(path: Path) -> Iterator[tuple[list[SubcaseTable], ReadTable]]:
    """Open an OP2: the displacement tables in it, by subcase, and a function that reads one of them.

    Listing them reads their headers alone; a read holds one subcase.

    Raises
    ------
    InputError : missing, truncated or not an OP2, a dialect that is not recognised, no displacements, results of other
        than linear statics, SORT2, complex numbers, superelements, a subcase given twice.
    """
    with walked(path) as (walk, model):
        _check(walk)
        rows = _Rows(model, path)

        def read(table: SubcaseTable) -> GridMotion:
            with walk.damage(model, table):
                return rows.read(table)

        yield sorted(walk.found, key=lambda t: t.subcase), read


def _check(walk: Walk) -> None:
    path, names = walk.path, walk.names
    if not walk.found:
        if walk.temperatures:
            raise InputError(
                f"holds temperatures (heat transfer, subcase {walk.temperatures[0]}) and no displacements",
                where=str(path),
                hint="give the OP2 of the static analysis",
            )
        raise InputError(
            f"holds no displacements (tables: {', '.join(dict.fromkeys(names)) or 'none'})",
            where=str(path),
            hint="the deck needs DISPLACEMENT(PLOT) = ALL and PARAM,POST,-1",
        )
    for subcase, times in Counter(t.subcase for t in walk.found).items():
        if times > 1:
            tables = ", ".join(sorted({t.name for t in walk.found if t.subcase == subcase}))
            raise InputError(f"subcase {subcase} occurs {times} times (table {tables})", where=str(path))


class _Rows:
    """Reads the rows of displacement tables of an open OP2: in one buffer, and ids of grids once where they repeat."""

    def __init__(self, model: Any, path: Path) -> None:
        self._size, self._order, self._path = model.op2_reader.size, model._uendian, path
        self._blocks = BlockReader(model.f, self._order, self._size)
        self._row = np.dtype([("code", f"V{2 * self._size}"), ("motion", f"V{(ROW_WORDS - 2) * self._size}")])
        self._codes: AnyArray = np.zeros((0, 2))
        self._rows: Any = slice(None)
        self._ids: IntArray = np.zeros(0, dtype=np.int64)

    def read(self, table: SubcaseTable) -> GridMotion:
        """The motion of one subcase."""
        data = self._blocks.read(*table.places)
        if not data or len(data) % (ROW_WORDS * self._size):
            fact = f"{len(data)} bytes are no rows of displacements"
            raise InputError(fact, where=f"{self._path}: subcase {table.subcase}")
        whole = np.frombuffer(data, f"{self._order}i{self._size}").reshape(-1, ROW_WORDS)
        if not (np.array_equal(whole[:, 0], self._codes[:, 0]) and np.array_equal(whole[:, 1], self._codes[:, 1])):
            self._codes = whole[:, :2].copy()
            grids = whole[:, 1] == _STRUCTURAL_GRID
            self._rows = slice(None) if grids.all() else grids  # a mask takes several times as long
            self._ids = (whole[self._rows, 0] // 10).astype(np.int64)
        # As bytes [n]: six numbers of eight that are copied one by one take longer than to be made float64.
        motion = np.ascontiguousarray(np.frombuffer(data, self._row)["motion"][self._rows])
        numbers = motion.view(f"{self._order}f{self._size}").reshape(-1, ROW_WORDS - 2)
        return GridMotion(self._ids, numbers.astype(np.float64))
