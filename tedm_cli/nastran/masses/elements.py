"""Elements of a model and their masses as plain arrays, computed for all elements of a card at a time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import InputError, PhysicsError
from tedm_cli.fem.measure import contents
from tedm_cli.fem.shapes import CARDS, PYRAMID_AS_BRICK, Shape, corner_count, shape_of
from tedm_cli.nastran.masses.lines import line_spread
from tedm_cli.nastran.masses.midside import check_midside, check_partial
from tedm_cli.nastran.masses.nonstructural import Measured, nonstructural
from tedm_cli.nastran.masses.plates import plate_spread
from tedm_cli.nastran.masses.solids import solid_spread
from tedm_cli.nastran.masses.spread import Spread, ToBasic, density_of

# Springs, dampers, gaps, plots and heat: Nastran gives them no mass (a CBUSH has that of its property).
_MASSLESS = {
    *("CELAS1", "CELAS2", "CELAS3", "CELAS4", "CDAMP1", "CDAMP2", "CDAMP3", "CDAMP4", "CDAMP5", "CVISC", "CGAP"),
    *("CBUSH1D", "CBUSH2D", "CFAST", "CWELD", "CSEAM", "GENEL", "PLOTEL", "CHBDYG", "CHBDYE", "CHBDYP"),
}


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

    id : [E]; card : [E], the cards' names; element : [E], the cross-referenced cards.
    node_offset, node_index, partial : as in `Elements`; where : the deck, for messages.
    """

    id: IntArray
    card: list[str]
    element: list[Any]
    node_offset: IntArray
    node_index: IntArray
    partial: list[int]
    where: str


@dataclass(frozen=True)
class _Group:
    """Elements of one card with one number of nodes: places in the order of the model, cards, rows of the grids."""

    card: str
    place: IntArray
    cards: list[Any]
    rows: IntArray
    spread: Spread | None
    shape: Shape | None
    position: FloatArray


def element_nodes(element: Any, scalar: Any = ()) -> list[int]:
    """Ids of the grids of an element; scalar elements may leave an end open or on a scalar point (`scalar`: ids)."""
    nodes = element.nodes if hasattr(element, "nodes") else element.node_ids
    return [int(n) for n in nodes if n and n not in scalar]


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
    return _integrated(model, cards, _groups(cards, position, to_basic), factor)


def _cards(model: Any, rows: Callable[[IntArray, str], IntArray], where: str) -> _Cards:
    ids = sorted(model.elements)
    elements = [model.elements[i] for i in ids]
    names = [str(e.type) for e in elements]
    nodes, partial = [], []
    for eid, element, card in zip(ids, elements, names, strict=True):
        at = element_nodes(element, model.spoints)
        least = corner_count(card) if card != "CPYRAM" else 5
        if least is not None and len(at) != least and shape_of(card, len(at)) is None:
            if card != "CPYRAM" or len(at) != 13:
                partial.append(eid)
            at = at[:least]
        nodes.append(at)
    index = rows(np.array([n for at in nodes for n in at], dtype=np.int64), "an element")
    offset = np.concatenate([[0], np.cumsum([len(n) for n in nodes])]).astype(np.int64)
    return _Cards(np.array(ids, dtype=np.int64), names, elements, offset, index, partial, where)


def _groups(cards: _Cards, position: FloatArray, to_basic: ToBasic) -> list[_Group]:
    """The elements by card and number of nodes, each with the spread of its mass."""
    out, where = [], cards.where
    counts = np.diff(cards.node_offset).tolist()
    kinds, inverse = np.unique([f"{c}:{n}" for c, n in zip(cards.card, counts, strict=True)], return_inverse=True)
    for number, kind in enumerate(kinds):
        card, count = str(kind).split(":")
        place = np.flatnonzero(inverse == number)
        members = [cards.element[i] for i in place]
        at = cards.node_index[cards.node_offset[place][:, None] + np.arange(int(count))]
        shape = shape_of(card, int(count))
        if shape is None and card == "CPYRAM":
            at, shape = at[:, PYRAMID_AS_BRICK], CARDS["CHEXA"][0]
        if shape is not None:
            check_midside(members, shape, position[at], where)
        spread: Spread | None
        if shape is None:
            if card not in _MASSLESS and card != "CBUSH":
                raise InputError(
                    f"{card} {members[0].eid}: elements of this kind are not read",
                    where=where,
                    hint="leave them out, or model them with solids, plates, bars and concentrated masses",
                )
            spread = None
        elif shape.dimension == 3:
            spread = solid_spread(members, shape.nodes, where)
        elif shape.dimension == 2:
            spread = plate_spread(members, shape, position[at], where)
        else:
            spread = line_spread(members, position[at], to_basic, where)
        out.append(_Group(card, place, members, at, spread, shape, position[at]))
    return out


