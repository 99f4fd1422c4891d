"""Areas under a temperature gradient: which way it points in each shell and bar."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tedm_cli.arrays import BoolArray, IntArray
from tedm_cli.config.model.areas import DefinitionTable
from tedm_cli.nastran.geometry import id_list
from tedm_cli.nastran.loads.area_loads import SOLIDS, AreaLoad, none, parallel
from tedm_cli.nastran.loads.element_axes import BENDING_LINES
from tedm_cli.nastran.loads.element_temperatures import SHELLS
from tedm_cli.nastran.membership import Membership

_ALONG = 0.1  # a direction has at least this part along an element's gradient


def gradient_load(
    m: Membership,
    at: str,
    definition: DefinitionTable,
    elements: BoolArray,
    problems: list[tuple[str, str]],
    notes: list[str],
) -> AreaLoad:
    """1 K/m in each of the `elements` [E], towards the definition's direction; what cannot be goes to `problems`."""
    name, before = definition.name, len(problems)
    shell, bar = np.isin(m.card, SHELLS) & elements, np.isin(m.card, BENDING_LINES) & elements
    others = elements & ~shell & ~bar
    if not elements.any():
        problems.append((at, f"area '{name}' has no element that meets its criteria"))
    for card in np.unique(m.card[others]):
        ids = id_list(m.element_id[others & (m.card == card)])
        problems.append((at, f"area '{name}': a gradient on {card} {ids}: {_reason(str(card))}"))
    use = shell | bar
    if definition.plane is not None and use.any() and not bar.any():
        problems.append(
            (at, f"area '{name}': plane is that of bars, and it has shells alone: give a direction, or none")
        )
    axes, d = m.axes[use], definition.direction
    if d is not None:
        part = axes @ (np.array(d) / np.linalg.norm(d))
        size = np.linalg.norm(part, axis=1)
        flat = m.element_id[use][size < _ALONG]
        if flat.size:
            fact = f"area '{name}': its direction lies in the shells, or along the bars, {id_list(flat)}"
            problems.append((at, f"{fact}: less than {_ALONG:g} of it is through them"))
        gradient = part / np.maximum(size, _ALONG)[:, None]
    else:
        gradient = np.zeros((int(use.sum()), 2))
        gradient[:, 0] = 1.0
        if definition.plane == 2:
            gradient[bar[use]] = [0.0, 1.0]
        if bar.any() and definition.plane is None:
            ids = id_list(m.element_id[bar])
            problems.append((at, f"area '{name}': bars {ids} need a direction = [x, y, z], or the plane (1 or 2)"))
        turned = _turned(m, shell)
        if turned.size:
            notes.append(
                f"area {name}: neighbouring shells whose normals, and with them the gradients, are opposite:"
                f" {id_list(turned)}; give a direction = [x, y, z] if that is not meant"
            )
    if len(problems) > before:
        return AreaLoad(none(), none(), none(), np.zeros((0, 2)))
    return AreaLoad(none(), m.element_id[use], none(), gradient)


def _reason(card: str) -> str:
    if card in SOLIDS:
        return "a solid has no card for it, and its grids can be warmed: define areas of the grids of its two sides"
    return "it does not bend with temperature"


def refuse_parallel(loads: Mapping[str, AreaLoad], places: Mapping[str, str], problems: list[tuple[str, str]]) -> None:
    """Two gradient areas must not be the same load in an element; the later of the two is named."""
    names = list(loads)
    for j, later in enumerate(names):
        for earlier in names[:j]:
            one, two = loads[earlier], loads[later]
            ids, a, b = np.intersect1d(one.element_id, two.element_id, return_indices=True)
            if one.gradient is None or two.gradient is None or not ids.size:
                continue
            same = ids[parallel(one.gradient[a], two.gradient[b])]
            if same.size:
                fact = f"areas '{earlier}' and '{later}' have gradients along one direction in elements {id_list(same)}"
                problems.append((places[later], fact))


def _turned(m: Membership, shells: BoolArray) -> IntArray:
    """Ids of shells that meet one neighbour at an edge, but with its normal on the other side."""
    rows = np.flatnonzero(shells)
    edges: list[tuple[int, int, int, int]] = []
    for row in rows.tolist():
        count = 3 if "TRIA" in str(m.card[row]) else 4
        ring = m.node_index[m.node_offset[row] : m.node_offset[row] + count]
        for a, b in zip(ring.tolist(), np.roll(ring, -1).tolist(), strict=True):
            edges.append((min(a, b), max(a, b), int(a < b), row))
    table = np.array(sorted(edges), dtype=np.int64).reshape(-1, 4)
    _, first, count_of = np.unique(table[:, :2], axis=0, return_index=True, return_counts=True)
    pair = first[count_of == 2]
    wrong = pair[table[pair, 2] == table[pair + 1, 2]]  # neighbours run along their edge in opposite ways
    return np.asarray(np.unique(m.element_id[table[np.concatenate([wrong, wrong + 1]), 3]]))
