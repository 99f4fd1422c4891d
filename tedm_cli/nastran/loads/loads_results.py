"""Displacements of a deck of other loads than temperature from its results."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from pathlib import Path

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.nastran.displacements import OnGrids
from tedm_cli.nastran.geometry import ModelGeometry
from tedm_cli.nastran.result_files import open_result_file

_HINT = "write the deck anew with `tedm write-deck --loads`, solve it, and name its results"


def load_motions(
    files: Sequence[Path], names: Sequence[str], geometry: ModelGeometry, scalar_points: Collection[int] = ()
) -> Iterator[tuple[int, FloatArray]]:
    """Places among the `names`, and motions [N, 6] in m and rad, basic frame, in the order of the files.

    Subcases are known by their labels; which is which is settled before the first displacement is read.

    Raises
    ------
    InputError : what `open_result_file` and `OnGrids` refuse; a subcase of no load, loads without one, or with two.
    """
    number = {name.upper(): k for k, name in enumerate(names)}
    place: dict[int, str] = {}
    for path in files:
        with open_result_file(path) as (tables, _):
            for table in tables:
                where = f"{path}: subcase {table.subcase}"
                k = number.get(table.label.upper())
                if k is None:
                    shown = f"label '{table.label}'" if table.label else "no label"
                    raise InputError(f"is of no load of the configuration ({shown})", where=where, hint=_HINT)
                if k in place:
                    raise InputError(f"load {names[k]} was already in {place[k]}", where=where)
                place[k] = where
    missing = [name for k, name in enumerate(names) if k not in place]
    if missing:
        more = f" and {len(missing) - 5} more" if len(missing) > 5 else ""
        raise InputError(
            f"no displacements for {len(missing)} of {len(names)} loads: {', '.join(missing[:5])}{more}",
            where=", ".join(map(str, files)),
            hint="did the solver stop before its last subcase? else " + _HINT,
        )
    on_grids = OnGrids(geometry, scalar_points)
    for path in files:
        with open_result_file(path) as (tables, read):
            for table in tables:
                k = number[table.label.upper()]
                motion = on_grids.motion(read(table), table, f"{place[k]} ({names[k]})")
                yield k, motion.reshape(-1, 6)
