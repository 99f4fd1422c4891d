"""Displacements of the unit loads from one or several OP2 files, in the basic frame, one subcase at a time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.errors import InputError
from tedm_cli.nastran.frames import local_basis
from tedm_cli.nastran.geometry import FloatArray, ModelGeometry, id_list
from tedm_cli.nastran.reading import read_results
from tedm_cli.nastran.unit_loads import UnitLoad

_STRUCTURAL_GRID = 1  # grid type in the OP2; 2 marks scalar points


def unit_load_displacements(
    op2_files: Sequence[Path],
    loads: Sequence[UnitLoad],
    geometry: ModelGeometry,
    subcase_table: Mapping[str, int] | None = None,
) -> Iterator[tuple[UnitLoad, FloatArray, FloatArray]]:
    """Yield (unit load, translation [N,3] m, rotation [N,3] rad) for every load, in the order of the OP2 files.

    Subcases are matched by `subcase_table` (area name to subcase id), else by LABEL without regard to case, never by
    order; every area of `subcase_table` is among `loads`. Displacements of grids the OP2 leaves out stay zero when
    those grids carry neither stiffness nor mass.

    Raises
    ------
    InputError : a load without result, a result without load, a result given twice, missing grids, NaN or infinity.
    """
    by_label = {load.label.upper(): load for load in loads}
    by_subcase = {number: by_label[area.upper()] for area, number in (subcase_table or {}).items()}
    seen: dict[str, Path] = {}
    rotation = _to_basic(geometry)
    for path in op2_files:
        results = read_results(path)
        for key in sorted(results.displacements):
            table = results.displacements[key]
            load = by_subcase.get(int(key)) if subcase_table else by_label.get(_label(table).upper())
            if load is None:
                name = f"label '{_label(table)}'" if _label(table) else "no label"
                raise InputError(
                    f"subcase {int(key)} ({name}) belongs to no thermal area of the deck",
                    where=str(path),
                    hint="label the subcases with the area names, or give [model.subcases] area = id",
                )
            if load.label in seen:
                raise InputError(f"area '{load.label}' was already in {seen[load.label]}", where=str(path))
            seen[load.label] = path
            yield load, *_motion(table, int(key), load, geometry, rotation, path)
        results.displacements.clear()
    missing = [load for load in loads if load.label not in seen]
    if missing:
        names = ", ".join(f"'{m.label}' (subcase {m.subcase})" for m in missing[:5])
        more = f" and {len(missing) - 5} more" if len(missing) > 5 else ""
        raise InputError(
            f"no displacements for {len(missing)} of {len(loads)} unit loads: {names}{more}",
            where=", ".join(str(p) for p in op2_files),
            hint="is an OP2 missing from the list, or did the solver stop before its last subcase?",
        )


def _label(table: Any) -> str:
    """The subcase's LABEL; pyNastran appends `SUBCASE n` and padding to some dialects' labels."""
    label = str(getattr(table, "label", "") or "").strip()
    head, _, tail = label.rpartition("SUBCASE")
    return head.strip() if head.strip() and tail.strip().isdigit() else label


def _motion(
    table: Any,
    subcase: int,
    load: UnitLoad,
    geometry: ModelGeometry,
    to_basic: FloatArray | None,
    path: Path,
) -> tuple[FloatArray, FloatArray]:
    place = f"{path}: subcase {subcase} (area '{load.label}')"
    grid = np.asarray(table.node_gridtype)
    keep = grid[:, 1] == _STRUCTURAL_GRID
    ids = grid[keep, 0].astype(np.int64)
    data = np.asarray(table.data[0][keep], dtype=float)
    if not np.isfinite(data).all():
        bad = ids[~np.isfinite(data).all(axis=1)]
        raise InputError(
            f"{bad.size} of {len(ids):,} displacements are NaN or infinite: grid {id_list(bad)}",
            where=place,
            hint="did the solver fail in this subcase?",
        )
    rows = np.searchsorted(geometry.grid_id, ids)
    rows[rows == len(geometry.grid_id)] = 0
    unknown = ids[geometry.grid_id[rows] != ids]
    if unknown.size:
        raise InputError(
            f"{unknown.size} grids are not in the deck: {id_list(unknown)}",
            where=place,
            hint="are these the results of another model?",
        )
    if np.unique(ids).size != ids.size:
        raise InputError("a grid occurs twice", where=place)
    got = np.zeros(len(geometry.grid_id), dtype=bool)
    got[rows] = True
    needed = geometry.structural | (geometry.lumped_kg > 0)
    absent = geometry.grid_id[needed & ~got]
    if absent.size:
        raise InputError(
            f"{absent.size} grids have no displacement: {id_list(absent)}",
            where=place,
            hint="request DISPLACEMENT(PLOT) = ALL",
        )
    motion = np.zeros((len(geometry.grid_id), 6))
    motion[rows] = data
    # A table named BOUGV1 is written in the basic frame already; all others in each grid's displacement frame.
    name = table.table_name.decode() if isinstance(table.table_name, bytes) else str(table.table_name)
    if to_basic is not None and "BOUG" not in name.upper():
        motion = np.einsum("nij,naj->nai", to_basic, motion.reshape(-1, 2, 3)).reshape(-1, 6)
    return motion[:, :3], motion[:, 3:]


def _to_basic(geometry: ModelGeometry) -> FloatArray | None:
    """Per grid the rotation [N,3,3] from its displacement frame (CD) to the basic frame; None when all are basic."""
    used = np.unique(geometry.displacement_frame)
    if list(used) == [0]:
        return None
    out = np.tile(np.eye(3), (len(geometry.grid_id), 1, 1))
    for cid in used:
        if cid == 0:
            continue
        kind, origin, axes = geometry.frames[int(cid)]
        rows = np.nonzero(geometry.displacement_frame == cid)[0]
        local = (geometry.position_m[rows] - origin) @ axes.T
        out[rows] = np.einsum("ai,nab->nib", axes, local_basis(kind, local))
    return out
