"""Other loads than temperature as a deck: written, solved as any deck is, and read again."""

from __future__ import annotations

import shutil
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from loads_project import with_loads

from tedm_cli.config.project import Project
from tedm_cli.contracts import LOADS
from tedm_cli.errors import ConfigError, InputError, UsageError
from tedm_cli.files.store import open_checked
from tedm_cli.progress import silent
from tedm_cli.stages.loads.build import build_loads
from tedm_cli.stages.loads.deck import write_loads_deck
from tedm_cli.stages.model.solve import solve, solve_other

SOME = (
    '[[foot]]\nname = "A"\ngrid = 800104\nmotions = ["ux", "ry"]\n\n'
    '[[gravity_release]]\nname = "UP"\nground_m_s2 = [1.0, 0.0, -9.80665]\n\n'
    '[[moisture_release]]\nname = "DRY"\n[[moisture_release.swelling]]\nmaterial = 6\n'
    "expansion_per_percent = 2e-4\nchange_percent = -0.5\n[modes]\nnumber = 0\n"
)


@dataclass(frozen=True)
class Elsewhere:
    """Loads that are written as a deck, solved as any deck is, and read again."""

    project: Project
    deck: Path
    op2: Path


@pytest.fixture(scope="module")
def elsewhere(small: Project, tmp_path_factory: pytest.TempPathFactory) -> Elsewhere:
    folder = tmp_path_factory.mktemp("elsewhere")
    project = with_loads(small, folder, SOME)
    written = write_loads_deck(project, folder / "loads.bdf")
    assert written.loads == [
        "A_ux",
        "A_ry",
        *(f"INTERFACE_{m}" for m in ("ux", "uy", "uz", "rx", "ry", "rz")),
        "UP",
        "DRY",
    ]
    op2, report = solve_other(project, written.path, None, silent)
    assert report.n_cases == 10
    assert op2 == folder / "loads.op2"
    return Elsewhere(project, written.path, op2)


def test_chain_loads_solved_from_their_deck_are_those_solved_here(elsewhere: Elsewhere, tmp_path: Path) -> None:
    """To the single precision of the results: every grid by every load, and what the elements of the bench do."""
    here = build_loads(elsewhere.project, tmp_path / "here.h5", silent).results
    there = build_loads(elsewhere.project, tmp_path / "there.h5", silent, results=[elsewhere.op2]).results
    assert np.isnan(there.residual)
    assert here.residual < 1e-8
    with open_checked(tmp_path / "here.h5", LOADS) as one, open_checked(tmp_path / "there.h5", LOADS) as other:
        wanted, found = (file.array(LOADS.TRANSLATION) for file in (one, other))
        size = np.abs(wanted).max(axis=(1, 2), keepdims=True)
        assert (np.abs(found - wanted) <= 2e-7 * size).all()
        wanted, found = (file.array(LOADS.MOTION).reshape(-1, 2, 3, 10) for file in (one, other))
        size = np.abs(wanted).max(axis=(0, 2), keepdims=True)
        assert (np.abs(found - wanted) <= 2e-7 * size + 1e-12).all()


def test_chain_the_deck_of_loads_is_one_of_nastran(elsewhere: Elsewhere) -> None:
    """Each subcase has one set; a motion has a force of nothing beside it, which some solvers want."""
    lines = elsewhere.deck.read_text().splitlines()
    assert sum(line.startswith("SUBCASE") for line in lines) == 10
    of_first = lines[lines.index("$ A_ux") + 1 : lines.index("$ A_ry")]
    assert of_first[0].split()[:4] == ["FORCE*", of_first[0].split()[1], "800104", "0"]
    assert [line.split()[2:] for line in of_first if line.startswith("SPCD*")] == [["800104", "1", "1.000000000E+00"]]
    assert max(map(len, of_first)) <= 80


def test_chain_results_of_other_loads_are_refused(elsewhere: Elsewhere, small: Project, tmp_path: Path) -> None:
    out = tmp_path / "loads.h5"
    fewer = with_loads(small, tmp_path, SOME.replace("DRY", "MOIST"))
    with pytest.raises(InputError, match=r"is of no load of the configuration \(label 'DRY'\)"):
        build_loads(fewer, out, silent, results=[elsewhere.op2])
    more = with_loads(small, tmp_path, SOME + '[[gravity_release]]\nname = "B"\nground_m_s2 = [1.0, 0.0, 0.0]\n')
    with pytest.raises(InputError, match="no displacements for 1 of 11 loads: B"):
        build_loads(more, out, silent, results=[elsewhere.op2])
    with pytest.raises(InputError, match="load A_ux was already in"):
        build_loads(elsewhere.project, out, silent, results=[elsewhere.op2] * 2)
    with pytest.raises(InputError):
        build_loads(elsewhere.project, out, silent, results=[tmp_path / "none.op2"])
    long = with_loads(small, tmp_path, SOME.replace('"A"', f'"{64 * "A"}"'))
    with pytest.raises(InputError, match="has a name of 67 characters, and a LABEL has room for"):
        write_loads_deck(long, tmp_path / "loads.bdf")
    with pytest.raises(ConfigError, match="has no load"):
        write_loads_deck(with_loads(small, tmp_path, ""), tmp_path / "loads.bdf")
    with pytest.raises(InputError, match="is a file of the model itself"):
        write_loads_deck(elsewhere.project, Path(small.resolve("unit_loads.bdf")))
    assert sorted(p.name for p in tmp_path.iterdir()) == ["loads.toml"]


def test_chain_solve_refuses_other_loads_in_the_unit_load_deck(elsewhere: Elsewhere, tmp_path: Path) -> None:
    """As ingest would, before anything is solved."""
    folder = tmp_path / "copy"
    shutil.copytree(elsewhere.project.model.parent, folder)
    shutil.copy(elsewhere.deck, folder / "unit_loads.bdf")
    project = replace(elsewhere.project, model=folder / "model.toml")
    with pytest.raises(InputError, match="loads the structure besides its temperature"):
        solve(project, tmp_path / "out.op2", silent)
    with pytest.raises(UsageError, match="is no OP2"):
        solve_other(project, elsewhere.deck, tmp_path / "out.h5", silent)
