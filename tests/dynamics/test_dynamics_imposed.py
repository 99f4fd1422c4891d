"""Figure 6.2: acceleration noise of imposed positions, against the thesis and against the stiffness in the files."""

from __future__ import annotations

import json

import h5py
import numpy as np
import pytest
from border_tools import Project, replace, untouched

from tedm_cli.contracts import IMPOSED
from tedm_cli.dynamics.imposed import MovedTestMass, of_model, published
from tedm_cli.files.store import open_checked
from tedm_cli.gravity.field import OTHER_TEST_MASS, SOURCES
from tedm_cli.results.dynamics.imposed import read_imposed


def test_numbers_of_the_thesis() -> None:
    """√2 Γ_xx 5 nm of the other test mass; with the LTP and its compensation masses by their tables."""
    thesis = published()
    alone = dict(zip(thesis.sources, thesis.gain_alone * 5e-9, strict=True))
    # pytest.approx takes 1e-12 as equal to nothing
    np.testing.assert_allclose(alone[OTHER_TEST_MASS], 3.4348e-17, rtol=1.5e-5)
    assert alone[OTHER_TEST_MASS] / 2.12e-15 == pytest.approx(0.016, abs=5e-4)
    np.testing.assert_allclose(thesis.gain * 5e-9, 1.1047e-16, rtol=5e-5)
    np.testing.assert_allclose(
        alone["structure"], 0.8529e-7 * 5e-9, rtol=1e-12
    )  # moves with the spacecraft: one motion, no √2


def test_parts_are_the_slopes_of_the_power() -> None:
    """The part of a source is half of how much per cent the power grows when it grows by one."""
    rng = np.random.default_rng(1)
    stiffness = 1e-8 * rng.normal(size=(3, 2))
    moved = MovedTestMass("m", "TM1", SOURCES, stiffness)
    assert moved.share.sum() == pytest.approx(1.0)
    for n in range(3):
        grown = stiffness.copy()
        grown[n] *= 1.0 + 1e-6
        power = (MovedTestMass("m", "TM1", SOURCES, grown).gain / moved.gain) ** 2
        assert (power - 1.0) / 2e-6 == pytest.approx(moved.share[n], rel=1e-4, abs=1e-5)
    assert not MovedTestMass("m", "TM1", SOURCES, 0.0 * stiffness).share.any()


def test_only_the_other_test_mass_moves_apart_from_the_spacecraft() -> None:
    one, two = of_model(
        ("A", "B"), (OTHER_TEST_MASS, "structure"), np.array([[3.0, -1.0], [2.0, 7.0]]), np.array([-4.0, 5.0])
    )
    assert (one.name, two.name) == ("A", "B")
    np.testing.assert_array_equal(one.stiffness, [[3.0, -4.0], [-1.0, 0.0]])
    assert two.gain == pytest.approx(np.hypot(9.0, 5.0))


def test_the_model_of_a_project(satellite: Project) -> None:
    """The noise is that of the linearised equations of motion in sensitivity.h5, by source and in total."""
    with h5py.File(satellite.build / "sensitivity.h5") as file:
        k, gamma = file["stiffness/linearised"][()], file["stiffness/gamma_lin"][()][:, :, 0, 0]
    done = satellite.run("simulate", "--figure-6.2").ok()
    assert "3.4348e-17" in done.out
    assert "1.1047e-16" in done.out
    with open_checked(satellite.build / "figure_6_2.h5", IMPOSED) as file:
        found = read_imposed(file)
    assert found.frequency_hz[[0, -1]].tolist() == [1e-3, 30e-3]
    assert set(found.motion) == {5e-9}
    np.testing.assert_allclose(found.limit.amplitude, 2.12e-15 * (1.0 + (found.frequency_hz / 3e-3) ** 2), rtol=1e-12)
    assert found.level == 2.12e-15
    thesis, *own = found.noises
    assert (thesis.test_mass, [n.test_mass for n in own]) == ("TM1", ["TM1", "TM2"])
    for i, n in enumerate(own):
        wanted = np.hypot(k[6 * i, 0], k[6 * i, 6]) * 5e-9
        np.testing.assert_allclose(n.asd, wanted, rtol=1e-12)
        assert n.ratio == pytest.approx(wanted / found.limit.amplitude[0], rel=1e-12)
        assert n.binding_hz == 1e-3
        assert list(n.alone) == ["structure", OTHER_TEST_MASS]
        np.testing.assert_allclose(n.alone["structure"], abs(gamma[i, 0]) * 5e-9, rtol=1e-12)
        np.testing.assert_allclose(n.alone[OTHER_TEST_MASS], np.sqrt(2.0) * abs(gamma[i, 1]) * 5e-9, rtol=1e-6)
        assert sum(n.share.values()) == pytest.approx(1.0)
    here = satellite.folder / "elsewhere.h5"
    printed = json.loads(satellite.run("simulate", "--figure-6.2", "--json", "-o", here).ok().out)
    assert here.is_file()
    assert [n["asd"] for n in printed["noise"]] == [n.asd[0] for n in found.noises]
    assert [n["alone"] for n in printed["noise"]][1] == {s: a[0] for s, a in own[0].alone.items()}


def test_what_figure_6_2_takes(satellite: Project) -> None:
    with untouched(satellite.folder):
        satellite.run("simulate", "3", "--figure-6.2").refused(2, "imposes the positions", "takes no case")
        satellite.run("simulate", "--figure-6.2", "--time").refused(2, "takes no --time")
        satellite.run("simulate", "--figure-6.2", "--problem", "x.json").refused(2, "takes no --problem")
        satellite.run("simulate", "--figure-6.2", "--fail-on-violation").refused(2, "takes no --fail-on-violation")
    replace(satellite.model, "[gravity]", "[gravity] # other")
    with untouched(satellite.folder):
        satellite.run("simulate", "--figure-6.2").refused(4, "sensitivity.h5", "stale")
