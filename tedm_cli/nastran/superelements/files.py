"""Matrices of a superelement in a file: OUTPUT4 (.op4), or DMIG cards in bulk data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.fem.superelement import ReducedMatrices
from tedm_cli.nastran.captured_output import captured_output, fact_of
from tedm_cli.nastran.library import require_pynastran, without_integration
from tedm_cli.nastran.reading import any_encoding
from tedm_cli.nastran.superelements.dmig import RECTANGULAR, SQUARE, SYMMETRIC, cards, entries_of, numbered, six
from tedm_cli.regular_file import require_regular_file

OP4 = ".op4"


@dataclass(frozen=True)
class MatrixNames:
    """Names of the matrices in the file."""

    stiffness: str = "KAA"
    loads: str = "PA"
    recovery: str = "GRA"
    thermal_recovery: str = "URA"


def read_matrices(
    path: Path, names: MatrixNames, interface: IntArray, areas: int, recovered: IntArray
) -> ReducedMatrices:
    """Matrices in the units of their file, over the freedoms of the interface grids [b] and then internal ones.

    Rows and columns of OUTPUT4 are in this order; those of DMIG by their labels, internal ones at any other point.

    Parameters
    ----------
    areas : number of columns of the loads. recovered : [r], ids of the grids whose motions the recovery gives.

    Raises
    ------
    InputError : no such file or matrix, one of another size, entries where there should be none, a grid without rows in
        a DMIG of recovery.
    """
    require_regular_file(path)
    if not path.is_file():
        raise InputError("no such file of matrices", where=str(path), hint="correct matrices of the superelement")
    require_pynastran()
    if path.suffix.lower() == OP4:
        return _of_op4(path, names, interface, areas, recovered)
    return _of_dmig(path, names, interface, areas, recovered)


def _of_op4(path: Path, names: MatrixNames, interface: IntArray, areas: int, recovered: IntArray) -> ReducedMatrices:
    with without_integration():
        from pyNastran.op4.op4 import read_op4

    with captured_output() as chatter:
        try:
            found = {name: _dense(matrix) for name, matrix in read_op4(str(path), debug=None).items()}
        except Exception as error:  # pyNastran raises almost anything on a file that is damaged
            raise InputError(
                f"cannot be read as OUTPUT4: {fact_of(error, chatter.getvalue())}", where=str(path)
            ) from error
    stiffness = _named(found, names.stiffness, path)
    least, size = 6 * len(interface), len(stiffness)
    if stiffness.shape[0] != stiffness.shape[1] or size < least:
        raise InputError(
            f"stiffness {names.stiffness} is {' x '.join(map(str, stiffness.shape))}; {len(interface)} interface grids"
            f" have {least} freedoms, before internal ones",
            where=str(path),
            hint="is the interface complete? each of its grids has six rows",
        )
    if recovered.size:
        recovery, thermal = _named(found, names.recovery, path), _named(found, names.thermal_recovery, path)
    else:
        recovery, thermal = np.zeros((0, size)), np.zeros((0, areas))
    loads = _named(found, names.loads, path)
    of_masses = f"six rows for each of {len(recovered)} grids with mass"
    for name, matrix, shape, why in (
        (names.loads, loads, (size, areas), f"a row for each of the stiffness, a column for each of {areas} areas"),
        (names.recovery, recovery, (6 * len(recovered), size), f"{of_masses}, a column for each row of the stiffness"),
        (names.thermal_recovery, thermal, (6 * len(recovered), areas), f"{of_masses}, a column for each area"),
    ):
        if matrix.shape != shape:
            given, wanted = (" x ".join(map(str, s)) for s in (matrix.shape, shape))
            raise InputError(f"{name} is {given}, wanted {wanted}: {why}", where=str(path))
    return ReducedMatrices(stiffness=stiffness, loads=loads, recovery=recovery, thermal_recovery=thermal)


def _dense(matrix: Any) -> FloatArray:
    data = matrix.data
    return np.asarray(data.toarray() if hasattr(data, "toarray") else data, dtype=np.float64)


def _named(found: Mapping[str, FloatArray], name: str, path: Path) -> FloatArray:
    matrix = found.get(name)
    if matrix is None:
        known = ", ".join(sorted(found)[:8]) or "none"
        raise InputError(f"has no matrix {name}; there are: {known}", where=str(path))
    if not np.isfinite(matrix).all():
        raise InputError(f"{name} has entries that are no finite numbers", where=str(path))
    return matrix


def _of_dmig(path: Path, names: MatrixNames, interface: IntArray, areas: int, recovered: IntArray) -> ReducedMatrices:
    with without_integration():
        from pyNastran.bdf.bdf import BDF

    model: Any = BDF(debug=None)
    with captured_output() as chatter:
        try:
            model.read_bdf(str(path), xref=False, validate=False, punch=True, encoding=any_encoding(model))
        except Exception as error:  # as in `read_deck`
            raise InputError(
                f"cannot be read as DMIG cards: {fact_of(error, chatter.getvalue())}", where=str(path)
            ) from error
    where = str(path)
    stiffness = entries_of(model, names.stiffness, (*SYMMETRIC, *SQUARE), where)
    labels = {tuple(label) for label in stiffness.row.tolist()}
    bare = [grid for grid in interface.tolist() if not any((grid, c) in labels for c in range(1, 7))]
    if bare:
        raise InputError(f"stiffness {names.stiffness} has no row of interface grid {bare[0]}", where=where)
    boundary = six(interface)
    rows = boundary + sorted(labels - set(boundary))
    loads = entries_of(model, names.loads, RECTANGULAR, where)
    if recovered.size:
        recovery, thermal = (
            entries_of(model, name, RECTANGULAR, where) for name in (names.recovery, names.thermal_recovery)
        )
        lacking = recovered[~np.isin(recovered, recovery.row[:, 0])]
        if lacking.size:
            raise InputError(f"recovery {names.recovery} has no row of grid {lacking[0]}", where=where)
    try:
        return ReducedMatrices(
            stiffness=stiffness.dense(rows, rows, names.stiffness),
            loads=loads.dense(rows, numbered(areas), names.loads),
            recovery=recovery.dense(six(recovered), numbered(len(rows)), names.recovery)
            if recovered.size
            else np.zeros((0, len(rows))),
            thermal_recovery=thermal.dense(six(recovered), numbered(areas), names.thermal_recovery)
            if recovered.size
            else np.zeros((0, areas)),
        )
    except InputError as error:
        raise InputError(error.fact, where=where, hint=error.hint) from error


def write_matrices(
    path: Path, suffix: str, matrices: ReducedMatrices, interface: Sequence[int], recovered: Sequence[int]
) -> None:
    """Write what `read_matrices` reads under the names of `MatrixNames`; `suffix` is that of the file it becomes.

    OUTPUT4 is text of 17 digits, DMIG has 16-digit fields.
    """
    named = MatrixNames()
    of = {
        named.stiffness: matrices.stiffness,
        named.loads: matrices.loads,
        named.recovery: matrices.recovery,
        named.thermal_recovery: matrices.thermal_recovery,
    }
    if suffix.lower() != OP4:
        rows, points = six(interface), six(recovered)
        lines = cards(named.stiffness, matrices.stiffness, rows)
        for name, labels in ((named.loads, rows), (named.recovery, points), (named.thermal_recovery, points)):
            if of[name].size:
                lines += cards(name, of[name], labels, numbered(of[name].shape[1]))
        path.write_text("\n".join(lines) + "\n", encoding="ascii")
        return
    with without_integration():
        from pyNastran.op4.op4 import write_op4

    forms = {name: (6 if name == named.stiffness else 2, matrix) for name, matrix in of.items() if matrix.size}
    with captured_output():
        write_op4(str(path), forms, name_order=list(forms), precision="double", is_binary=False, debug=None)
