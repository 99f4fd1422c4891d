"""The small sample with a file on where compensation masses may be."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from shared_folder import shared

sys.path.append(str(Path(__file__).parents[1] / "borders"))

from border_tools import SMALL

from tedm_cli.config.project import Project, load_project
from tedm_cli.progress import silent
from tedm_cli.stages.gravity.sensitivity import build_sensitivity
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import ingest

MODEL = ("model.toml", "ltp_small.bdf", "ltp_small_areas.csv", "unit_loads.bdf", "unit_loads.op2")


def build(folder: Path) -> None:
    for name in MODEL:
        shutil.copy(SMALL / name, folder)
    (folder / "tedm.toml").write_text('title = "to be balanced"\n', encoding="utf-8")
    project = load_project(folder / "tedm.toml", folder / "build")
    ingest(project, None, silent)
    build_distortion(project, None, silent)
    build_sensitivity(project, None, silent)


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the small sample up to S_SG. Not to be changed."""
    return shared(tmp_path_factory, "balance_small", build)


@pytest.fixture
def project_of(built: Path, tmp_path: Path) -> Callable[..., Project]:
    """A function that makes the project with a balance.toml of this text, and changes of model.toml."""

    def make(text: str, *replaced: tuple[str, str]) -> Project:
        folder = tmp_path / "project"
        shutil.copytree(built, folder)
        (folder / "balance.toml").write_text(text, encoding="utf-8")
        (folder / "tedm.toml").write_text('title = "to be balanced"\nbalance = "balance.toml"\n', encoding="utf-8")
        model = (folder / "model.toml").read_text(encoding="utf-8")
        for old, new in replaced:
            assert model.count(old) == 1
            model = model.replace(old, new)
        (folder / "model.toml").write_text(model, encoding="utf-8")
        project = load_project(folder / "tedm.toml", folder / "build")
        if replaced:
            build_sensitivity(project, None, silent)
        return project

    return make
