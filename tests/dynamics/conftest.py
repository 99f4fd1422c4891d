"""The chain of the small sample up to the sensitivities and the read-outs, built once."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[1] / "borders"))

from border_tools import Project, build_chain
from shared_folder import shared


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Project:
    """The small sample with default dynamics and case 3 simulated. Not to be changed: copy it."""
    chain = shared(tmp_path_factory, "small", build_chain)

    def build_loop(folder: Path) -> None:
        shutil.copytree(chain, folder, dirs_exist_ok=True)
        project = Project(folder)
        (project.build / "case03.h5").unlink()
        project.run("build-dynamics").ok()
        project.run("simulate", "3").ok()

    return Project(shared(tmp_path_factory, "dynamics", build_loop))


@pytest.fixture
def satellite(built: Project, tmp_path: Path) -> Project:
    """A copy that a test may change, with a dynamics.toml of its own that is still empty."""
    project = built.copy(tmp_path / "small")
    (project.folder / "dynamics.toml").write_text("")
    (project.folder / "tedm.toml").write_text('title = "small sample"\ndynamics = "dynamics.toml"\n')
    return project
