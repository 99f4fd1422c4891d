"""Temperatures over time of an ESATAN-TMS file, as a table of `time_s` and a column for each node."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from tedm_cli.files.tmd import TmdTemperatures, open_tmd_temperatures
from tedm_cli.quantities import CELSIUS, TEMPERATURE, TIME_STAMP, Quantity
from tedm_cli.tables.wide_table import BLOCK_NUMBERS, Block, Quantities, WideTable, checked

TMD_SUFFIX = ".tmd"
"""Of the names of such files, in any case of letters."""


class TmdTable:
    """An open file; its temperatures are as they stand there, in degrees Celsius or kelvins."""

    def __init__(self, path: Path, source: TmdTemperatures, of_values: Quantity) -> None:
        self.path = path
        self.columns = source.node
        self._source = source
        self._quantities: Quantities = (TIME_STAMP, of_values, {})

    def place(self, number: int) -> str:
        return f"{self.path}: time {number}"

    def blocks(self, rows: int = 0) -> Iterator[Block]:
        names = ["time_s", *self.columns]
        rows = rows or max(1, BLOCK_NUMBERS // len(names))
        for start in range(0, len(self._source.time_s), rows):
            part = slice(start, min(start + rows, len(self._source.time_s)))
            numbers = np.column_stack([self._source.time_s[part], self._source.read(part)])
            yield checked(self, self._quantities, names, 0, numbers, np.arange(part.start + 1, part.stop + 1))


@contextlib.contextmanager
def open_tmd(path: Path, unit_of: Callable[[float | None], str]) -> Iterator[tuple[WideTable, str]]:
    """The open table, and its unit, K or degC, which `unit_of` tells from the offset of the file.

    Raises
    ------
    InputError : as `open_tmd_temperatures`, and what `unit_of` refuses.
    """
    with open_tmd_temperatures(path) as source:
        unit = unit_of(source.offset_K)
        yield TmdTable(path, source, CELSIUS if unit == "degC" else TEMPERATURE), unit
