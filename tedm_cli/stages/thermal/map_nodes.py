"""Which elements each thermal node is, as the configuration says it."""

from __future__ import annotations

import difflib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree

from tedm_cli.areas.selection import Selector
from tedm_cli.arrays import BoolArray, IntArray
from tedm_cli.config.thermal.map import MapTable
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.mapping.averages import NONE
from tedm_cli.nastran.geometry import id_list
from tedm_cli.stages.thermal.map_files import read_node_elements, read_places
from tedm_cli.stages.thermal.map_model import FiniteElements


@dataclass(frozen=True, eq=False)
class NearestReport:
    """Of a node with elements by their nearness: how many, and their mean and largest distance (m) from its place."""

    node: str
    elements: int
    mean_m: float
    largest_m: float


@dataclass(frozen=True, eq=False)
class Association:
    """The elements of n thermal nodes.

    node : [n] names. place_node : [M], the node of each place of each element, or `NONE`; conducting elements alone.
    nearest : of the nodes that have elements by nearness. beyond : elements that are too far from all.
    """

    node: list[str]
    place_node: IntArray
    nearest: list[NearestReport] = field(default_factory=list)
    beyond: int = 0
    notes: list[str] = field(default_factory=list)


def associate(fem: FiniteElements, table: MapTable, conducting: BoolArray, where: Path) -> Association:
    """The nodes of elements, selections, nearness or areas.

    Parameters
    ----------
    conducting : [E]. where : the file of the table.

    Raises
    ------
    InputError : what is wrong with the tables that it names; elements that are not there.
    ConfigError : selections that meet nothing, an element in two nodes, a node without conducting elements.
    """
    work = _Work(fem, conducting, where)
    if table.areas:
        return work.of_areas(set(name.upper() for name in table.unmapped))
    if table.elements is not None:
        work.listed(fem.project.beside(where, table.elements))
    for number, node in enumerate(table.nodes):
        at, before = f"map.node[{number}]", len(work.problems)
        selector = Selector(fem.members, at, work.problems, work.notes)
        met = [
            selector.selection(s, at if k == 0 else f"{at}.also[{k - 1}]", node.name).elements
            for k, s in enumerate(node.selections())
        ]
        if len(work.problems) == before:
            work.add(node.name, np.flatnonzero(np.any(met, axis=0)), at)
    work.raise_problems()
    if table.nearest is not None:
        return work.near(fem.project.beside(where, table.nearest), table.nearest_within_m)
    return work.result()


