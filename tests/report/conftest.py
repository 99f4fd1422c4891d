from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from report_project import make_project

from tedm_cli.config.project import Project, load_project
from tedm_cli.progress import silent
from tedm_cli.stages.plot import plot


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Project:
    """A project with its figures; tests must not change it."""
    project = make_project(tmp_path_factory.mktemp("finished"))
    plot(project, None, silent)
    return project


@pytest.fixture
def copy(finished: Project, tmp_path: Path) -> Project:
    """The same project in a folder that a test may spoil."""
    folder = tmp_path / "project"
    shutil.copytree(finished.build_dir.parent, folder)
    return load_project(folder / "tedm.toml", folder / "build")


@pytest.fixture
def with_cases(tmp_path: Path) -> Callable[[str], Project]:
    """A function that makes a project with another cases file."""

    def make(cases: str) -> Project:
        return make_project(tmp_path, cases)

    return make
