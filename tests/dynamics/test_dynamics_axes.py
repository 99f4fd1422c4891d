"""Test masses whose x axes are not parallel: no default controller, no Δg, a loop by gains of one's own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from border_tools import Project, untouched
from border_tools import replace as replace_text
from dynamics_models import example_plant

from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import load_project
from tedm_cli.contracts import DYNAMICS, SIMULATION
from tedm_cli.dynamics.bodies import x_axes_apart_rad, x_axes_are_parallel
from tedm_cli.dynamics.budget import budget
from tedm_cli.dynamics.controller import default_controller, default_loops
from tedm_cli.dynamics.plant import Plant
from tedm_cli.dynamics.signals import COORDINATES, DELTA_G, INPUTS, OUTPUTS
from tedm_cli.errors import PhysicsError
from tedm_cli.files.store import open_checked
from tedm_cli.parallel_axes import PARALLEL_RAD
from tedm_cli.results.dynamics.no_loop import why_no_loop
from tedm_cli.stages.dynamics import thermal

HERE = np.array([1e-3, 1e-2])


def turned(angle_rad: float, axis: int = 2) -> Plant:
    """The satellite of the worked example with its second test mass and housing turned about an axis."""
    plant = example_plant()
    first, second = plant.test_masses
    i, j = [k for k in range(3) if k != axis]
    rotation = np.eye(3)
    rotation[[i, j], [i, j]] = np.cos(angle_rad)
    rotation[i, j], rotation[j, i] = np.sin(angle_rad), -np.sin(angle_rad)
    return Plant(plant.spacecraft, [first, replace(second, axes=rotation @ second.axes)], plant.fixed, plant.mutual)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.9 * PARALLEL_RAD, 1.1 * PARALLEL_RAD, 5e-3, np.pi / 3, np.pi])
def test_the_angle_between_the_x_axes(angle: float) -> None:
    axes = turned(angle).axes
    assert x_axes_apart_rad(axes) == pytest.approx(angle, abs=1e-15, rel=1e-6)
    assert x_axes_are_parallel(axes) == (angle < PARALLEL_RAD)
    assert x_axes_are_parallel(turned(angle, axis=0).axes)  # about x itself


def test_the_default_controller_is_refused_by_name() -> None:
    with pytest.raises(PhysicsError, match=r"default controller .* parallel; these are 60° apart") as caught:
        default_controller(turned(np.pi / 3), default_loops())
    assert "a controller of your own" in caught.value.hint


def test_outputs_are_all_but_delta_g() -> None:
    plant, nominal = turned(2.0 * PARALLEL_RAD), turned(0.0)
    assert plant.outputs == tuple(name for name in OUTPUTS if name not in DELTA_G)
    assert len(plant.outputs) == 72
    assert nominal.outputs == OUTPUTS
    assert budget(plant, None, [], None, HERE).labels == plant.outputs
    assert budget(nominal, None, [], None, HERE).labels == OUTPUTS


@pytest.fixture
def two_lasers(satellite: Project) -> Project:
    """The small sample with its second test mass turned by 3 mrad: too far for Δg, near enough for the same gains."""
    c, s = float(np.cos(3e-3)), float(np.sin(3e-3))
    replace_text(
        satellite.model, 'name = "TM2"\n', f'name = "TM2"\naxes = {[[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]}\n'
    )
    replace_text(satellite.model, 'name = "lpf"', 'name = "lpf"\napplies_to = "single"')  # as for Δg: no differences
    satellite.run("build-sensitivity").ok()
    return satellite


def test_a_loop_with_a_controller_of_ones_own(two_lasers: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    """The default controller is refused, Δg as well, and the same gains from a file run."""
    folder = two_lasers.folder
    monkeypatch.setattr(thermal, "_AXES", 1.0, raising=False)  # the layout has one frame for both test masses
    with untouched(folder):
        two_lasers.run("build-dynamics").refused(5, "dynamics.toml: the default controller", "0.1719° apart")
    with open_checked(two_lasers.build / "dynamics.h5", DYNAMICS) as file:  # of the test masses as they were
        gains = {name: file.array(f"/controller/{name}") for name in "ABCD"}
    np.savez(folder / "own.npz", inputs=np.array(COORDINATES), outputs=np.array(INPUTS), **gains)
    (folder / "dynamics.toml").write_text('[controller]\nfile = "own.npz"\n')
    two_lasers.run("build-dynamics").ok()
    two_lasers.run("simulate", "3").ok()
    with open_checked(two_lasers.build / "simulation03.h5", SIMULATION) as file:
        assert set(file.strings(SIMULATION.OUTPUT_LABEL)) == set(OUTPUTS) - set(DELTA_G)
        assert file.strings(SIMULATION.VERDICT_OUTPUT) == ["TM1_a_x", "TM2_a_x", "TM1_x"]  # defaults without Δg
    with open_checked(two_lasers.build / "dynamics.h5", DYNAMICS) as file:
        assert not set(DELTA_G) & set(file.strings(DYNAMICS.SYSTEM_OUTPUT))
        assert file.array(DYNAMICS.SYSTEM_C).shape[0] == 72
    requirement = '[[requirement]]\nname = "lpf_acceleration"\noutputs = ["delta_g"]\napplies_to = "differential"\n'
    (folder / "dynamics.toml").write_text(f'[controller]\nfile = "own.npz"\n{requirement}')
    two_lasers.run("build-dynamics").ok()
    with untouched(folder):
        two_lasers.run("simulate", "3").refused(3, "requirement[0].outputs: delta_g is of test masses whose x axes are")


def test_make_leaves_the_default_loop_out(two_lasers: Project) -> None:
    """With no file of dynamics, and the report says why; with one, it is what the user wants."""
    for text, named in (('title = "t"\n', False), ('title = "t"\ndynamics = "dynamics.toml"\n', True)):
        (two_lasers.folder / "tedm.toml").write_text(text)
        two_lasers.run("make-rules").ok()
        assert ("simulation03.h5" in (two_lasers.build / "rules.mk").read_text()) == named
        project = load_project(two_lasers.folder / "tedm.toml", two_lasers.build)
        why = why_no_loop(project, load_model(project.model)[1])
        assert (why == "") == named
        assert named or "default controller and Δg need test masses whose x axes are parallel" in why
        assert named or "TM1 and TM2 are 0.1719° apart" in why