class _Work:
    """The association as it is made."""

    def __init__(self, fem: FiniteElements, conducting: BoolArray, where: Path) -> None:
        self.fem, self.conducting, self.where = fem, conducting, where
        self.ids = fem.geometry.elements.id
        self.node: list[str] = []
        self.element_node = np.full(len(self.ids), NONE)
        self.problems: list[tuple[str, str]] = []
        self.notes: list[str] = []

    def raise_problems(self) -> None:
        if self.problems:
            raise ConfigError(self.problems, where=str(self.where))

    def result(self, nearest: list[NearestReport] | None = None, beyond: int = 0) -> Association:
        place_node = self.element_node[self.fem.volumes.element]
        return Association(self.node, place_node, nearest or [], beyond, self.notes)

    def listed(self, path: Path) -> None:
        for name, wanted in read_node_elements(path).items():
            ids = np.array(wanted, dtype=np.int64)
            rows = np.searchsorted(self.ids, ids).clip(max=len(self.ids) - 1)
            absent = ids[self.ids[rows] != ids]
            if absent.size:
                fact = f"node {name!r} names {absent.size} elements that the model lacks: {id_list(absent)}"
                raise InputError(fact, where=str(path), hint=f"the model is {self.fem.source}")
            self.add(name, np.sort(rows), "map.elements")
        self.raise_problems()

    def add(self, name: str, rows: IntArray, at: str) -> None:
        """A node of the elements in these rows, or more of them where it is there already."""
        same = next((k for k, other in enumerate(self.node) if other.upper() == name.upper()), None)
        if same is not None and self.node[same] != name:
            self.problems.append((at, f"node {name!r} is also spelled {self.node[same]!r}"))
            return
        number = len(self.node) if same is None else same
        if same is None:
            self.node.append(name)
        mine = rows[self.conducting[rows]]
        bare = rows[~self.conducting[rows]]
        if not mine.size:
            what = f": {self._cards(bare)} do not conduct" if bare.size else ""
            self.problems.append((at, f"node {name!r} has no element{what}"))
        elif bare.size:
            self.notes.append(f"node {name}: elements that do not conduct are left out: {self._cards(bare)}")
        owner = self.element_node[mine]
        for other in np.unique(owner[(owner != NONE) & (owner != number)]):
            both = self.ids[mine[owner == other]]
            fact = f"element{'' if both.size == 1 else 's'} {id_list(both)} of node {name!r}"
            self.problems.append(
                (at, f"{fact} {'is' if both.size == 1 else 'are'} of node {self.node[other]!r} already")
            )
        self.element_node[mine[owner == NONE]] = number

    def _cards(self, rows: IntArray) -> str:
        """`CBUSH 5, 6; PLOTEL 7`."""
        cards = np.array(self.fem.geometry.elements.type, dtype=str)[rows]
        return "; ".join(f"{c} {id_list(self.ids[rows[cards == c]], 4)}" for c in np.unique(cards).tolist())

    def near(self, path: Path, within_m: float | None) -> Association:
        names, places = read_places(path)
        known = {name.upper(): name for name in self.node}
        if clash := next((n for n in names if known.get(n.upper(), n) != n), ""):
            raise InputError(f"node {clash!r} is also spelled {known[clash.upper()]!r}", where=str(path))
        left = np.flatnonzero(self.conducting & (self.element_node == NONE))
        distance, at = KDTree(places).query(self.fem.geometry.centres(left))
        close = distance <= (np.inf if within_m is None else within_m)
        reports = []
        for number, name in enumerate(names):
            mine = close & (at == number)
            if not mine.any():
                if name not in self.node:
                    self.problems.append(("map.nearest", f"node {name!r} is the nearest of no element"))
                continue
            if name not in self.node:
                self.node.append(name)
            self.element_node[left[mine]] = self.node.index(name)
            reports.append(
                NearestReport(name, int(mine.sum()), float(distance[mine].mean()), float(distance[mine].max()))
            )
        if self.problems:
            hint = "is its place in m and in the basic frame? a node without a place is passed over"
            raise ConfigError(self.problems, where=str(self.where), hint=hint)
        return self.result(reports, int((~close).sum()))

    def of_areas(self, unmapped: set[str]) -> Association:
        """Areas as nodes: of the elements that they select as such, else of what of the elements is at their grids."""
        place, names, of = self.fem.place_area(), list(self.fem.areas), self.fem.volumes
        place_node = np.full(len(place), NONE)
        for number, name in enumerate(names):
            if name.upper() in unmapped:
                continue
            mine = (place == number) & self.conducting[of.element]
            if not mine.any():
                self.problems.append(
                    ("map.areas", f"area {name!r} has no conducting element; map.unmapped may name it")
                )
                continue
            if not of.volume[mine].sum() > 0.0:
                fact = f"area {name!r} has no volume: its grids are corners of quadratic elements alone"
                self.problems.append(("map.areas", f"{fact}; give its elements by [[map.node]] tables"))
                continue
            place_node[mine] = len(self.node)
            self.node.append(name)
        self.raise_problems()
        return Association(self.node, place_node)


def near_name(name: str, known: list[str]) -> str:
    """`; did you mean X?`, where a known name is like it."""
    folded = {k.casefold(): k for k in known}
    near = difflib.get_close_matches(name.casefold(), folded, n=1, cutoff=0.6)
    return f"; did you mean {folded[near[0]]}?" if near else ""
