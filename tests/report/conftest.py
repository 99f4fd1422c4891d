from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from figure_texts import drawn
from matplotlib.figure import Figure
from report_project import close_loop, make_project
from shared_folder import shared

from tedm_cli.config.project import Project, load_project
from tedm_cli.contracts import SENSITIVITY
from tedm_cli.files.store import open_checked
from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.noise.areas import AreaTable
from tedm_cli.progress import silent
from tedm_cli.results.build_folder import open_results
from tedm_cli.results.cases.file import read_case
from tedm_cli.results.cases.noise import CaseNoise
from tedm_cli.results.gravity.field import dc_verdicts
from tedm_cli.stages.reporting.plot import figure_specs, plot


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Project:
    """A project with its figures; tests must not change it."""

    def make(folder: Path) -> None:
        project = make_project(folder)
        close_loop(project)
        plot(project, None, silent)

    folder = shared(tmp_path_factory, "finished", make)
    return load_project(folder / "tedm.toml", folder / "build")


@pytest.fixture(scope="session")
def figures(finished: Project) -> dict[str, Figure]:
    """All figures, drawn once, so that their texts and keys have their places."""
    with open_results(finished) as results:
        specs = figure_specs(results, [read_case(case) for case in results.cases])
        return {spec.name: drawn(spec.draw()) for spec in specs}


@pytest.fixture(scope="module")
def cases(finished: Project) -> list[CaseNoise]:
    with open_results(finished) as results:
        return [read_case(r) for r in results.cases]


@pytest.fixture(scope="module")
def areas(finished: Project) -> AreaTable:
    with open_results(finished) as results:
        return results.areas


@pytest.fixture(scope="module")
def at_rest(finished: Project) -> list[DcVerdict]:
    with open_checked(finished.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        return dc_verdicts(file)


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
