"""MSC Nastran's HDF5 results (`MDLPRM,HDF5`): displacements of static subcases, one subcase at a time.

Layout: MSC Nastran HDF5 result database, tables DOMAINS, NODAL/DISPLACEMENT and CASECC/SUBCASE. All rows of
displacements are in one table, with the domain that each belongs to; a domain is a subcase of one analysis.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.arrays import AnyArray
from tedm_cli.errors import InputError
from tedm_cli.files.record_tables import RecordTables, Run, open_tables
from tedm_cli.nastran.subcase_table import ANALYSES, STATICS, GridMotion, ReadTable, SubcaseTable, clean_label

_DOMAINS = "/NASTRAN/RESULT/DOMAINS"
_NODAL = "/NASTRAN/RESULT/NODAL"
_NAME = "DISPLACEMENT"
_DISPLACEMENT = f"{_NODAL}/{_NAME}"
_INDEX = f"/INDEX{_DISPLACEMENT}"
_CASES = "/NASTRAN/INPUT/PARAMETER/CASECC/SUBCASE"
_DOMAIN = "DOMAIN_ID"
_MOTION = ("X", "Y", "Z", "RX", "RY", "RZ")
_WHOLE, _REAL, _TEXT = "a whole number", "a real number", "text"
_KINDS = {_WHOLE: "iu", _REAL: "f", _TEXT: "S"}
# Columns of DOMAINS that are zero for all that is linear statics of a model in one piece, and what they tell else.
_PARTS = {
    "SE": "of superelement",
    "MODULE": "of module",
    "AFPM": "of acoustic field point mesh",
    "TRMC": "of trim component",
    "RANDOM": "of random response",
    "DESIGN_CYCLE": "of design cycle",
    "STEP": "of step",
    "SUBSTEP": "of substep",
    "MODE": "of mode",
}
_DAMAGED = "is the file complete, and was it copied as binary? did the solver end without a FATAL message?"


@dataclass(frozen=True)
class _Domain:
    """A domain's number, and what its row says in the columns that there are."""

    number: int
    said: Mapping[str, int]


@contextmanager
def open_msc_hdf5(path: Path) -> Iterator[tuple[list[SubcaseTable], ReadTable]]:
    """Open MSC Nastran's HDF5: the displacement tables in it, by subcase, and a function that reads one of them.

    A read holds one subcase. Every `SCHEMA` is taken whose tables have the columns that are read.

    Raises
    ------
    InputError : missing, damaged, HDF5 of another program, tables or columns that lack, no displacements, results of
        other than linear statics, complex numbers, superelements, a subcase given twice.
    """
    with open_tables(path, (_DISPLACEMENT, _DOMAINS, _CASES, _INDEX), _DOMAIN, _DAMAGED) as file:
        _require_msc(file, path)
        _require_displacements(file, path)
        runs = file.runs(_DISPLACEMENT)
        _check_index(file, runs, path)
        domains = _domains(file, runs, path)
        labels = _labels(file, path)
        tables = [
            SubcaseTable(number, (labels or {}).get(number, ""), _NAME, is_basic=False, labelled=labels is not None)
            for number in (d.said["SUBCASE"] for d in domains)
        ]
        by_subcase = {d.said["SUBCASE"]: d.number for d in domains}

        def read(table: SubcaseTable) -> GridMotion:
            return _read(file, [run for run in runs if run[0] == by_subcase[table.subcase]])

        yield sorted(tables, key=lambda t: t.subcase), read


def _require_msc(file: RecordTables, path: Path) -> None:
    ours, theirs = file.attribute("schema"), file.attribute("SCHEMA")
    hint = "MDLPRM,HDF5 in the deck makes MSC Nastran write its results as HDF5"
    if ours is not None and ours.startswith("tedm."):
        raise InputError(f"is tedm's own file ({ours}), not results of Nastran", where=str(path), hint=hint)
    if theirs is None or not theirs.strip("[]").strip().isdigit():
        fact = "has no attribute SCHEMA" if theirs is None else f"SCHEMA is {theirs!r}, and not a number"
        raise InputError(f"is HDF5, but not as MSC Nastran writes it: {fact}", where=str(path), hint=hint)


