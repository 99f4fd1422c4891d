"""Displacements of an adjoint deck from its results, as solutions of K λ = g."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.errors import InputError
from tedm_cli.nastran.displacements import OnGrids
from tedm_cli.nastran.geometry import ModelGeometry
from tedm_cli.nastran.loads.adjoint_rows import AdjointRow, read_label
from tedm_cli.nastran.result_files import open_result_file
from tedm_cli.nastran.subcase_table import SubcaseTable

_SAME_SCALE = 1e-4  # relative; the scale is the largest force of an output
_HINT = "write the deck anew with `tedm write-deck --adjoint`, solve it, and name its results"


def adjoint_motions(
    files: Sequence[Path], rows: Sequence[AdjointRow], geometry: ModelGeometry, scalar_points: Collection[int] = ()
) -> tuple[FloatArray, BoolArray]:
    """Solutions λ [6 N, r] of outputs, m and rad per N and N·m times their unit, and which [r] are in double precision.

    Subcases are known by their labels, and their order does not matter; which is which is settled before the first
    displacement is read.

    Raises
    ------
    InputError : what `open_result_file` and `OnGrids` refuse; a subcase of no output, or of one whose forces have
        another scale; outputs without a subcase, or with two.
    """
    number = {row.output.upper(): n for n, row in enumerate(rows)}
    found: dict[tuple[Path, int], tuple[int, float]] = {}
    place: dict[int, str] = {}
    for path in files:
        with open_result_file(path) as (tables, _):
            for table in tables:
                where = f"{path}: subcase {table.subcase}"
                n, scale = _row(table, number, rows, where)
                if n in place:
                    raise InputError(f"output {rows[n].output} was already in {place[n]}", where=where)
                place[n], found[path, table.subcase] = where, (n, scale)
    missing = [row.output for n, row in enumerate(rows) if n not in place]
    if missing:
        more = f" and {len(missing) - 5} more" if len(missing) > 5 else ""
        raise InputError(
            f"no displacements for {len(missing)} of {len(rows)} outputs: {', '.join(missing[:5])}{more}",
            where=", ".join(map(str, files)),
            hint="did the solver stop before its last subcase? was the deck written before there was optics.h5? else "
            + _HINT,
        )
    on_grids, motion = OnGrids(geometry, scalar_points), np.empty((6 * len(geometry.grid_id), len(rows)))
    double = np.zeros(len(rows), dtype=bool)
    for path in files:
        with open_result_file(path) as (tables, read):
            for table in tables:
                n, scale = found[path, table.subcase]
                got = read(table)
                motion[:, n] = scale * on_grids.motion(got, table, f"{place[n]} ({rows[n].output})").reshape(-1)
                double[n] = got.double
    return motion, double


def _row(table: SubcaseTable, number: dict[str, int], rows: Sequence[AdjointRow], where: str) -> tuple[int, float]:
    """The output of a subcase, by its number among `rows`, and its scale."""
    if not table.labelled:
        raise InputError("has no labels, which tell the output and its scale", where=where, hint=_HINT)
    label = read_label(table.label)
    if label is None:
        shown = f"label '{table.label}'" if table.label else "no label"
        raise InputError(f"is not of an adjoint deck ({shown})", where=where, hint=_HINT)
    output, scale = label
    if output.upper() not in number:
        raise InputError(
            f"is of {output}, which is no output of the matrices in the build folder",
            where=where,
            hint="is optics.h5 missing, or were test masses or sets renamed? else " + _HINT,
        )
    n = number[output.upper()]
    if abs(scale / rows[n].scale - 1.0) > _SAME_SCALE:
        raise InputError(
            f"is of other matrices: the scale of {output} is {scale:.5E} there, and {rows[n].scale:.5E} now",
            where=where,
            hint=_HINT,
        )
    return n, scale
