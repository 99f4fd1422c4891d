"""The chain on the small sample and on the independently solved model, each built once."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from shared_folder import shared

from tedm_cli.config.cases import select_cases
from tedm_cli.config.project import Project, load_project
from tedm_cli.progress import silent
from tedm_cli.stages.adjoint.build import build_adjoint
from tedm_cli.stages.gravity.sensitivity import build_sensitivity
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import ingest
from tedm_cli.stages.noise.case import run_cases
from tedm_cli.stages.optics.build import build_optics
from tedm_cli.stages.thermal.build import build_thermal

ROOT = Path(__file__).parents[2]
SMALL = ROOT / "sample_models" / "small"


def matrices(project: Project) -> None:
    """Everything from the unit loads to S_SG."""
    ingest(project, None, silent)
    build_distortion(project, None, silent)
    build_sensitivity(project, None, silent)


@pytest.fixture(scope="session")
def small(tmp_path_factory: pytest.TempPathFactory) -> Project:
    """The small sample, all stages up to the cases, with the adjoint and the thermal network."""
    return small_in(shared(tmp_path_factory, "small_cases", lambda folder: build_cases(small_in(folder))))


def small_in(folder: Path) -> Project:
    return load_project(SMALL / "tedm.toml", folder)


def build_cases(project: Project) -> None:
    matrices(project)
    build_optics(project, None)
    build_adjoint(project, None, silent)
    build_thermal(project, None, silent)
    run_cases(project, select_cases(project.cases, ["all"]), None, silent)


MINI_MODEL = """
[model]
deck = "{folder}/{stem}.bdf"
op2 = ["{folder}/{stem}.op2"]

[areas]
mid_half_width_m = 0.005
rule = [{{ match = "*", group = "all", shield = "inside" }}]

[[test_mass]]
name = "TM1"
position_m = [-0.188, 0.0, 0.0]
side_m = 0.046
mass_kg = 1.96

[[test_mass]]
name = "TM2"
position_m = [0.188, 0.0, 0.0]
side_m = 0.046
mass_kg = 1.96

[gravity]
mass_model = "lumped"  # as in the reference
"""

# Any layout will do as long as its elements ride on grids of the model: two photodiodes and two injectors.
MINI_OPTICS = """
title = "the optical grids of the independently solved model"
wavelength_m = 1.064e-6
read_out = ["x"]
frame = { origin_m = [0.0, 0.0, 0.0], axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] }
sets = { A = ["PD1"] }

[[element]]
name = "TM1"
kind = "test_mass"
ref_m = [-0.188, 0.0, 0.0]
normal = [1.0, 0.0, 0.0]
front_offset_m = 0.023

[[element]]
name = "FI1"
kind = "injector"
grid = 90001
ref_m = [-0.05, 0.03, 0.0]
normal = [-0.9578262852211514, -0.28734788556634544, 0.0]

[[element]]
name = "FI2"
kind = "injector"
grid = 90002
ref_m = [0.05, -0.03, 0.0]
normal = [0.0, 1.0, 0.0]

[[element]]
name = "PD1"
kind = "photodiode"
grid = 90003
ref_m = [0.0, 0.0, 0.0]
normal = [-1.0, 0.0, 0.0]
local_y = [0.0, 0.0, 1.0]

[[path]]
photodiode = "PD1"
beam = "meas"
steps = ["FI1", "TM1:R", "PD1"]

[[path]]
photodiode = "PD1"
beam = "ref"
steps = ["FI2", "PD1"]
"""


@pytest.fixture(scope="session")
def make_mini(mini_ltp_dir: Path, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Project]:
    """A function that builds the matrices of one of the independently solved decks."""

    def make(stem: str) -> Project:
        out = tmp_path_factory.mktemp(stem)
        (out / "tedm.toml").write_text('title = "mini"\n', encoding="utf-8")
        (out / "model.toml").write_text(MINI_MODEL.format(folder=mini_ltp_dir.resolve(), stem=stem), encoding="utf-8")
        (out / "optics.toml").write_text(MINI_OPTICS, encoding="utf-8")
        project = load_project(out / "tedm.toml", out / "build")
        matrices(project)
        return project

    return make


@pytest.fixture(scope="session")
def mini(make_mini: Callable[[str], Project]) -> Project:
    """Matrices of the independently solved model, from its deck and OP2."""
    return make_mini("mini_ltp")
