"""A solver of adjoint decks for tests: FORCE and MOMENT cards as pyNastran reads them, on our stiffness."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from pyNastran.bdf.bdf import read_bdf

from tedm_cli.deck_units import SI, DeckUnits
from tedm_cli.fem.static import StaticSolution
from tedm_cli.nastran.structure.deck import read_solver_deck

Motions = list[tuple[int, str, np.ndarray]]


def forces_of(deck: Path, units: DeckUnits = SI) -> list[tuple[str, np.ndarray]]:
    """Label, and forces [6 N] in N and N·m, of every subcase."""
    model: Any = read_bdf(str(deck), xref=False, debug=None)
    rows = {grid: row for row, grid in enumerate(sorted(model.nodes))}
    newton = units.mass_kg * units.length_m / units.time_s**2
    out = []
    for number, case in sorted(model.subcases.items()):
        if number == 0:
            continue
        force = np.zeros((len(rows), 6))
        for card in model.loads[case["LOAD"][0]]:
            assert card.cid == 0
            first, size = {"FORCE": (0, newton), "MOMENT": (3, newton * units.length_m)}[card.type]
            force[rows[card.node], first : first + 3] += card.mag * card.xyz * size
        out.append((str(case["LABEL"][0]), force.reshape(-1)))
    return out


def solve_forces(deck: Path, unit_deck: Path, units: DeckUnits = SI) -> tuple[np.ndarray, Motions]:
    """Ids of the grids, and subcase, label and motion [N, 6] of each, in the deck's units and displacement frames.

    The structure is that of the unit-load deck, which has the temperatures that the embedded solver asks for.
    """
    structure, _ = read_solver_deck(unit_deck, units=units)
    loads = forces_of(deck, units)
    names, forces = [name for name, _ in loads], np.array([force for _, force in loads]).T
    motion = StaticSolution(structure).adjoint(forces, names).motion.T.reshape(len(names), -1, 6)
    per = np.repeat([1.0 / units.length_m, 1.0], 3)
    return structure.grid_id, [
        (n, name, per * structure.in_displacement_frames(m))
        for n, (name, m) in enumerate(zip(names, motion, strict=True), 1)
    ]