def _require_displacements(file: RecordTables, path: Path) -> None:
    nodal = file.members(_NODAL)
    if _NAME not in nodal:
        foreign = next((kind for kind in (f"{_NAME}_CPLX", "EIGENVECTOR", "EIGENVECTOR_CPLX") if kind in nodal), "")
        if foreign:
            what = "complex displacements" if foreign.startswith(_NAME) else "modes"
            raise InputError(
                f"holds {what} (table {foreign}), not static displacements", where=str(path), hint="solve with SOL 101"
            )
        raise InputError(
            f"holds no displacements (tables of grids: {', '.join(nodal) or 'none'})",
            where=str(path),
            hint="the deck needs DISPLACEMENT(PLOT) = ALL",
        )
    _require_columns(file, path, _DISPLACEMENT, {"ID": _WHOLE, **dict.fromkeys(_MOTION, _REAL), _DOMAIN: _WHOLE})
    if not file.runs(_DISPLACEMENT):
        raise InputError(
            f"holds no displacements ({_DISPLACEMENT} has no rows)",
            where=str(path),
            hint="did the solver end without a FATAL message?",
        )


def _require_columns(file: RecordTables, path: Path, table: str, wanted: Mapping[str, str]) -> None:
    found = file.columns(table)
    lacking = [c for c in wanted if c not in found]
    other = [c for c, kind in wanted.items() if c in found and not _is(found[c], kind)]
    schema = (file.attribute("SCHEMA") or "").strip("[]")
    if lacking:
        fact = f"{table} has no column {', '.join(lacking)} (SCHEMA {schema}); it has {', '.join(found)}"
    elif other:
        fact = f"{table}: column {other[0]} is {found[other[0]]}, wanted {wanted[other[0]]} (SCHEMA {schema})"
    else:
        return
    raise InputError(fact, where=str(path), hint="give the OP2 of this run (PARAM,POST,-1)")


def _is(dtype: np.dtype[Any], kind: str) -> bool:
    return dtype.kind in _KINDS[kind] and not dtype.shape and (kind == _TEXT or dtype.itemsize <= 8)


def _check_index(file: RecordTables, runs: Sequence[Run], path: Path) -> None:
    """Where the file has an index, it must put the rows of each domain where they are."""
    if not file.has(_INDEX):
        return
    _require_columns(file, path, _INDEX, dict.fromkeys((_DOMAIN, "POSITION", "LENGTH"), _WHOLE))
    said: list[Run] = []
    rows = (row for block in file.blocks(_INDEX) for row in block[[_DOMAIN, "POSITION", "LENGTH"]].tolist())
    for domain, first, length in sorted(rows, key=lambda row: int(row[1])):
        if said and said[-1][0] == domain and said[-1][2] == first:
            said[-1] = (domain, said[-1][1], first + length)
        else:
            said.append((domain, first, first + length))
    for index, table in zip([*said, None], [*runs, None], strict=False):
        if index != table:
            facts = [f"domain {r[0]} at rows {r[1] + 1:,} to {r[2]:,}" if r else "no more rows" for r in (index, table)]
            raise InputError(
                f"damaged: {_INDEX} has {facts[0]}, {_DISPLACEMENT} {facts[1]}", where=str(path), hint=_DAMAGED
            )


