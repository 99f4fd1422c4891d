"""Write the unit-load deck: the user's model as it stands, with one subcase of +1 K per thermal area."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.errors import InputError
from tedm_cli.nastran.geometry import Grids, IntArray, id_list, rows_of

# Case control that the unit-load subcases set themselves; everything else in the model's case control stays.
_REPLACED = ("DISP", "VECTOR", "TEMP", "LABEL", "LOAD", "SUBTITLE", "ANALYSIS")
STEP_K = 1.0


def unit_deck_text(
    source: Path, out: Path, model: Any, grids: Grids, areas: Mapping[str, IntArray], uniform_label: str
) -> str:
    """The text of the unit-load deck for the model in `source`, to be written to `out` (its INCLUDEs are rebased).

    Raises
    ------
    InputError : the model has subcases of its own or no SPC, its materials rest at different temperatures, the areas
        are not a partition of its structural grids, an area has the name of the uniform load.
    """
    where = str(source)
    _check(model, grids, areas, uniform_label, where)
    control, bulk = _split(source, out)
    trefs = {float(m.tref or 0.0) for m in model.materials.values() if hasattr(m, "tref")}
    if len(trefs) > 1:
        raise InputError(
            f"materials have different reference temperatures: {sorted(trefs)}",
            where=where,
            hint="give every material the same TREF: a unit load starts from one uniform temperature",
        )
    tref = trefs.pop() if trefs else 0.0
    first = max([0, *model.loads, *model.load_combinations, *model.tempds]) + 1
    cases = [*areas.items(), (uniform_label, np.concatenate(list(areas.values())))]
    lines = ["SOL 101", "CEND", *control]
    for i, (name, _) in enumerate(cases):
        lines += [
            f"SUBCASE {i + 1}",
            f"  LABEL = {name}",
            f"  TEMPERATURE(LOAD) = {first + i}",
            "  DISPLACEMENT(PLOT) = ALL",
        ]
    lines += ["BEGIN BULK", *bulk]
    for i, (_, ids) in enumerate(cases):
        lines += _temperatures(first + i, np.sort(ids), tref)
    return "\n".join(lines) + "\nENDDATA\n"


def _check(model: Any, grids: Grids, areas: Mapping[str, IntArray], uniform_label: str, where: str) -> None:
    control = model.case_control_deck
    if control is not None and any(n != 0 for n in control.subcases):
        raise InputError(
            "the model has subcases of its own",
            where=where,
            hint="keep one level of case control (SPC and the like); the unit loads become the subcases",
        )
    for name in areas:
        if name.upper() == uniform_label.upper():
            raise InputError(f"area '{name}' has the name of the uniform load", where=where, hint="set uniform_label")
    count = np.zeros(len(grids.grid_id), dtype=int)
    for name, ids in areas.items():
        count[rows_of(grids.grid_id, ids, where=where, what=f"area '{name}'")] += 1
    twice = grids.grid_id[count > 1]
    left = grids.grid_id[(count == 0) & grids.structural]
    if twice.size:
        raise InputError(f"{twice.size} grids are in two thermal areas: {id_list(twice)}", where=where)
    if left.size:
        raise InputError(f"{left.size} structural grids are in no thermal area: {id_list(left)}", where=where)
    idle = [name for name, ids in areas.items() if not grids.structural[np.searchsorted(grids.grid_id, ids)].any()]
    if idle:
        raise InputError(f"areas without any structural grid: {', '.join(idle)}", where=where)


def _split(source: Path, out: Path) -> tuple[list[str], list[str]]:
    """Case control that stays and bulk lines that stay, from the main file of the deck."""
    lines = source.read_text(encoding="latin-1").splitlines()
    begin = next((i for i, line in enumerate(lines) if re.match(r"\s*BEGIN(\s+BULK)?\s*$", line, re.I)), None)
    if begin is None:
        raise InputError("has no BEGIN BULK line", where=str(source))
    cend = next((i for i, line in enumerate(lines[:begin]) if line.strip().upper() == "CEND"), -1)
    control = [
        line.rstrip()
        for line in lines[cend + 1 : begin]
        if line.strip() and not line.strip().upper().startswith((*_REPLACED, "$"))
    ]
    bulk = [line.rstrip() for line in lines[begin + 1 :]]
    end = next((i for i, line in enumerate(bulk) if line.strip().upper().startswith("ENDDATA")), len(bulk))
    return control, [_rebase(line, source, out) for line in bulk[:end]]


def _rebase(line: str, source: Path, out: Path) -> str:
    match = re.match(r"\s*INCLUDE\s+(['\"]?)(.+?)\1\s*$", line, re.I)
    if match is None:
        return line
    target = Path(os.path.relpath((source.parent / match.group(2)).resolve(), out.parent.resolve()))
    return f"INCLUDE '{target.as_posix()}'"


def _temperatures(sid: int, ids: IntArray, tref: float) -> list[str]:
    warm, rest = _real(tref + STEP_K), _real(tref)
    lines = [f"TEMPD   {sid:>8}{rest:>8}"]
    for start in range(0, len(ids), 3):
        pairs = "".join(f"{int(i):>8}{warm:>8}" for i in ids[start : start + 3])
        lines.append(f"TEMP    {sid:>8}{pairs}")
    return lines


def _real(value: float) -> str:
    text = f"{value:.6g}"
    return text if "." in text else text + "."
