"""Read the part of Nastran that the embedded solver understands; refuse the rest by name.

The deck is a SOL 101 run whose subcases each apply temperatures, or forces, accelerations and motions of supports, or
both. Everything that would change the displacements
and is not modelled is collected first and refused in one message.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tedm_cli.deck_units import SI, DeckUnits
from tedm_cli.errors import InputError
from tedm_cli.fem.structure import LoadCase, OnFreedoms, Structure
from tedm_cli.nastran.reading import read_deck
from tedm_cli.nastran.structure.bars import read_bars
from tedm_cli.nastran.structure.cases import read_load_cases, selected_sets
from tedm_cli.nastran.structure.constraints import read_constraints, read_equations
from tedm_cli.nastran.structure.frames import read_grids
from tedm_cli.nastran.structure.mechanical_loads import MechanicalReader
from tedm_cli.nastran.structure.references import CardReferences
from tedm_cli.nastran.structure.refusals import refuse_unsupported
from tedm_cli.nastran.structure.rigid import read_rigid_elements
from tedm_cli.nastran.structure.rods import read_rods
from tedm_cli.nastran.structure.shells import read_shells
from tedm_cli.nastran.structure.solids import read_solids
from tedm_cli.nastran.superelements.selected import selected_stiffness, with_forces
from tedm_cli.nastran.units import load_case_in_si, structure_in_si, units_of


def read_solver_deck(path: Path, units: DeckUnits = SI) -> tuple[Structure, list[LoadCase]]:
    """Read a unit-load deck for the embedded solver: `solver_structure` of what `read_deck` finds in it."""
    return solver_structure(read_deck(path, cross_reference=False, units=units), path)


def solver_structure(model: Any, path: Path) -> tuple[Structure, list[LoadCase]]:
    """Structure and load cases of a unit-load deck for the embedded solver.

    Parameters
    ----------
    model : pyNastran model, not cross-referenced, of the deck whose main file, with case control, is `path`.

    Returns
    -------
    The structure, grids sorted by id, in SI and the basic frame of the deck, and one load case per subcase.

    Raises
    ------
    InputError
        If it holds cards or features that are not modelled (all are named, with counts);
        if cards refer to what does not exist; or if subcases have loads that are not modelled or differ in their
        constraints.
    """
    refuse_unsupported(model, path)
    grid_id, position, frame = read_grids(model, path)
    if not model.elements:
        raise InputError("no elements", where=str(path), hint="a unit-load deck holds the whole model")
    references = CardReferences(grid_id, path)
    solids, bars = read_solids(model, references), read_bars(model, references, position, frame)
    rods = read_rods(model, references)
    quads, trias = read_shells(model, references, "CQUAD4"), read_shells(model, references, "CTRIA3")
    rbe2, rbe3 = read_rigid_elements(model, references)
    sets = selected_sets(model, path)
    for name, selected, cards in (
        ("SPC", sets.constraint, model.spcs.keys() | model.spcadds.keys()),
        ("MPC", sets.equations, model.mpcs.keys() | model.mpcadds.keys()),
    ):
        if selected is not None and selected not in cards:
            raise InputError(f"case control selects {name} {selected}, which is not in the bulk data", where=str(path))
    spc_grid, spc_component, moved = read_constraints(model, sets.constraint, references)
    mpc = read_equations(model, sets.equations, references)
    references.refuse_missing()

    blocks = [(block.element_id, block.connectivity) for block in solids]
    blocks += [(bars.element_id, bars.connectivity), (rods.element_id, rods.connectivity)]
    blocks += [(shells.element_id, shells.connectivity) for shells in (quads, trias)]
    supports = OnFreedoms(6 * spc_grid + spc_component - 1, moved)
    mechanical = MechanicalReader(model, grid_id, position, supports, path)
    initial, cases = read_load_cases(model, sets, grid_id, blocks, mechanical.loads, path)
    structure = Structure(
        grid_id=grid_id,
        position=position,
        displacement_frame=frame,
        solids=solids,
        bars=bars,
        rods=rods,
        quads=quads,
        trias=trias,
        rbe2=rbe2,
        rbe3=rbe3,
        mpc=mpc,
        spc_grid=spc_grid,
        spc_component=spc_component,
        initial_temperature=initial,
        direct=selected_stiffness(model, sets.stiffness, grid_id, path),
    )
    if sets.forces is not None:
        cases = with_forces(model, sets.forces, structure, cases, path)
    units = units_of(model)
    return structure_in_si(structure, units), [load_case_in_si(case, units) for case in cases]