def _domains(file: RecordTables, runs: Sequence[Run], path: Path) -> list[_Domain]:
    """The domains that have displacements, each a static subcase of its own."""
    if not file.has(_DOMAINS):
        raise InputError(f"has no table {_DOMAINS}: its rows belong to no subcase", where=str(path), hint=_DAMAGED)
    _require_columns(file, path, _DOMAINS, dict.fromkeys(("ID", "SUBCASE", "ANALYSIS", "SE"), _WHOLE))
    columns = file.columns(_DOMAINS)
    kept = ["SUBCASE", "ANALYSIS", *(name for name in _PARTS if name in columns and _is(columns[name], _WHOLE))]
    with_rows = {number for number, _, _ in runs}
    found: dict[int, _Domain] = {}
    for block in file.blocks(_DOMAINS):
        for row in np.flatnonzero(np.isin(block["ID"], list(with_rows))).tolist():
            number = int(block["ID"][row])
            if number in found:
                raise InputError(f"damaged: {_DOMAINS} has domain {number} twice", where=str(path), hint=_DAMAGED)
            found[number] = _Domain(number, {name: int(block[name][row]) for name in kept})
    unknown = sorted(with_rows - found.keys())
    if unknown:
        raise InputError(
            f"damaged: {_DISPLACEMENT} has rows of domain {unknown[0]}, which {_DOMAINS} has not",
            where=str(path),
            hint=_DAMAGED,
        )
    for domain in found.values():
        _require_static(domain, path)
    for subcase, times in Counter(d.said["SUBCASE"] for d in found.values()).items():
        if times > 1:
            numbers = ", ".join(str(d.number) for d in found.values() if d.said["SUBCASE"] == subcase)
            raise InputError(f"subcase {subcase} occurs {times} times (domains {numbers})", where=str(path))
    return list(found.values())


def _require_static(domain: _Domain, path: Path) -> None:
    where = f"{path}: subcase {domain.said['SUBCASE']}"
    analysis = domain.said["ANALYSIS"]
    if analysis != STATICS:
        kind = ANALYSES.get(analysis, f"results of analysis code {analysis}")
        raise InputError(f"holds {kind}, not static displacements", where=where, hint="solve with SOL 101")
    for name, what in _PARTS.items():
        if number := domain.said.get(name, 0):
            raise InputError(
                f"results {what} {number} are not read ({name} of domain {domain.number})",
                where=where,
                hint="solve the model in one piece" if name in ("SE", "MODULE") else "solve with SOL 101",
            )


def _labels(file: RecordTables, path: Path) -> dict[int, str] | None:
    """LABEL of every subcase; None where the file does not hold the case control."""
    if not file.has(_CASES):
        return None
    _require_columns(file, path, _CASES, {"SID": _WHOLE, "LABEL": _TEXT})
    found: dict[int, str] = {}
    for block in file.blocks(_CASES):
        for subcase, raw in zip(block["SID"].tolist(), block["LABEL"].tolist(), strict=True):
            label = clean_label(raw.decode("latin-1"))
            if found.setdefault(subcase, label) != label:
                raise InputError(
                    f"subcase {subcase} has the labels '{found[subcase]}' and '{label}'",
                    where=str(path),
                    hint="label each subcase once",
                )
    return found


def _read(file: RecordTables, runs: Sequence[Run]) -> GridMotion:
    count = sum(last - first for _, first, last in runs)
    ids, motion = np.empty(count, dtype=np.int64), np.empty((count, 6))
    at, double = 0, False
    for domain, first, last in runs:
        for rows in file.blocks(_DISPLACEMENT, slice(first, last)):
            part = slice(at, at + len(rows))
            if (rows[_DOMAIN] != domain).any():
                raise file.refused(f"{_DISPLACEMENT}: rows of domain {domain} are others than when it was opened")
            ids[part] = rows["ID"]
            for column, name in enumerate(_MOTION):
                motion[part, column] = rows[name]
            double = double or not _single(motion[part])
            at = part.stop
    return GridMotion(ids, motion, double)


def _single(values: AnyArray) -> bool:
    """Whether single precision holds them: a solver that works in it may write its numbers in double precision."""
    with np.errstate(over="ignore"):
        return bool((values.astype(np.float32) == values).all())
