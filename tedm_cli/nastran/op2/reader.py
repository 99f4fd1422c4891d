"""Displacement tables of an OP2: found in one pass over the file, then read one subcase at a time."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.errors import InputError
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

        def read(table: SubcaseTable) -> GridMotion:
            with walk.damage(model, table):
                return _read(model, table, path)

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


def _read(model: Any, table: SubcaseTable, path: Path) -> GridMotion:
    reader = model.op2_reader
    size, order = reader.size, model._uendian
    records = []
    for place in table.places:
        reader._goto(place)
        records.append(reader._read_record())
    data = records[0] if len(records) == 1 else b"".join(records)
    if not data or len(data) % (ROW_WORDS * size):
        raise InputError(f"{len(data)} bytes are no rows of displacements", where=f"{path}: subcase {table.subcase}")
    whole = np.frombuffer(data, f"{order}i{size}").reshape(-1, ROW_WORDS)
    real = np.frombuffer(data, f"{order}f{size}").reshape(-1, ROW_WORDS)
    grids: Any = whole[:, 1] == _STRUCTURAL_GRID
    if grids.all():
        grids = slice(None)  # a mask takes several times as long
    return GridMotion((whole[grids, 0] // 10).astype(np.int64), real[grids, 2:].astype(np.float64))
