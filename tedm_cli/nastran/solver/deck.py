"""Read the part of Nastran that the embedded solver understands; refuse the rest by name.

The deck is a SOL 101 run whose subcases each apply one temperature set. Everything that would change the displacements
and is not modelled is collected first and refused in one message.
"""

from __future__ import annotations

from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.errors import InputError
from tedm_cli.fem.structure import Floats, Ints, LoadCase, Structure
from tedm_cli.nastran.cards import refuse_lost_fields
from tedm_cli.nastran.reading import any_encoding
from tedm_cli.nastran.solver.bars import read_bars
from tedm_cli.nastran.solver.cases import read_load_cases, selected_sets
from tedm_cli.nastran.solver.constraints import read_constraints
from tedm_cli.nastran.solver.finder import Finder
from tedm_cli.nastran.solver.refusals import refuse_unsupported
from tedm_cli.nastran.solver.rigid import read_rigid_elements
from tedm_cli.nastran.solver.solids import read_hexes


def read_solver_deck(path: Path) -> tuple[Structure, list[LoadCase]]:
    """Read a unit-load deck for the embedded solver.

    Parameters
    ----------
    path : the main file of the deck, with case control; includes are followed.

    Returns
    -------
    The structure, grids sorted by id, in the units and the basic frame of the deck, and one load case per subcase.

    Raises
    ------
    InputError
        If the file cannot be read; if it holds cards or features that are not modelled (all are named, with counts);
        if cards refer to what does not exist; or if subcases are not thermal or differ in their constraints.
    """
    model = _read(path)
    refuse_unsupported(model, path)
    grid_id, position = _grids(model)
    if not any(element.type in ("CHEXA", "CBAR") for element in model.elements.values()):
        raise InputError(
            "no CHEXA and no CBAR elements", where=str(path), hint="a unit-load deck holds the whole model"
        )
    finder = Finder(grid_id, path)
    try:
        hexes, bars = read_hexes(model, finder), read_bars(model, finder, position)
    except InputError as error:  # of a material that is none, found where no file is known
        raise InputError(error.fact, where=error.where or str(path), hint=error.hint) from error
    rbe2, rbe3 = read_rigid_elements(model, finder)
    sets = selected_sets(model, path)
    if sets.constraint is not None and not {sets.constraint} & (model.spcs.keys() | model.spcadds.keys()):
        raise InputError(f"case control selects SPC {sets.constraint}, which is not in the bulk data", where=str(path))
    spc_grid, spc_component = read_constraints(model, sets.constraint, finder)
    finder.refuse_missing()

    heated = np.zeros(len(grid_id), dtype=bool)
    heated[hexes.connectivity.reshape(-1)] = True
    heated[bars.connectivity.reshape(-1)] = True
    initial, cases = read_load_cases(model, sets, grid_id, heated, path)
    structure = Structure(
        grid_id=grid_id,
        position=position,
        hexes=hexes,
        bars=bars,
        rbe2=rbe2,
        rbe3=rbe3,
        spc_grid=spc_grid,
        spc_component=spc_component,
        initial_temperature=initial,
    )
    return structure, cases


def _read(path: Path) -> Any:
    from cpylog import SimpleLogger  # type: ignore[import-untyped]
    from pyNastran.bdf.bdf import BDF

    if not path.is_file():
        raise InputError("no such file", where=str(path), hint="write it with `tedm write-deck`")
    model = BDF(log=SimpleLogger(level="critical"))
    refuse_lost_fields(model, path)
    dump = Path("pyNastran_crash.bdf")
    is_ours = not dump.exists()
    try:
        with redirect_stdout(StringIO()):  # pyNastran prints the cards that it cannot parse
            model.read_bdf(str(path), xref=False, validate=False, encoding=any_encoding(model))
    except InputError:
        raise
    except Exception as error:  # of many kinds; all mean that the deck is not readable
        if is_ours:  # pyNastran leaves a copy of the deck in the working directory when an include is missing
            dump.unlink(missing_ok=True)
        fact = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"pyNastran cannot read the deck: {fact[:300]}", where=str(path)) from error
    return model


def _grids(model: Any) -> tuple[Ints, Floats]:
    grid_id = np.array(sorted(model.nodes), dtype=np.int64)
    return grid_id, np.array([model.nodes[grid].xyz for grid in grid_id], dtype=np.float64).reshape(-1, 3)
