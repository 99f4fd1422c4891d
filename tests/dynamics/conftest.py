"""The chain of the small sample up to the sensitivities and the read-outs, built once."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[1] / "borders"))

from border_tools import CONFIGS, SMALL, Project
from shared_folder import shared


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Project:
    """The small sample with default dynamics and case 3 simulated. Not to be changed: copy it."""
    return Project(shared(tmp_path_factory, "dynamics", build_loop))


def build_loop(folder: Path) -> None:
    for name in ("unit_loads.bdf", "unit_loads.op2", "model.toml", "ltp_small_areas.csv"):
        shutil.copy(SMALL / name, folder)
    for name in ("optics.toml", "cases.toml"):
        shutil.copy(CONFIGS / name, folder)
    (folder / "tedm.toml").write_text('title = "small sample"\n')
    project = Project(folder)
    for command in ("ingest", "build-distortion", "build-sensitivity", "build-optics", "build-dynamics"):
        project.run(command).ok()
    project.run("simulate", "3").ok()


@pytest.fixture
def satellite(built: Project, tmp_path: Path) -> Project:
    """A copy that a test may change, with a dynamics.toml of its own that is still empty."""
    project = built.copy(tmp_path / "small")
    (project.folder / "dynamics.toml").write_text("")
    (project.folder / "tedm.toml").write_text('title = "small sample"\ndynamics = "dynamics.toml"\n')
    return project
