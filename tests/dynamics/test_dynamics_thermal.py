"""Temperatures as the loop feels them: areas that follow later than others, in frequency and in time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from border_tools import Project, replace
from dynamics_models import controlled, example_plant

from tedm_cli.config.project import load_project
from tedm_cli.contracts import OPTICS
from tedm_cli.dynamics.budget import budget
from tedm_cli.dynamics.in_time import respond, time_loop
from tedm_cli.dynamics.signals import COORDINATES, DISTURBANCES, STRAY
from tedm_cli.files.store import open_checked
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.correlation import Correlation
from tedm_cli.noise.propagation import TemperatureNoise
from tedm_cli.noise.temperature import white_model
from tedm_cli.results.optics import read_read_outs
from tedm_cli.stages.dynamics.thermal import ThermalRows, thermal_rows


@pytest.mark.parametrize("delay_s", [0.0, 7.0, 35.0])
def test_an_area_that_follows_later_does_so_in_the_loop(delay_s: float) -> None:
    """One area pulls at a test mass, the other moves its read-out: the sum depends on which of them comes first."""
    plant, step_s, frequency = example_plant(), 1.0, 5e-3
    control, labels = controlled(plant), ["TM2_x", "delta_g"]
    pull, motion = 3e-12, 2e-9
    acceleration, read_out = np.zeros((12, 2)), np.zeros((15, 2))
    acceleration[STRAY.index("TM2_a_x"), 0] = pull
    read_out[COORDINATES.index("TM2_x"), 1] = motion
    words = np.array(["first", "second"])
    areas = AreaTable(words, words, np.array(["inside"] * 2), np.array(["mid"] * 2), np.zeros((2, 3)))
    rows = ThermalRows(areas, np.array([1, 2]), acceleration, read_out, "A", list(STRAY), list(COORDINATES))
    together = Correlation.of_factor(np.ones((2, 1)), np.array([0.0, delay_s]))
    thermal = rows.driven_by(TemperatureNoise(white_model(areas, inside_K=1.0), together), np.array([frequency]))
    exact = budget(plant, control, [], thermal, np.array([frequency]), labels, difference_s=step_s).total[0]

    v = np.zeros((len(DISTURBANCES), 2))
    v[DISTURBANCES.index("s_TM2_a_x"), 0], v[DISTURBANCES.index("n_TM2_x"), 1] = pull, motion
    t = step_s * np.arange(120_000)
    signals = np.sin(2 * np.pi * frequency * (t - np.array([[0.0], [delay_s]])))
    loop = time_loop(plant, control, labels)
    series = np.concatenate(list(respond(loop, v, iter([signals]), step_s, ([0, 1],))), axis=-1)
    tail = slice(-1000, None)  # five periods, after what the beginning left has died
    wave = np.exp(2j * np.pi * frequency * t[1:-1][tail])
    amplitude = np.abs(2 * (series.reshape(len(labels), -1)[:, tail] @ wave.conj()) / len(wave))
    np.testing.assert_allclose(amplitude**2, exact, rtol=2e-3)  # straight between samples: sinc² of 5 mHz is 1 - 8e-5


@pytest.mark.parametrize("chosen", ["A", "B"])
def test_the_controller_hears_the_read_outs_of_the_chosen_set(built: Project, chosen: str) -> None:
    rows = thermal_rows(load_project(built.folder / "tedm.toml", built.build), chosen)
    with open_checked(built.build / "optics.h5", OPTICS) as file:
        found = read_read_outs(file)
    for label, row in zip(found.label, found.N[chosen], strict=True):
        np.testing.assert_array_equal(rows.read_out[COORDINATES.index(label)], row)


def test_a_test_mass_with_other_axes_is_felt_and_read_along_these(built: Project, tmp_path: Path) -> None:
    """TM2 turned by 180 degrees about z in both files: x, y, theta and eta change sign in S and N alike, no other does.

    Turned in one file alone it is refused.
    """
    here = thermal_rows(load_project(built.folder / "tedm.toml", built.build), "A")
    project = built.copy(tmp_path / "turned")
    turned = 'name = "TM2"\naxes = [[-1, 0, 0], [0, -1, 0], [0, 0, 1]]'
    replace(project.folder / "optics.toml", 'name = "TM2"', turned)
    project.run("build-optics").refused(
        3, "element[1].axes: x, y, z of TM2 are along (-1, 0, 0), (0, -1, 0), (0, 0, 1)"
    )
    replace(project.model, 'name = "TM2"', turned)
    replace(project.model, 'name = "lpf"', 'name = "lpf"\napplies_to = "single"')  # no differences along unlike axes
    project.run("build-optics").ok()
    project.run("build-sensitivity").ok()
    there = thermal_rows(load_project(project.folder / "tedm.toml", project.build), "A")
    for labels, was, now in (
        (STRAY, here.acceleration, there.acceleration),
        (COORDINATES, here.read_out, there.read_out),
    ):
        for label, a, b in zip(labels, was, now, strict=True):
            turns = label.startswith("TM2") and label.endswith(("_x", "_y", "_theta", "_eta"))
            np.testing.assert_allclose(b, -a if turns else a, rtol=1e-12, atol=1e-12 * np.abs(was).max())