def _integrated(model: Any, cards: _Cards, groups: list[_Group], factor: float) -> Elements:
    """The masses of the groups, integrated over their elements and put into the order of the model."""
    count = len(cards.id)
    measure, mass, structural, section = (np.zeros(count) for _ in range(4))
    for group in groups:
        if group.spread is not None and group.shape is not None:
            s = group.spread
            measure[group.place], mass[group.place], tangled = contents(
                group.shape, group.position + s.axis, s.structural + s.nonstructural
            )
            structural[group.place] = mass[group.place]
            if s.nonstructural.any():
                structural[group.place] = contents(group.shape, group.position + s.axis, s.structural)[1]
            bad = group.place[tangled & (mass[group.place] != 0.0)]
            if bad.size:
                raise PhysicsError(
                    f"{bad.size} {group.card} with a Jacobian that changes its sign: {cards.id[bad[0]]}",
                    where=cards.where,
                    hint="are the grids of the card, and its lines, in order?",
                )
    pids = [max(int(getattr(e, "pid", None) or 0), 0) for e in cards.element]  # pyNastran gives CONROD a negative one
    property_id = np.array(pids, dtype=np.int64)
    property_type = [_property_type(e) for e in cards.element]
    added = nonstructural(model, Measured(cards.id, cards.card, property_id, property_type, measure), cards.where)
    mass += added * measure
    lever, weight = np.zeros((len(cards.node_index), 3)), np.ones(len(cards.node_index))
    structural_lever, structural_weight = np.zeros_like(lever), np.ones_like(weight)
    for group in groups:
        place, shape = group.place, group.shape
        if group.spread is None or shape is None:
            mass[place] = [float(getattr(getattr(e, "pid_ref", None), "mass", None) or 0.0) for e in group.cards]
            continue
        s = group.spread
        loads = s.nonstructural + added[place][:, None]
        whole = s.structural + loads
        section[place] = s.section
        if group.card == "CPYRAM":
            continue
        with np.errstate(divide="ignore", invalid="ignore"):
            mixed = (s.structural[..., None] * s.structural_lever + loads[..., None] * s.nonstructural_lever) / whole[
                ..., None
            ]
        to = cards.node_offset[place][:, None] + np.arange(shape.nodes)
        # where all of the mass is at one place, that place to the last digit
        same = (s.structural_lever == s.nonstructural_lever).all(axis=2) | (loads == 0.0)
        lever[to] = np.where(same[..., None], s.structural_lever, np.nan_to_num(mixed))
        structural_lever[to] = s.structural_lever
        for density_at, relative in ((whole, weight), (s.structural, structural_weight)):
            uneven = np.ptp(density_at, axis=1) != 0.0
            relative[to[uneven]] = density_at[uneven] / density_at[uneven].mean(axis=1, keepdims=True)
    density, expansion = _materials(cards.element, cards.where)
    return Elements(
        id=cards.id,
        type=cards.card,
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


def _property_type(element: Any) -> str:
    prop = getattr(element, "pid_ref", None)
    return "" if prop is None else str(prop.type)


def _materials(elements: list[Any], where: str) -> tuple[FloatArray, FloatArray]:
    """Density and expansion [E] of the elements' materials; NaN where the property has no single material."""
    known: dict[int, tuple[float, float]] = {}
    out = np.empty((len(elements), 2))
    for i, element in enumerate(elements):
        prop = getattr(element, "pid_ref", None)
        holder = element if prop is None else prop
        if id(holder) not in known:
            material = getattr(holder, "mid_ref", None) or getattr(holder, "mid1_ref", None)
            known[id(holder)] = (np.nan, np.nan)
            if material is not None and hasattr(material, "rho"):
                a = getattr(material, "a", None)
                what = f"{element.type} {element.eid}"
                known[id(holder)] = (density_of(material, what, where), a if isinstance(a, float) else np.nan)
        out[i] = known[id(holder)]
    return out[:, 0], out[:, 1]
