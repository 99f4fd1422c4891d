"""Decks, OP2 files, figures and the report are written as carefully as the HDF5 files: killed or out of room, the old
file stays."""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from border_tools import SMALL, Outcome, Project, replace, snapshot

# command: the first file it replaces
WRITERS = {
    "write-deck": "unit_loads.bdf",
    "solve": "unit_loads.op2",
    "plot": "build/figures/ratios.svg",
    "report": "build/report.html",
}


@pytest.fixture(scope="session")
def finished(chain: Project, tmp_path_factory: pytest.TempPathFactory) -> Project:
    """The small sample with figures and report of case 3 alone. Not to be changed: copy it."""
    project = chain.copy(tmp_path_factory.mktemp("finished") / "small")
    for name in ("ltp_small.bdf", "ltp_small_areas.csv"):
        shutil.copy(SMALL / name, project.folder)
    cases = project.folder / "cases.toml"
    head, *tables = cases.read_text(encoding="utf-8").split("[[case]]")
    cases.write_text("[[case]]".join([head, *(t for t in tables if 'id = "3"' in t)]), encoding="utf-8")
    for command in ("run-case", "plot", "report"):
        project.stage(command).ok()
    return project


APART = """
import os, signal, sys
from pathlib import Path
sys.path[:0] = {path!r}
from border_tools import Project
from test_border_kills import limit_file_size
from tedm_cli.files import store
{prepared}
outcome = Project(Path({folder!r})).stage({command!r})
sys.stderr.write(outcome.err)
sys.exit(outcome.code)
"""


def apart(project: Project, command: str, prepared: str) -> subprocess.CompletedProcess[str]:
    """Run a stage in a process of its own. A fork will not do: threads that set a PDF in this one are not in a copy."""
    code = APART.format(path=sys.path, prepared=prepared, folder=str(project.folder), command=command)
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=300)


@pytest.mark.parametrize("command", WRITERS)
def test_killed_writer(finished: Project, tmp_path: Path, command: str) -> None:
    """Killed when its first new file is complete and about to take the old one's place."""
    project = finished.copy(tmp_path / "small")
    before = snapshot(project.folder)
    done = apart(project, command, "store.os.replace = lambda *_: os.kill(os.getpid(), signal.SIGKILL)")
    assert done.returncode == -signal.SIGKILL, done.stderr
    after = snapshot(project.folder)
    orphans = {name for name in after if Path(name).name.startswith(".")}
    assert len(orphans) == 1
    assert {name: digest for name, digest in after.items() if name not in orphans} == before
    project.stage(command).ok()
    assert not [name for name in snapshot(project.folder) if Path(name).name.startswith(".")]


@pytest.mark.parametrize("command", WRITERS)
def test_no_room(finished: Project, tmp_path: Path, command: str) -> None:
    project = finished.copy(tmp_path / "small")
    before = snapshot(project.folder)

    done = apart(project, command, f"limit_file_size({(project.folder / WRITERS[command]).stat().st_size // 2})")
    Outcome(done.returncode, done.stdout, done.stderr).refused(4, Path(WRITERS[command]).stem, "no room left")
    assert snapshot(project.folder) == before


def test_target_that_is_a_folder(finished: Project, tmp_path: Path) -> None:
    project = finished.copy(tmp_path / "small")
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken.html").mkdir()
    for command, taken in (("write-deck", "taken"), ("solve", "taken"), ("report", "taken.html")):
        project.run(command, "-o", tmp_path / taken).refused(4, taken, "cannot be written")


def test_solver_refuses_by_name(finished: Project, tmp_path: Path) -> None:
    """All cards that the embedded solver lacks, at once, with the way out."""
    project = finished.copy(tmp_path / "small")
    replace(
        project.deck,
        "ENDDATA",
        "RROD    999001       1       2       1\nCELAS1  999002       1       1       1\nENDDATA",
    )
    project.stage("solve").refused(4, "CELAS1 (1), RROD (1)", hint="Nastran")
