"""Growth of time and memory with grids and with areas: three sizes each, and the exponents through them."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.scale import CELLS, DECK, RESULTS, STAGES, WRITING_PEERS, measure, row, stages

Cells = tuple[int, int, int]
GRIDS: tuple[Cells, ...] = ((43, 25, 17), CELLS, (97, 57, 39))  # 20,592, 68,445 and 227,360
OF_DECKS: tuple[Cells, ...] = ((27, 17, 11), (43, 25, 17), CELLS)  # 6,048, 20,592 and 68,445
AREAS = (20, 80, 320)
OP2 = ("OP2 written", "OP2 read")


def by_grids(cells: Sequence[Cells] = GRIDS, areas: int = 20) -> Iterator[dict[str, Any]]:
    """All stages without a deck, and their peers, at this number of areas."""
    for one in cells:
        for task, stage, found in stages(areas, one):
            yield row(task, stage, areas, one, found)


def by_areas(areas: Sequence[int] = AREAS, cells: Cells = CELLS) -> Iterator[dict[str, Any]]:
    """All stages, and `ingest` of a deck, at this number of grids."""
    for count in areas:
        for task, stage, found in stages(count, cells, deck=True):
            if task == stage:
                yield row(task, stage, count, cells, found)


def of_decks(cells: Sequence[Cells] = OF_DECKS, areas: int = 20) -> Iterator[dict[str, Any]]:
    """`ingest` of a deck and its OP2, and pyNastran reading the deck alone."""
    for one in cells:
        for task, stage, found in stages(areas, one, deck=True, only=tuple(DECK)):
            yield row(task, stage, areas, one, found)


def of_op2(areas: int = 80, cells: Cells = CELLS) -> Iterator[dict[str, Any]]:
    """An OP2 written and read: by this program, plainly, and by pyNastran."""
    with tempfile.TemporaryDirectory() as name:
        for stage in OP2:
            tasks = [stage, *RESULTS[stage], *(WRITING_PEERS if stage == OP2[0] else ())]
            for task, found in measure(tasks, Path(name), areas, cells).items():
                yield row(task, stage, areas, cells, found)


def exponent(size: Sequence[float], value: Sequence[float]) -> float:
    """Slope of the line through the logarithms, by least squares: value ~ size^slope."""
    return float(np.polyfit(np.log(size), np.log(value), 1)[0])


def per_size(size: Sequence[float], value: Sequence[float]) -> float:
    """Slope of the line through the values, by least squares."""
    return float(np.polyfit(size, value, 1)[0])


def column(rows: Sequence[Mapping[str, Any]], task: str, key: str, size: str) -> tuple[list[float], list[float]]:
    """Sizes and values of one task, by size."""
    found = sorted((one[size], one[key]) for one in rows if one["task"] == task)
    return [pair[0] for pair in found], [pair[1] for pair in found]


def tasks_of(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """The stages of some rows, in their order, without their peers."""
    return list(dict.fromkeys(one["task"] for one in rows if one["task"] == one["stage"] and one["task"] in _ORDER))


_ORDER = (*RESULTS, *DECK, *STAGES)
