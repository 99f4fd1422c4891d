"""Which column of a user's table holds the temperature of which thermal area."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IndexArray
from tedm_cli.errors import InputError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.selection import listed

ALL = "all"
_SHOWN = 6


@dataclass(frozen=True)
class NodeWeights:
    """Weights of the nodes that make the temperature of an area, by area and node; `where` they are from."""

    weights: Mapping[str, Mapping[str, float]]
    where: str


def parts_of_columns(
    columns: Sequence[str], areas: AreaTable, needed: BoolArray, *, where: str, nodes: NodeWeights | None = None
) -> FloatArray:
    """What part each column has in the temperature of each area [k, columns]; zeros for areas that are not needed.

    An area of `nodes` has those columns with their weights, any other that is needed has one with all of it. Beside
    `nodes` there may be columns that are not used: a thermal model has more nodes than areas need. A gradient area
    follows the column of its own name, in K/m, and no other: it is constant where there is none.

    Raises
    ------
    InputError : as `columns_of_areas`; areas or nodes that are not there, or an area that is not needed.
    """
    parts = np.zeros((len(areas), len(columns)))
    weights = {} if nodes is None else nodes.weights
    names = areas.name.tolist()
    number = {name: place for place, name in enumerate(columns)}
    if nodes is not None:
        _require_nodes(nodes, columns, areas, needed, where)
    for area, of in weights.items():
        for node, weight in of.items():
            parts[names.index(area), number[node]] = weight
    means = ~areas.gradient
    others = needed & means & ~np.isin(areas.name, list(weights))
    if nodes is None:
        left = list(columns)
    else:
        known = {*names, *areas.group.tolist(), "inside", "outside", ALL}
        used = {node for of in weights.values() for node in of}
        left = [c for c in columns if c in known and c not in used]
    own = [c for c in left if c in set(areas.name[areas.gradient].tolist())]
    left = [c for c in left if c not in own]
    for row, column in enumerate(columns_of_areas(left, areas, others, where=where, of=means)):
        if column >= 0:
            parts[row, number[left[column]]] = 1.0
    for name in own:
        parts[names.index(name), number[name]] = float(needed[names.index(name)])
    return parts


def parts_of_nodes(
    columns: Sequence[str], nodes: AreaTable, needed: BoolArray, idle: BoolArray, *, where: str
) -> FloatArray:
    """What part each column has in the temperature of each thermal node [k, columns], by names that are the same.

    The last of `nodes` may be areas that the nodes leave out, and gradient areas, which are constant without a column.
    `idle` [columns] may be there and are not used.

    Raises
    ------
    InputError : nodes that are needed and have no column; columns that are no node, unless idle.
    """
    names, number = nodes.name.tolist(), {name: place for place, name in enumerate(columns)}
    parts = np.zeros((len(nodes), len(columns)))
    for row, name in enumerate(names):
        if name in number:
            parts[row, number[name]] = float(needed[row])
    facts = []
    missing = [n for n, wanted in zip(names, needed & ~nodes.gradient, strict=True) if wanted and n not in number]
    if missing:
        facts.append(f"no column for {len(missing)} of {len(names)} thermal nodes: {listed(missing, _SHOWN)}")
    unknown = [c for c, may in zip(columns, idle, strict=True) if c not in set(names) and not may]
    if unknown:
        facts.append(f"columns that are no thermal node: {listed(unknown, _SHOWN)}")
    if facts:
        hints = ["nodes that keep their temperature are `constant`"] if missing else []
        if unknown:
            folded = {name.casefold(): name for name in names}
            near = difflib.get_close_matches(unknown[0].casefold(), folded, n=1)
            hints.append(
                f"did you mean {folded[near[0]]}?" if near else "columns that are not on the model are `unused`"
            )
        raise InputError("; ".join(facts), where=where, hint="; ".join(hints))
    return parts


def _require_nodes(nodes: NodeWeights, columns: Sequence[str], areas: AreaTable, needed: BoolArray, where: str) -> None:
    names, facts = areas.name.tolist(), []
    constant = set(areas.name[~needed].tolist())
    gradient = set(areas.name[areas.gradient].tolist())
    wanted = list(dict.fromkeys(node for of in nodes.weights.values() for node in of))
    for what, found in (
        ("no thermal area", [area for area in nodes.weights if area not in names]),
        (f"no column of {where}", [node for node in wanted if node not in set(columns)]),
        ("said to be constant", [area for area in nodes.weights if area in constant]),
        ("a gradient, which is no mean of nodes", [area for area in nodes.weights if area in gradient]),
    ):
        if found:
            facts.append(f"{what}: {listed(found, _SHOWN)}")
    if facts:
        raise InputError("; ".join(facts), where=nodes.where, hint="nodes are named as the columns of the series are")


def part_words(parts: FloatArray, columns: Sequence[str]) -> list[str]:
    """What each area [k] follows, in words: the name of a column, `0.25 N1 + 0.75 N2`, or nothing."""
    said = []
    for row in parts:
        held = [(columns[c], row[c]) for c in np.flatnonzero(row)]
        alone = len(held) == 1 and held[0][1] == 1.0
        said.append(held[0][0] if alone else " + ".join(f"{weight:.6g} {name}" for name, weight in held))
    return said


def columns_of_areas(
    columns: Sequence[str], areas: AreaTable, needed: BoolArray, *, where: str, of: BoolArray | None = None
) -> IndexArray:
    """Column [k] of every area that is needed, -1 for the others.

    A column is named after an area, a group, a shield (`inside`, `outside`) or `all`; the narrowest one counts. No two
    `columns` have one name. `of` [k] are the areas of the columns' unit, which all of `needed` are among: by default
    those of mean temperatures.

    Raises
    ------
    InputError : a column that names nothing of the model, or an area of another unit, or a needed area without a
        column.
    """
    names = list(columns)
    of = ~areas.gradient if of is None else of
    groups = sorted(set(areas.group[of].tolist()))
    known = [*areas.name[of].tolist(), *groups, "inside", "outside", ALL]
    _require_unit(names, areas, of, where)
    unknown = [name for name in names if name not in known]
    if unknown:
        near = difflib.get_close_matches(unknown[0], known, n=1)
        more = f" and {len(unknown) - 1} more" if len(unknown) > 1 else ""
        raise InputError(
            f"column {unknown[0]!r}{more} names no thermal area, group or shield",
            where=where,
            hint=(f"did you mean {near[0]}? " if near else "")
            + f"columns may be areas, groups ({', '.join(groups)}), inside, outside or all",
        )
    index = np.full(len(areas), -1, dtype=np.intp)
    missing = []
    for area in np.flatnonzero(needed):
        keys = (str(areas.name[area]), str(areas.group[area]), str(areas.shield[area]), ALL)
        column = next((names.index(key) for key in keys if key in names), -1)
        index[area] = column
        if column < 0:
            missing.append(keys[0])
    if missing:
        raise InputError(
            f"no column for {len(missing)} of {of.sum()} {'gradient' if areas.gradient[of].any() else 'thermal'} areas:"
            f" {listed(missing, _SHOWN)}",
            where=where,
            hint="add a column for each of them, for their group, for inside or outside, or for all",
        )
    return index


def _require_unit(names: Sequence[str], areas: AreaTable, of: BoolArray, where: str) -> None:
    """Refuse columns of areas whose temperature has another unit than that of the areas `of` [k]."""
    others = [name for name in names if name in set(areas.name[~of].tolist())]
    if others:
        area = int(np.flatnonzero(areas.name == others[0])[0])
        wanted, found = ("K/m", "mean temperature, in K") if areas.unit[area] == "K" else ("K", "gradient, in K/m")
        raise InputError(
            f"column {others[0]!r} names the area of a {found}; the spectra of this table are in {wanted}/sqrt(Hz)",
            where=where,
            hint="temperatures and gradients have tables of their own: [temperature] or override, and"
            " [[temperature.gradient]]",
        )
