"""How maps over thermal areas are shared out to figures that a page can hold. Without matplotlib: names hang on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from tedm_cli.arrays import IntArray
from tedm_cli.figures.drawing.spec import PAGE_HEIGHT, PAGE_WIDTH
from tedm_cli.noise.areas import AreaTable
from tedm_cli.results.areas import AreaMap, by_group

#: Inches of a map: a row; a cell, without and with its number; what stands above, between and beside panels.
ROW, CELL, NUMBER, HEAD, GAP, BESIDE = 0.145, 0.14, 0.53, 1.02, 0.22, 0.2
SHARES = 4  # read-outs whose shares a page holds
CHARACTER = 0.078  # inches of a character of the smallest type, capitals as names of areas mostly are
_SAME = 1e-9  # of the largest entry of a map: columns that are told once

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class MapPage:
    """One figure: panels side by side over areas, whose rows are shared out to `blocks` beside each other."""

    maps: tuple[AreaMap, ...]
    blocks: tuple[IntArray, ...]


def map_pages(maps: Sequence[AreaMap], areas: AreaTable, cell: float) -> list[MapPage]:
    """Figures that hold all panels and areas, group by group, with cells so many inches wide.

    All panels share a figure where they fit beside each other; areas that are too many for one go on in a second block
    or in the next figure.
    """
    names = BESIDE + CHARACTER * max(map(len, areas.name))

    def wide(panels: Sequence[AreaMap], blocks: int) -> float:
        return blocks * (names + sum(cell * len(m.labels) + GAP for m in panels)) + GAP / 2

    pages = []
    for panels in [tuple(maps)] if wide(maps, 1) <= PAGE_WIDTH else [(m,) for m in maps]:
        foot = 0.3 + CHARACTER * max(len(label) for m in panels for label in m.labels)
        parts = _parts(areas, max(8, int((PAGE_HEIGHT - HEAD - foot) / ROW)))
        blocks = 2 if wide(panels, 2) <= PAGE_WIDTH else 1
        pages += [MapPage(panels, tuple(parts[i : i + blocks])) for i in range(0, len(parts), blocks)]
    return pages


def _parts(areas: AreaTable, most: int) -> list[IntArray]:
    """The areas group by group in as few parts of about the same length as have at most so many lines.

    A part ends with a group where one ends nearby.
    """
    order = by_group(areas)
    groups = areas.group_by_unit[order]
    edges = np.flatnonzero(groups[1:] != groups[:-1]) + 1
    for count in range(1, len(order) + 1):
        even = np.rint(np.arange(1, count) * len(order) / count).astype(np.int64)
        snapped = [edges[np.abs(edges - e).argmin()] if edges.size else e for e in even]
        nearby = [int(s) if abs(s - e) <= most // 6 else int(e) for s, e in zip(snapped, even, strict=True)]
        for ends in (nearby, even.tolist()):
            parts = [part for part in np.split(order, sorted(set(ends))) if part.size]
            if all(line_count(areas, part) <= most for part in parts):
                return parts
    raise AssertionError("a part of one area has two lines")


def line_count(areas: AreaTable, rows: IntArray) -> int:
    """Lines of some areas in a row, each of whose groups begins with a line of its own."""
    groups = areas.group_by_unit[rows]
    return len(rows) + 1 + int((groups[1:] != groups[:-1]).sum())


def without_twins(panel: AreaMap) -> AreaMap:
    """A map whose outputs that are equal in every area, as redundant read-outs are, are one that bears all names."""
    scale = float(np.abs(panel.value).max())
    family: dict[int, list[int]] = {}
    for row, value in enumerate(panel.value):
        alike = (first for first in family if np.allclose(panel.value[first], value, rtol=0.0, atol=_SAME * scale))
        family.setdefault(next(alike, row), []).append(row)
    labels = [", ".join(panel.labels[i] for i in members) for members in family.values()]
    return replace(panel, labels=labels, value=panel.value[list(family)])


@dataclass(frozen=True)
class Part:
    """What the name of a figure and its caption say where there are several of its kind."""

    suffix: str
    words: str


def in_parts(items: Sequence[T]) -> list[tuple[Part, T]]:
    """Figures of one kind, numbered where there is more than one."""
    if len(items) == 1:
        return [(Part("", ""), items[0])]
    return [(Part(f"_{n}", f" (part {n} of {len(items)})"), item) for n, item in enumerate(items, start=1)]
