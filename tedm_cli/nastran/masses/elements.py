"""Elements of a model and their masses as plain arrays, computed for all elements of a card at a time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, overload

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.errors import InputError, PhysicsError
from tedm_cli.fem.measure import blocks, contents
from tedm_cli.fem.shapes import CARDS, PYRAMID_AS_BRICK, Shape, corner_count, shape_of
from tedm_cli.nastran.bulk.columns import ElementColumns, columns_of
from tedm_cli.nastran.masses.lines import line_spread
from tedm_cli.nastran.masses.midside import check_midside, check_partial
from tedm_cli.nastran.masses.nonstructural import Measured, nonstructural
from tedm_cli.nastran.masses.plates import Plates, plate_spread
from tedm_cli.nastran.masses.solids import solid_spread
from tedm_cli.nastran.masses.spread import Spread, ToBasic, density_of

# Springs, dampers, gaps, plots and heat: Nastran gives them no mass (a CBUSH has that of its property).
_MASSLESS = {
    *("CELAS1", "CELAS2", "CELAS3", "CELAS4", "CDAMP1", "CDAMP2", "CDAMP3", "CDAMP4", "CDAMP5", "CVISC", "CGAP"),
    *("CBUSH1D", "CBUSH2D", "CFAST", "CWELD", "CSEAM", "GENEL", "PLOTEL", "CHBDYG", "CHBDYE", "CHBDYP"),
}


_MOST_NODES = 1 << 20  # more than an element has


@dataclass(frozen=True)
class Elements:
    """Elements of a model; ragged connectivity as offsets [E+1] and rows of the grid table.

    mass_kg : [E], with non-structural mass; added_kg : [E], what NSM sets add of it.
    lever : [M, 3], offset of the element's mass from each of its nodes, basic frame, m.
    weight : [M], density of the mass at each of its nodes over the mean of its nodes.
    structural_kg, structural_lever, structural_weight : the same three of the mass that the materials have, all but
        non-structural mass and that of springs.
    density, expansion : [E], of the material; NaN where the property has no single one. section : [E], m, m² or 0.
    partial : ids of elements that lack some of their midside nodes; only their corners are kept.
    """

    id: IntArray
    type: list[str]
    property_id: IntArray
    node_offset: IntArray
    node_index: IntArray
    mass_kg: FloatArray
    added_kg: FloatArray
    density: FloatArray
    expansion: FloatArray
    section: FloatArray
    lever: FloatArray
    weight: FloatArray
    structural_kg: FloatArray
    structural_lever: FloatArray
    structural_weight: FloatArray
    partial: list[int]


@dataclass(frozen=True)
class _Cards:
    """The E elements of a model in ascending order of their ids, before anything is known of their masses.

    columns : as on the cards; model : cross-referenced, which has the cards and properties.
    node_offset, node_index, partial : as in `Elements`; where : the deck, for messages.
    """

    model: Any
    columns: ElementColumns
    node_offset: IntArray
    node_index: IntArray
    partial: list[int]
    where: str

    @property
    def own(self) -> dict[int, Any]:
        """Elements with an object of their own, by id; the others are solids and plates on one line."""
        return columns_of(self.model).element_cards


@dataclass(frozen=True)
class _Group:
    """Elements of one card with one number of nodes: places in the order of the model, rows of the grids."""

    card: str
    place: IntArray
    rows: IntArray
    spread: Spread | None
    shape: Shape | None


class _Members(Sequence[Any]):
    """Cards of some elements, each found when it is asked for."""

    def __init__(self, model: Any, ids: IntArray) -> None:
        self._model, self._ids = model, ids

    @overload
    def __getitem__(self, row: int) -> Any: ...
    @overload
    def __getitem__(self, row: slice) -> Sequence[Any]: ...
    def __getitem__(self, row: int | slice) -> Any:
        if isinstance(row, slice):
            return _Members(self._model, self._ids[row])
        return self._model.elements[int(self._ids[row])]

    def __len__(self) -> int:
        return len(self._ids)


def model_elements(
    model: Any,
    position: FloatArray,
    rows: Callable[[IntArray, str], IntArray],
    to_basic: ToBasic,
    factor: float,
    where: str,
) -> Elements:
    """Masses of the elements of a cross-referenced model whose grids are at `position` [N, 3].

    Parameters
    ----------
    rows : rows of the grid table of grid ids, with what names them.
    to_basic : vector in the displacement frame of a grid, by its id, to the basic frame.
    factor : PARAM,WTMASS.

    Raises
    ------
    InputError : an element, a property or an offset of a kind that is not read; a midside node far from its edge.
    PhysicsError : a solid that is tangled.
    """
    if getattr(model, "pval", None):
        raise InputError("p-elements (PVAL) are not read", where=where)
    cards = _cards(model, rows, where)
    check_partial([model.elements[i] for i in cards.partial], position, rows, where)
    return _integrated(cards, position, _groups(cards, position, to_basic), factor)


def _cards(model: Any, rows: Callable[[IntArray, str], IntArray], where: str) -> _Cards:
    columns = columns_of(model).element
    offset, node = columns.without(model.spoints)
    counts, partial = np.diff(offset), []
    kept = np.ones(len(node), dtype=bool)
    for kind, count in (divmod(key, _MOST_NODES) for key in np.unique(_MOST_NODES * columns.kind.astype(int) + counts)):
        card = str(columns.cards[kind])
        least = corner_count(card) if card != "CPYRAM" else 5
        if least is not None and count != least and shape_of(card, count) is None:
            places = np.flatnonzero((columns.kind == kind) & (counts == count))
            if card != "CPYRAM" or count != 13:
                partial += columns.id[places].tolist()
            kept[offset[places][:, None] + np.arange(least, count)] = False
    if not kept.all():
        offset, node = np.concatenate([[0], np.cumsum(kept)])[offset], node[kept]
    return _Cards(model, columns, offset, rows(node, "an element"), sorted(partial), where)


def _groups(cards: _Cards, position: FloatArray, to_basic: ToBasic) -> list[_Group]:
    """The elements by card and number of nodes, each with the spread of its mass."""
    out, where, columns = [], cards.where, cards.columns
    counts = np.diff(cards.node_offset)
    kinds, inverse = np.unique(_MOST_NODES * columns.kind.astype(np.int64) + counts, return_inverse=True)
    named = [(str(columns.cards[key // _MOST_NODES]), key % _MOST_NODES) for key in kinds.tolist()]
    for number in sorted(range(len(named)), key=lambda k: f"{named[k][0]}:{named[k][1]}"):
        card, count = named[number]
        place = np.flatnonzero(inverse == number)
        members = _Members(cards.model, columns.id[place])
        at = cards.node_index[cards.node_offset[place][:, None] + np.arange(count)]
        shape = shape_of(card, count)
        if shape is None and card == "CPYRAM":
            at, shape = at[:, PYRAMID_AS_BRICK], CARDS["CHEXA"][0]
        if shape is not None and shape.edges:
            for part in blocks(len(at)):
                check_midside(members[part], shape, position[at[part]], where)
        spread: Spread | None
        if shape is None:
            if card not in _MASSLESS and card != "CBUSH":
                raise InputError(
                    f"{card} {columns.id[place[0]]}: elements of this kind are not read",
                    where=where,
                    hint="leave them out, or model them with solids, plates, bars and concentrated masses",
                )
            spread = None
        elif shape.dimension == 3:
            spread = solid_spread(columns.property_id[place], cards.model.properties, shape.nodes, where)
        elif shape.dimension == 2:
            spread = plate_spread(_plates(cards, place), shape, position[at], where)
        else:
            spread = line_spread(members, position[at], to_basic, where)
        out.append(_Group(card, place, at, spread, shape))
    return out


def _plates(cards: _Cards, place: IntArray) -> Plates:
    """Plates in these places of the order of the model."""
    ids, own = cards.columns.id[place], cards.own
    return Plates(
        cards.columns.property_id[place],
        cards.model.properties,
        columns_of(cards.model).plate_offsets(ids),
        {row: own[int(ids[row])] for row in np.flatnonzero(np.isin(ids, list(own))).tolist()},
        lambda row: f"{cards.columns.cards[cards.columns.kind[place[row]]]} {ids[row]}",
    )


def _contents(
    shape: Shape, nodes: IntArray, position: FloatArray, axis: FloatArray, density: FloatArray
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """As `contents`, of elements with these rows of grids [E, n] and lines to what is measured [E, n, 3].

    The places of the nodes are held of one block of elements at a time.
    """
    size, content, tangled = np.zeros(len(nodes)), np.zeros(len(nodes)), np.zeros(len(nodes), dtype=bool)
    for part in blocks(len(nodes)):
        size[part], content[part], tangled[part] = contents(
            shape, position[nodes[part]] + axis[part], np.ascontiguousarray(density[part])
        )
    return size, content, tangled


def _integrated(cards: _Cards, position: FloatArray, groups: list[_Group], factor: float) -> Elements:
    """The masses of the groups, integrated over their elements and put into the order of the model."""
    columns = cards.columns
    count = len(columns.id)
    measure, mass, structural, section = (np.zeros(count) for _ in range(4))
    for group in groups:
        if group.spread is not None and group.shape is not None:
            s = group.spread
            whole = s.structural + s.nonstructural if s.nonstructural.any() else s.structural
            measure[group.place], mass[group.place], tangled = _contents(
                group.shape, group.rows, position, s.axis, whole
            )
            structural[group.place] = mass[group.place]
            if s.nonstructural.any():
                structural[group.place] = _contents(group.shape, group.rows, position, s.axis, s.structural)[1]
            bad = group.place[tangled & (mass[group.place] != 0.0)]
            if bad.size:
                raise PhysicsError(
                    f"{bad.size} {group.card} with a Jacobian that changes its sign: {columns.id[bad[0]]}",
                    where=cards.where,
                    hint="are the grids of the card, and its lines, in order?",
                )
    property_id = np.maximum(columns.property_id, 0)  # pyNastran gives CONROD a negative one
    names = columns.cards.tolist()
    card = [names[kind] for kind in columns.kind.tolist()]
    added = nonstructural(
        cards.model, Measured(columns.id, card, property_id, lambda: _property_types(cards), measure), cards.where
    )
    mass += added * measure
    lever, weight = np.zeros((len(cards.node_index), 3)), np.ones(len(cards.node_index))
    structural_lever, structural_weight = np.zeros_like(lever), np.ones_like(weight)
    for group in groups:
        place, shape = group.place, group.shape
        if group.spread is None or shape is None:
            own = [cards.own[i] for i in columns.id[place].tolist()]
            mass[place] = [float(getattr(getattr(e, "pid_ref", None), "mass", None) or 0.0) for e in own]
            continue
        section[place] = group.spread.section
        if group.card == "CPYRAM" or not group.spread.is_uneven:
            continue
        for part in blocks(len(place)):
            s, at = group.spread.part(part), place[part]
            loads = s.nonstructural + added[at][:, None]
            whole = s.structural + loads
            with np.errstate(divide="ignore", invalid="ignore"):
                mixed = (
                    s.structural[..., None] * s.structural_lever + loads[..., None] * s.nonstructural_lever
                ) / whole[..., None]
            to = cards.node_offset[at][:, None] + np.arange(shape.nodes)
            # where all of the mass is at one place, that place to the last digit
            same = (s.structural_lever == s.nonstructural_lever).all(axis=2) | (loads == 0.0)
            lever[to] = np.where(same[..., None], s.structural_lever, np.nan_to_num(mixed))
            structural_lever[to] = s.structural_lever
            for density_at, relative in ((whole, weight), (s.structural, structural_weight)):
                uneven = np.ptp(density_at, axis=1) != 0.0
                relative[to[uneven]] = density_at[uneven] / density_at[uneven].mean(axis=1, keepdims=True)
    density, expansion = _materials(cards)
    return Elements(
        id=columns.id,
        type=card,
        property_id=property_id,
        node_offset=cards.node_offset,
        node_index=cards.node_index,
        mass_kg=mass * factor,
        added_kg=added * measure * factor,
        density=density * factor,
        expansion=expansion,
        section=section,
        lever=lever,
        weight=weight,
        structural_kg=structural * factor,
        structural_lever=structural_lever,
        structural_weight=structural_weight,
        partial=cards.partial,
    )


def _property_types(cards: _Cards) -> list[str]:
    """Names of the properties' cards [E]; empty where an element has none."""
    columns = columns_of(cards.model)
    found = [getattr(element, "pid_ref", None) for element in columns.examples()]
    names = ["" if prop is None else str(prop.type) for prop in found]
    return [names[k] for k in columns.alike.number.tolist()]


def _materials(cards: _Cards) -> tuple[FloatArray, FloatArray]:
    """Density and expansion [E] of the elements' materials; NaN where the property has no single material."""
    known: dict[int, tuple[float, float]] = {}
    columns = columns_of(cards.model)
    out = []
    for element in columns.examples():  # and those that are alike
        prop = getattr(element, "pid_ref", None)
        holder = element if prop is None else prop
        if id(holder) not in known:
            known[id(holder)] = _material(holder, f"{element.type} {element.eid}", cards)
        out.append(known[id(holder)])
    values = np.array(out).reshape(-1, 2)[columns.alike.number]
    return values[:, 0], values[:, 1]


def _material(holder: Any, what: str, cards: _Cards) -> tuple[float, float]:
    """Density and expansion of the single material of a property or an element, `what` of which is named; else NaN."""
    material = getattr(holder, "mid_ref", None) or getattr(holder, "mid1_ref", None)
    if material is None or not hasattr(material, "rho"):
        return np.nan, np.nan
    a = getattr(material, "a", None)
    return density_of(material, what, cards.where), a if isinstance(a, float) else np.nan
