"""simulate-thermal: given disturbances against formulas, realisations against the gains, tables, and refusals."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import numpy as np
import pytest
from thermal_project import ThermalProject

from tedm_cli.stages.thermal import disturbances
from tedm_cli.thermal import stepping

STEP, ROWS = 500.0, 900
NODES = ["SHIELD", "OB", "BOX", "JOINT", "SC", "SPACE"]


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> ThermalProject:
    """With thermal.h5. Its configuration is not to be changed."""
    project = ThermalProject(tmp_path_factory.mktemp("in_time") / "network")
    project.run("build-thermal").ok()
    return project


@pytest.fixture
def changing(tmp_path: Path) -> ThermalProject:
    return ThermalProject(tmp_path / "network")


def write(project: ThermalProject, columns: dict[str, np.ndarray], name: str = "u.csv", step: float = STEP) -> Path:
    rows = len(next(iter(columns.values())))
    table = np.column_stack([100.0 + step * np.arange(rows), *columns.values()])
    path = project.folder / name
    np.savetxt(path, table, "%.17g", ",", header=",".join(["time_s", *columns]), comments="")
    return path


def read(path: Path) -> tuple[list[str], np.ndarray]:
    with open(path) as file:
        return file.readline().strip().split(","), np.loadtxt(file, delimiter=",")


def static(project: ThermalProject) -> np.ndarray:
    with project.file() as file:
        return file["static_gain"][()]


def test_constant_disturbances_keep_what_their_gains_say(
    built: ThermalProject, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(disturbances, "_PIECE", 7)
    path = write(built, {"bus": np.full(30, 0.5), "panel": np.full(30, -0.1)})
    out = built.folder / "t.csv"
    told = built.run("simulate-thermal", path, "-o", out).ok().out
    head, table = read(out)
    assert head == ["time_s", *NODES]
    assert table[:, 0].tolist() == (100.0 + STEP * np.arange(30)).tolist()
    expected = static(built) @ np.array([-0.1, 0.5])
    assert np.abs(table[:, 1:5] - expected).max() < 1e-10
    assert (table[:, 5] == -0.1).all()
    assert (table[:, 6] == 0.0).all()
    assert "30 samples of 500 s over 14500 s" in told
    assert "steps exact" in told
    assert 'a [[series]] of = "nodes"' in told
    assert f"{1.5 * max(np.abs(expected[:3])) / 293:.0e}"[0] in told


def test_a_sine_comes_out_with_its_gain(built: ThermalProject) -> None:
    """Slow beside the samples: of one disturbance, with the other constant and said to be."""
    with built.file() as file:
        frequency, H = file["frequency"][()], file["transfer"][()]
    f, step = float(frequency[1]), 100.0
    turn = 2.0 * np.pi * f * step * np.arange(20_000)
    path = write(built, {"bus": 0.1 * np.cos(turn)}, step=step)
    out = built.folder / "t.h5"
    told = built.run("simulate-thermal", path, "-o", out, "--top", "2").ok().out
    assert ["panel", "constant", "constant", "K"] in [line.split() for line in told.splitlines()]
    assert "2 more nodes move less" in told
    last = slice(10_000, 20_000)  # a whole number of periods
    with h5py.File(out) as file:
        assert sorted(file) == sorted(["time_s", *NODES])
        found = np.array([2.0 / 10_000 * np.sum(file[n][last] * np.exp(-1j * turn[last])) for n in NODES[:4]])
        assert not file["SC"][()].any()
    assert np.abs(found / (0.1 * H[1, :, 1]) - 1.0).max() < 1e-3


def test_implicit_steps_say_their_error(built: ThermalProject, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(1)
    path = write(built, {"bus": rng.standard_normal(200), "panel": 1e-2 * rng.standard_normal(200)})
    said = [json.loads(built.run("simulate-thermal", path, "-o", built.folder / "a.csv", "--json").ok().out)]
    monkeypatch.setattr(stepping, "SMALL", 0)
    said.append(json.loads(built.run("simulate-thermal", path, "-o", built.folder / "b.csv", "--json").ok().out))
    assert [s["exact"] for s in said] == [True, False]
    off = np.abs(read(built.folder / "a.csv")[1] - read(built.folder / "b.csv")[1])[:, 1:5].max(axis=0)
    by_name = {n["name"]: n["error_K"] for n in said[1]["nodes"]}
    told = np.array([by_name[name] for name in NODES[:4]])
    assert (off < 2.0 * told + 1e-12).all()
    assert (told < 20.0 * off + 1e-12).all()
    assert "implicit steps" in built.run("simulate-thermal", path).ok().out


def test_spectra_of_a_realisation_are_those_of_the_gains(built: ThermalProject) -> None:
    """And with a gain that is wrong by a fifth it says that they are not."""
    args = ("simulate-thermal", "--duration", "4e6", "--seed", "4", "--json")
    out = built.folder / "r.h5"
    said = json.loads(built.run(*args, "-o", out).ok().out)
    check = said["check"]
    assert said["samples"] == 200_001
    assert said["step_s"] == 20.0
    assert check["agrees"]
    assert check["inside"] > 0.5
    low, high = check["mean_ratio_allowed"]
    assert 0.7 < low < 0.95 < 1.05 < high < 1.4
    assert check["nodes"] == 4
    assert all(low < ratio < high for ratio in check["mean_ratio"])
    assert check["frequency_hz"] == pytest.approx([3e-4, 1e-3, 3e-3, 1e-2], rel=0.02)
    assert 0.0 < check["samples_change"] < 0.05
    # The disturbances have the variance of their straight lines: that of the panel is known, white up to 0.025 Hz.
    with h5py.File(out) as file:
        first, boundary = file["OB"][()], file["SC"][()]
    assert abs(first[0]) > 1e-2 * first.std()  # it ran before
    assert said["disturbances"][0]["rms"] == pytest.approx(boundary.std(), rel=1e-2)
    level = 1e-3 / np.sinc(np.minimum(np.linspace(0.0, 0.025, 4001), 1e-2) * 20.0) ** 2
    assert boundary.std() == pytest.approx(np.sqrt(np.mean(level**2) * 0.025), rel=0.02)
    built.run(*args, "-o", out).ok()
    with h5py.File(out) as file:
        assert (file["OB"][()] == first).all()
    other = json.loads(built.run(*args[:3], "--json").ok().out)
    assert other["seed"] == 1
    assert other["nodes"][0]["rms_K"] != said["nodes"][0]["rms_K"]


def test_spectra_that_are_wrong_are_told(changing: ThermalProject, monkeypatch: pytest.MonkeyPatch) -> None:
    changing.run("build-thermal").ok()
    from tedm_cli.stages.thermal import simulate

    right = simulate.read_network

    def wrong(file):
        found = right(file)
        found.transfer[:] *= 1.2
        return found

    monkeypatch.setattr(simulate, "read_network", wrong)
    assert "spectra DO NOT AGREE" in changing.run("simulate-thermal", "--duration", "4e6").ok().out


def test_short_realisations_have_no_check(built: ThermalProject) -> None:
    out = built.run("simulate-thermal", "--duration", "1e4").ok().out
    assert "too short to compare spectra" in out


@pytest.mark.parametrize(
    ("columns", "code", "fact", "hint"),
    [
        ({"bus": np.ones(5), "pannel": np.ones(5)}, 4, "columns that are no disturbance: pannel", "did you mean panel"),
        ({"bus": np.array([1.0, np.nan, 2.0])}, 4, "u.csv:3: bus is nan", ""),
        ({"bus": np.ones(1)}, 4, "needs two rows or more", ""),
        ({"panel": np.full(3, 2e4)}, 4, "is outside -10000 to 10000 K", ""),
        ({"bus": np.full(3, 2e10)}, 4, "power 2e+10 is outside", ""),
    ],
)
def test_tables_that_are_refused(built: ThermalProject, columns, code: int, fact: str, hint: str) -> None:
    out = built.folder / "not.csv"
    built.run("simulate-thermal", write(built, columns), "-o", out).refused(code, fact, hint=hint)
    assert not out.exists()


def test_what_else_is_refused(built: ThermalProject) -> None:
    path = write(built, {"bus": np.ones(5)})
    simulate = ("simulate-thermal",)
    built.run(*simulate).refused(2, "name a file of disturbances, or the --duration", hint="tedm simulate-thermal")
    built.run(*simulate, path, "--seed", "2").refused(2, "--seed is of a realisation")
    built.run(*simulate, path, "-o", "t.txt").refused(2, "must end in .csv")
    built.run(*simulate, path, "-o", path).refused(2, "is a file that is read")
    nodes = built.folder / "nodes.csv"
    built.run(*simulate, path, "-o", nodes).refused(2, "is a file that is read")
    built.run(*simulate, "--duration", "0").refused(2, "--duration: duration 0 is outside")
    built.run(*simulate, "--duration", "nan").refused(2, "--duration: duration nan")
    built.run(*simulate, "--duration", "1e5", "--step", "60").refused(2, "too long for the frequencies", hint="50 s")
    built.run(*simulate, "--duration", "1e5", "--seed", "-1").refused(2, "--seed: seed -1 is outside")
    built.run(*simulate, "--duration", "9e9").refused(2, "--duration: duration 9e+09 is outside")
    built.run(*simulate, "--duration", "9e8", "--step", "1").refused(4, "are too many", hint="--step")
    built.run(*simulate, built.folder / "none.csv").refused(4, "none.csv")
    text = path.read_text().splitlines()
    path.write_text("\n".join([*text[:3], *text[4:]]) + "\n")
    built.run(*simulate, path).refused(4, "a gap of 1000 s", hint="equally far apart")
    path.write_text("\n".join([*text[:3], text[4], text[3]]) + "\n")
    built.run(*simulate, path).refused(4, "time_s is", hint="equally far apart")


def test_a_network_that_changed_is_refused(changing: ThermalProject) -> None:
    simulate = ("simulate-thermal", "--duration", "1e4")
    changing.run(*simulate).refused(4, "no such file; the network is taken from it", hint="build-thermal")
    changing.run("build-thermal").ok()
    changing.change("powers.csv", "BOX,2", "BOX,2.5")
    changing.run(*simulate).refused(4, "is stale", hint="build-thermal")
    text = (changing.folder / "thermal.toml").read_text()
    (changing.folder / "thermal.toml").write_text(text[: text.index("[[disturbance]]")])
    changing.run(*simulate).refused(3, "has no [[disturbance]]: nothing moves in time")
    (changing.folder / "thermal.toml").write_text("[map]\nareas = true\n")
    changing.run(*simulate).refused(3, "has no [network] and no [[disturbance]]")
    (changing.folder / "tedm.toml").write_text('title = "none"\n')
    changing.run(*simulate).refused(3, "thermal")


def test_names_that_a_table_cannot_hold(changing: ThermalProject) -> None:
    for name in ("nodes.csv", "conductors.csv"):
        path = changing.folder / name
        path.write_text(path.read_text().replace("SHIELD", "MLI/1"))
    changing.run("build-thermal").ok()
    u = write(changing, {"bus": np.ones(5)})
    refused = changing.run("simulate-thermal", u, "-o", changing.folder / "t.h5")
    refused.refused(4, "a column cannot be called 'MLI/1'", hint="take a .csv")
    changing.run("simulate-thermal", u, "-o", changing.folder / "t.csv").ok()
    assert read(changing.folder / "t.csv")[0][1] == "MLI/1"
