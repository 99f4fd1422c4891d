"""The tables that say where thermal nodes are."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.quantities import COORDINATE, ID
from tedm_cli.tables.csv_table import csv_lines, number_of, read_table

_PLACE = ("x_m", "y_m", "z_m")


def read_node_elements(path: Path) -> dict[str, list[int]]:
    """Ids of the elements of each node from a CSV `tmm_node,element_id`, nodes in order of first appearance.

    Raises
    ------
    InputError : what `read_table` refuses, an id that is none, an element twice, names that differ in case only.
    """
    out: dict[str, list[int]] = {}
    seen: dict[int, tuple[int, str]] = {}
    spelled: dict[str, str] = {}
    for row in read_table(path, {"tmm_node": None, "element_id": ID}):
        name, number, place = row.text["tmm_node"], row.number["element_id"], f"{path}:{row.line}"
        element = int(number)
        if element != number:
            raise InputError(f"element_id must be a whole number, found {number:g}", where=place)
        require_one_spelling(spelled, name, place)
        if element in seen:
            line, other = seen[element]
            also = f" of node {other!r}" if other != name else ""
            raise InputError(f"element {element} of node {name!r} is in line {line} already{also}", where=place)
        seen[element] = row.line, name
        out.setdefault(name, []).append(element)
    return out


def read_places(path: Path) -> tuple[list[str], FloatArray]:
    """Names [n] and places [n, 3] (m) of the nodes of a CSV with columns node, x_m, y_m, z_m; those without are left.

    Raises
    ------
    InputError : not a CSV, a column that is missing, a place that is none or lacks a coordinate, a node twice, no node
        with a place.
    """
    lines = csv_lines(path)
    header = lines[0][1] if lines else []
    missing = [name for name in ("node", *_PLACE) if header.count(name) != 1]
    if missing:
        fact = f"must have one column {', '.join(missing)}"
        raise InputError(fact, where=f"{path}:1", hint="places are in columns x_m, y_m, z_m, in m and the basic frame")
    names, places = [], []
    spelled: dict[str, str] = {}
    for number, fields in lines[1:]:
        if not any(fields):
            continue
        where = f"{path}:{number}"
        if len(fields) != len(header):
            raise InputError(f"{len(fields)} fields, the header has {len(header)}", where=where)
        row = dict(zip(header, fields, strict=True))
        if not row["node"]:
            raise InputError("node is empty", where=where)
        if row["node"] in spelled.values():
            raise InputError(f"node {row['node']!r} is there twice", where=where)
        require_one_spelling(spelled, row["node"], where)
        given = [key for key in _PLACE if row[key]]
        if given and len(given) < 3:
            raise InputError(f"node {row['node']!r} has {', '.join(given)} alone of its place", where=where)
        if given:
            names.append(row["node"])
            places.append([number_of(COORDINATE, key, row[key], where) for key in _PLACE])
    if not names:
        raise InputError("gives no node a place", where=str(path), hint="fill the columns x_m, y_m, z_m")
    return names, np.array(places)


def require_one_spelling(spelled: dict[str, str], name: str, where: str) -> None:
    """Refuse a name that differs from an earlier one in the case of its letters alone; `spelled` keeps them.

    What is no line of printable text is refused too.
    """
    require_printable("node", name, where)
    if spelled.setdefault(name.upper(), name) != name:
        raise InputError(f"node {name!r} is also spelled {spelled[name.upper()]!r}", where=where)


def require_printable(what: str, name: str, where: str) -> None:
    """Refuse a name that is more than one line, or that cannot be seen."""
    if unseen := [c for c in name if not c.isprintable()]:
        raise InputError(
            f"the name of a {what} must be one line of printable text; it holds {unseen[0]!r}", where=where
        )
