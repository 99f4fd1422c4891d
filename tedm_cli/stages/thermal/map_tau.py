"""Sets of temperatures of thermal nodes, as users give them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.quantities import TEMPERATURE
from tedm_cli.stages.thermal.map_files import require_printable
from tedm_cli.stages.thermal.map_nodes import near_name
from tedm_cli.tables.csv_table import csv_lines, decimal_comma_hint, number_of, require_no_tabs


@dataclass(frozen=True, eq=False)
class Given:
    """m sets of temperatures of n nodes: their names [m], and [n, m] in K above the reference."""

    name: list[str]
    tau: FloatArray


def read_given(path: Path, nodes: Sequence[str]) -> Given:
    """A CSV `set,NODE...` with a column for every node, in any order.

    Raises
    ------
    InputError : not such a CSV; nodes that the map does not have, or that are missing, or spelled otherwise; a set
        without a name or with that of another; what is no temperature.
    """
    lines = [(number, fields) for number, fields in csv_lines(path) if any(fields)]
    if not lines:
        raise InputError("is empty; must begin with a header set,NODE...", where=str(path))
    head, header = f"{path}:{lines[0][0]}", lines[0][1]
    if len(header) == 1:
        require_no_tabs(header[0], head)
        if ";" in header[0]:
            raise InputError("the columns are divided by semicolons", where=head, hint="divide them by commas")
    if header[0] != "set":
        raise InputError(f"must begin with the column set, found {header[0][:40]!r}", where=head)
    columns = _columns(header[1:], nodes, head)
    names: list[str] = []
    values = np.empty((len(lines) - 1, len(nodes)))
    for row, (number, fields) in enumerate(lines[1:]):
        place = f"{path}:{number}"
        if len(fields) != len(header):
            hint = decimal_comma_hint(fields, len(header))
            raise InputError(f"{len(fields)} fields, the header has {len(header)}", where=place, hint=hint)
        if not fields[0]:
            raise InputError("set is empty", where=place)
        require_printable("set", fields[0], place)
        if fields[0].upper() in (name.upper() for name in names):
            raise InputError(f"set {fields[0]!r} is there twice", where=place)
        names.append(fields[0])
        values[row] = [number_of(TEMPERATURE, header[c], fields[c], place) for c in columns]
    if not names:
        raise InputError("holds a header and nothing else", where=str(path))
    return Given(names, np.ascontiguousarray(values.T))


def _columns(found: Sequence[str], nodes: Sequence[str], where: str) -> list[int]:
    """Column of each node."""
    spelled, known = {name.upper(): name for name in nodes}, list(nodes)
    twice = next((name for name in found if list(found).count(name) > 1), None)
    if twice is not None:
        raise InputError(f"node {twice!r} has two columns", where=where)
    facts = []
    if other := [name for name in found if name not in spelled.values() and name.upper() in spelled]:
        listed = ", ".join(f"{name!r} (in the map {spelled[name.upper()]!r})" for name in other[:4])
        facts.append(f"names that differ in the case of letters: {listed}")
    if unknown := [name for name in found if name.upper() not in spelled]:
        listed = ", ".join(f"{name[:40]!r}" for name in unknown[:6])
        more = f" and {len(unknown) - 6} more" if len(unknown) > 6 else near_name(unknown[0], known)
        facts.append(f"nodes that the map does not have: {listed}{more}")
    heard = {name.upper() for name in found}
    if missing := [name for name in nodes if name.upper() not in heard]:
        more = f" and {len(missing) - 6} more" if len(missing) > 6 else ""
        facts.append(f"no column for {', '.join(missing[:6])}{more}")
    if facts:
        raise InputError("; ".join(facts), where=where, hint=f"the map has {len(nodes)} thermal nodes")
    return [1 + list(found).index(name) for name in nodes]
