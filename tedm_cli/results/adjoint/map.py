"""What adjoint.h5 says of single grids and elements, and where these are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.adjoint.places import Place, places_of
from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.contracts import ADJOINT, UNIT_LOADS
from tedm_cli.errors import InputError
from tedm_cli.files.store import Reader
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.differences import terms
from tedm_cli.results.areas import read_areas
from tedm_cli.results.unit_loads import area_of_elements, area_of_grids


@dataclass(frozen=True, eq=False)
class OutputMap:
    """What 1 K does to one output: of each grid, where elements follow their grids, and of each whole element.

    unit : of both, per kelvin. grid_id, grid : [N]. element_id, whole : [E]. volume : [E], m³.
    """

    output: str
    unit: str
    grid_id: IntArray
    grid: FloatArray
    element_id: IntArray
    whole: FloatArray
    volume: FloatArray

    @property
    def density(self) -> FloatArray:
        """Sensitivity per volume [E], per K and m³; NaN of what has no volume. Its integral is the uniform load."""
        there = self.volume > 0.0
        return np.divide(self.whole, self.volume, out=np.full(len(self.whole), np.nan), where=there)


@dataclass(frozen=True, eq=False)
class MappedModel:
    """The mesh that maps are of, by the elements of adjoint.h5.

    areas : the thermal areas. grid_area : [N], row of the area of each grid, -1: none. position : [N, 3], m.
    element_area : [E], the area whose load names the element, else that of most of its grids. centre : [E, 3], m.
    offset, node : [E + 1] and [M], rows of the grids of each element. card : [E].
    """

    areas: AreaTable
    grid_area: IntArray
    position: FloatArray
    element_area: IntArray
    centre: FloatArray
    offset: IntArray
    node: IntArray
    card: list[str]

    def places(self, output: OutputMap) -> list[Place]:
        """Where an output feels temperatures, the largest shares first."""
        return places_of(output.whole, output.volume, self.element_area, self.centre, self.offset, self.node)

    def area_name(self, row: int) -> str:
        """Name of an area by its row, `none` of -1."""
        return str(self.areas.name[row]) if row >= 0 else "none"


def has_map(adjoint: Reader, label: str) -> bool:
    """Whether an output, or a difference of two, is in the adjoint."""
    if adjoint.has(ADJOINT.REFUSAL):
        return False
    known = adjoint.strings(ADJOINT.ROW_LABEL)
    return all(name in known for name in _labels(adjoint, label))


def read_map(adjoint: Reader, label: str) -> OutputMap:
    """The map of an output that `has_map` finds."""
    known, units = adjoint.strings(ADJOINT.ROW_LABEL), adjoint.strings(ADJOINT.ROW_UNIT)
    rows = [known.index(name) for name in _labels(adjoint, label)]

    def read(path: str) -> FloatArray:
        first, *other = (np.asarray(adjoint.dataset(path)[row], dtype=np.float64) for row in rows)
        return first - other[0] if other else first

    return OutputMap(
        output=label,
        unit=units[rows[0]],
        grid_id=adjoint.array(ADJOINT.GRID_ID),
        grid=read(ADJOINT.S),
        element_id=adjoint.array(ADJOINT.MAP_ELEMENT),
        whole=read(ADJOINT.MAP_S),
        volume=adjoint.array(ADJOINT.MAP_VOLUME),
    )


def _labels(adjoint: Reader, label: str) -> tuple[str, ...]:
    """The label itself, or those of the two that it is the difference of."""
    pair = terms(label)
    return (label,) if pair is None or label in adjoint.strings(ADJOINT.ROW_LABEL) else pair


def element_rows(adjoint: Reader, unit: Reader) -> IntArray:
    """Rows in unit_loads.h5 of the elements of adjoint.h5.

    Raises
    ------
    InputError : unit_loads.h5 does not have them.
    """
    ids, wanted = unit.array(UNIT_LOADS.ELEMENT_ID), adjoint.array(ADJOINT.MAP_ELEMENT)
    rows = np.searchsorted(ids, wanted)
    if not np.isin(wanted, ids).all():
        hint = f"rebuild it with `{adjoint.kind.made_by}`"
        raise InputError(f"has elements that {unit.path.name} does not hold", where=str(adjoint.path), hint=hint)
    return np.asarray(rows, dtype=np.int64)


def read_mapped_model(adjoint: Reader, unit: Reader) -> MappedModel:
    """The mesh of unit_loads.h5, as far as it is in the adjoint. Raises as `element_rows`."""
    rows = element_rows(adjoint, unit)
    offset, node = unit.array(UNIT_LOADS.ELEMENT_NODE_OFFSET), unit.array(UNIT_LOADS.ELEMENT_NODE_INDEX)
    count = np.diff(offset)
    kept = np.zeros(len(count), dtype=bool)
    kept[rows] = True
    node, count = node[np.repeat(kept, count)], count[rows]
    offset = np.concatenate([[0], np.cumsum(count)])
    position, grid_area = unit.array(UNIT_LOADS.GRID_POSITION), area_of_grids(unit)
    own = area_of_elements(unit)[rows]
    cards = unit.strings(UNIT_LOADS.ELEMENT_TYPE)
    return MappedModel(
        areas=read_areas(unit),
        grid_area=grid_area,
        position=position,
        element_area=np.where(own >= 0, own, _of_most(grid_area[node], count)),
        centre=np.add.reduceat(position[node], offset[:-1], axis=0) / count[:, None],
        offset=offset,
        node=node,
        card=[cards[row] for row in rows],
    )


def _of_most(label: IntArray, count: IntArray) -> IntArray:
    """The label that most grids of each element have, the lowest of several; `count` [E] of them."""
    element = np.repeat(np.arange(len(count)), count)
    pair, votes = np.unique(np.column_stack([element, label]), axis=0, return_counts=True)
    order = np.lexsort((pair[:, 1], -votes, pair[:, 0]))
    first = np.flatnonzero(np.diff(pair[order, 0], prepend=-1))
    return np.asarray(pair[order[first], 1])
