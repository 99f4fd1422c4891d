"""Matrices that the case control of a unit-load deck selects: stiffness (K2GG), and forces by subcase (P2G)."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.fem.constraints import to_basic
from tedm_cli.fem.structure import DirectStiffness, LoadCase, OnFreedoms, Structure
from tedm_cli.fem.superelement import require_stiffness
from tedm_cli.nastran.control_words import Statement
from tedm_cli.nastran.superelements.dmig import SYMMETRIC, entries_of, numbered, six

_NAMES = re.compile("[A-Z][A-Z0-9_]{0,7}(,[A-Z][A-Z0-9_]{0,7})*")


def direct_matrices(statements: Sequence[Statement], where: str) -> tuple[tuple[str, ...], str | None]:
    """Names of the stiffness and of the forces that all subcases have.

    Raises
    ------
    InputError : subcases that differ, factors, or several matrices of forces.
    """
    out: dict[str, tuple[str, ...]] = {}
    for word in ("K2GG", "P2G"):
        above: str | None = None
        subcases: list[str | None] = []
        for s in statements:
            if s.word == "SUBCASE":
                subcases.append(above)
            elif s.word == word and subcases:
                subcases[-1] = s.shown
            elif s.word == word:
                above = s.shown
        chosen = set(subcases or [above])
        if len(chosen) > 1:
            raise InputError(f"subcases select different {word}", where=where, hint=f"write {word} above all subcases")
        (name,) = chosen
        names = () if name is None else tuple(name.split(","))
        if name is not None and (not _NAMES.fullmatch(name) or (word == "P2G" and len(names) > 1)):
            raise InputError(
                f"{word} = {name[:40]} is not the name of {'one matrix' if word == 'P2G' else 'matrices'}",
                where=where,
                hint="the embedded solver takes matrices without factors, and one of forces",
            )
        out[word] = names
    return out["K2GG"], next(iter(out["P2G"]), None)


def selected_stiffness(model: Any, names: Sequence[str], grid_id: IntArray, path: Path) -> DirectStiffness:
    """The sum of the matrices of K2GG on grids [N], in the units of the deck.

    Raises
    ------
    InputError : no such matrix, one that is not real and symmetric, entries elsewhere than on grids, a stiffness with a
        negative eigenvalue.
    """
    if not names:
        return DirectStiffness()
    where = f"{path}: K2GG {', '.join(names)}"
    entries = [entries_of(model, name, SYMMETRIC, str(path)) for name in names]
    grids = np.unique(np.concatenate([one.row[:, 0] for one in entries]))
    unknown = grids[~np.isin(grids, grid_id)]
    if unknown.size:
        raise InputError(f"has an entry at {unknown[0]}, which is no grid", where=where)
    matrix = np.zeros((6 * len(grids),) * 2)
    try:
        for name, one in zip(names, entries, strict=True):
            matrix += one.dense(six(grids), six(grids), name)
        require_stiffness(matrix)
    except InputError as error:
        raise InputError(error.fact, where=where, hint=error.hint) from error
    dof = 6 * np.searchsorted(grid_id, grids)[:, None] + np.arange(6)
    return DirectStiffness(dof=dof.reshape(-1), matrix=matrix)


def with_forces(model: Any, name: str, structure: Structure, cases: Sequence[LoadCase], path: Path) -> list[LoadCase]:
    """Load cases of a structure with the columns of P2G, one for each subcase, in the units of the deck.

    Raises
    ------
    InputError : no such matrix, one that is not real and columnar, entries elsewhere than on grids, or another number
        of columns than of subcases.
    """
    where = f"{path}: P2G {name}"
    entries = entries_of(model, name, (9,), str(path))
    columns = model.dmig[name].ncols
    if columns != len(cases):
        raise InputError(f"has {columns} columns (NCOL) for {len(cases)} subcases", where=where)
    grids = np.unique(entries.row[:, 0])
    unknown = grids[~np.isin(grids, structure.grid_id)]
    if unknown.size:
        raise InputError(f"has an entry at {unknown[0]}, which is no grid", where=where)
    matrix = entries.dense(six(grids), numbered(columns), f"P2G {name}")
    dof = (6 * np.searchsorted(structure.grid_id, grids)[:, None] + np.arange(6)).reshape(-1)
    matrix = to_basic(structure)[dof][:, dof] @ matrix
    return [
        replace(case, force=_and_more(case.force, dof, column)) if column.any() else case
        for case, column in zip(cases, matrix.T, strict=True)
    ]


def _and_more(force: OnFreedoms | None, dof: IntArray, value: FloatArray) -> OnFreedoms:
    if force is None:
        return OnFreedoms(dof, value)
    return OnFreedoms(np.concatenate([force.dof, dof]), np.concatenate([force.value, value]))
