"""Differences of test masses are judged along axes that both have, and refused along others, before all work."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tedm_cli.config.cases import load_cases
from tedm_cli.config.differences import require_parallel
from tedm_cli.config.project import Project, load_project
from tedm_cli.errors import ConfigError
from tedm_cli.parallel_axes import PARALLEL_RAD, MassAxis, why_no_difference
from tedm_cli.progress import silent
from tedm_cli.stages.chain.make_rules import make_rules
from tedm_cli.stages.noise.case import run_cases
from tedm_cli.stages.noise.series import run_series

LISA = Path(__file__).parents[2] / "configs" / "lisa_like"
REQUIREMENT = '[[requirement]]\nname = "{}"\noutputs = ["{}"]\napplies_to = "differential"\n\n'
WARM = '[[series]]\nname = "warm"\nfile = "warm.csv"\nremove = "mean"\n\n'
STAGES: dict[str, Callable[[Project], object]] = {
    "run-case": lambda project: run_cases(project, ["1"], None, silent),
    "run-series": lambda project: run_series(project, ["warm"], None, silent),
    "make-rules": lambda project: make_rules(project, None),
}


def lisa_judging(folder: Path, output: str) -> Project:
    """The LISA-like project, nothing of it built, with one requirement on a difference besides its own."""
    shutil.copytree(LISA, folder, dirs_exist_ok=True)
    cases = folder / "cases.toml"
    name = "lpf_readout" if output.startswith(("A_", "B_")) else "lisa_acceleration"
    table = REQUIREMENT.format(name, output) + WARM
    cases.write_text(cases.read_text().replace("[[requirement]]", f"{table}[[requirement]]", 1))
    return load_project(folder / "tedm.toml", folder / "build")


@pytest.mark.parametrize("stage", STAGES)
@pytest.mark.parametrize("output", ["TM1_a_x-TM2_a_x", "A_TM1_x-A_TM2_x"])
def test_what_is_not_along_one_axis_is_refused(tmp_path: Path, stage: str, output: str) -> None:
    project = lisa_judging(tmp_path, output)
    with pytest.raises(ConfigError) as caught:
        STAGES[stage](project)
    fact = f"{output}: the x axes of TM1 and TM2 are not parallel (60 deg apart), so their difference is of no meaning"
    assert caught.value.problems == [("requirement[0].outputs[0]", fact)]
    assert caught.value.where == str(project.cases)
    assert not project.build_dir.exists()


@pytest.mark.parametrize(
    ("output", "axis"),
    [
        ("TM1_a_z-TM2_a_z", ""),
        ("TM1_omegadot_z-TM2_omegadot_z", ""),
        ("A_TM1_phi-A_TM2_phi", ""),  # about z
        ("A_TM1_x-B_TM1_x", ""),  # of one test mass
        ("TM1_a_y-TM2_a_y", "the y axes of TM1 and TM2 are not parallel (60 deg"),
        ("A_TM1_eta-A_TM2_eta", "the y axes of TM1 and TM2 are not parallel (60 deg"),
        ("TM2_a_x-TM1_a_y", "the x axis of TM2 and the y axis of TM1 are not parallel (150 deg"),
    ],
)
def test_only_the_components_that_need_it(tmp_path: Path, output: str, axis: str) -> None:
    project = lisa_judging(tmp_path, output)
    requirements = load_cases(project.cases)[1].applied_requirements()
    if not axis:
        require_parallel(project, requirements)
        return
    with pytest.raises(ConfigError) as caught:
        require_parallel(project, requirements)
    assert axis in caught.value.problems[0][1]


def test_self_gravity_is_along_the_axes_of_the_model_and_read_outs_along_those_of_the_layout(tmp_path: Path) -> None:
    turned, model = lisa_judging(tmp_path, "A_TM1_x-A_TM2_x"), tmp_path / "model.toml"
    lines = [line for line in model.read_text().splitlines() if not line.startswith("axes = ")]
    model.write_text("\n".join(lines))
    requirements = load_cases(turned.cases)[1].applied_requirements()
    with pytest.raises(ConfigError, match="A_TM1_x-A_TM2_x: the x axes"):
        require_parallel(turned, requirements)
    turned.cases.write_text(turned.cases.read_text().replace("A_TM1_x-A_TM2_x", "TM1_a_x-TM2_a_x"))
    require_parallel(turned, load_cases(turned.cases)[1].applied_requirements())


@pytest.mark.parametrize(("angle", "apart"), [(0.0, False), (0.9, False), (1.1, True), (np.pi / PARALLEL_RAD, True)])
def test_a_difference_bears_what_is_mounted_a_milliradian_apart(angle: float, apart: bool) -> None:
    second = np.array([np.cos(angle * PARALLEL_RAD), np.sin(angle * PARALLEL_RAD), 0.0])
    fact = why_no_difference(MassAxis("TM1", "x", np.array([1.0, 0.0, 0.0])), MassAxis("TM2", "x", second))
    assert bool(fact) == apart
