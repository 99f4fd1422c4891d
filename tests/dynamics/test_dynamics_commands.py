"""The commands on the drag-free loop: what they refuse and say, what they print for programs, and what they leave."""

from __future__ import annotations

import copy
import json
import os
import signal
import sys
from pathlib import Path
from typing import Any
from unittest import mock

import h5py
import numpy as np
import pytest
from border_tools import Project, edited, in_child, snapshot, tedm, untouched
from dynamics_models import EXAMPLE, example
from scipy.io import savemat

from tedm_cli.files import store

UNSTABLE = 'inputs = ["TM1_x"]\noutputs = ["SC_Fx"]\nD = [[1.0]]\n'
FAST = """
[[requirement]]
name = "lpf_acceleration"
outputs = ["delta_g"]
applies_to = "differential"
[time]
samples = 16384
"""


def configure(project: Project, text: str) -> None:
    (project.folder / "dynamics.toml").write_text(text)


REFUSED = {
    "unknown keys": ("[spacecraft]\nmas_kg = 1.0\n[foo]\n", 3, ["spacecraft.mas_kg: unknown key", "foo: unknown key"]),
    "no body": ("[spacecraft]\ninertia_kg_m2 = [1.0, 1.0, 100.0]\n", 5, ["largest exceeds the sum"]),
    "not symmetric": (
        "[spacecraft]\ninertia_matrix_kg_m2 = [[100.0, 1.0, 0.0], [0.0, 100.0, 0.0], [0.0, 0.0, 100.0]]\n",
        5,
        ["not symmetric"],
    ),
    "indefinite": ("[spacecraft]\ninertia_kg_m2 = [-1.0, 1.0, 1.0]\n", 5, ["must be positive"]),
    "read-out set": ('[read_out]\nset = "Z"\n', 3, ["read_out.set", "'Z'", "there are A, B"]),
    "improper": (
        '[[controller.loop]]\nname = "x12"\nnumerator = [1.0, 1.0, 1.0]\ndenominator = [1.0, 1.0]\n',
        5,
        ["loop x12 is improper"],
    ),
    "unstable": ('[[controller.loop]]\nname = "x12"\ncrossover_hz = 1.0\n', 5, ["unstable", "moves TM2_x most"]),
    "unknown loop": ('[[controller.loop]]\nname = "x21"\ncrossover_hz = 1.0\n', 3, ["no loop is called 'x21'"]),
    "own, unknown name": ('[controller]\nfile = "unknown.toml"\n', 5, ["unknown.toml", "TM1_w"]),
    "own, repeated name": ('[controller]\nfile = "twice.toml"\n', 5, ["twice.toml", "TM1_x"]),
    "own, unstable": ('[controller]\nfile = "unstable.toml"\n', 5, ["unstable", "rad/s moves "]),
    "own, missing": ('[controller]\nfile = "no.npz"\n', 4, ["no.npz"]),
    "own, delay is no number": ('[controller]\nfile = "delay.npz"\n', 4, ["delay.npz: delay_s: delay nan is outside"]),
    "own, too large": ('[controller]\nfile = "large.npz"\n', 4, ["large.npz: D[1, 1]: matrix entry 1e+30 is outside"]),
    "own, too large in MAT": ('[controller]\nfile = "large.mat"\n', 4, ["large.mat: dt_s: duration 1e+20 is outside"]),
    "own, complex": ('[controller]\nfile = "complex.npz"\n', 4, ["complex.npz", "D is no matrix of real numbers"]),
    "no table": ('[[noise.source]]\nname = "sun_Fz"\ntable = "no.csv"\n', 4, ["no.csv: cannot be read"]),
    "no disturbance": (
        '[[noise.source]]\nname = "a"\nlevel = 1e-9\ngains = { w_foo = 1.0 }\n',
        3,
        ["dynamics.toml: noise.source[0].gains", "'w_foo' is no disturbance"],
    ),
    "group of the temperatures": (
        '[[noise.source]]\nname = "a"\ngroup = "thermal"\nlevel = 1e-9\ngains = { w_SC_Fx = 1.0 }\n',
        3,
        ["dynamics.toml: noise.source[0]", "'thermal' is of the temperatures"],
    ),
    "one source twice": (
        '[[noise.source]]\nname = "sun_Fz"\nlevel = 1e-9\n[[noise.source]]\nname = "sun_Fz"\nlevel = 2e-9\n',
        3,
        ["source sun_Fz is there twice"],
    ),
    "nothing to omit": ('[noise]\nomit = ["sum"]\n', 3, ["noise.omit[0]: 'sum'"]),
    "nothing at all to omit": (
        '[noise]\npreset = "none"\nomit = ["sun"]\n',
        3,
        ['noise.omit: there is nothing to leave out: the preset is "none"'],
    ),
    "unstable by electrostatics": (
        "[stiffness.electrostatic]\nTM1 = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]\nTM2 = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]\n",
        5,
        ["unstable: a pole at 1 "],
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refused_by_build_dynamics(satellite: Project, name: str) -> None:
    text, code, pieces = REFUSED[name]
    folder = satellite.folder
    configure(satellite, text)
    (folder / "unstable.toml").write_text(UNSTABLE)
    (folder / "unknown.toml").write_text(UNSTABLE.replace("TM1_x", "TM1_w"))
    (folder / "twice.toml").write_text('inputs = ["TM1_x", "TM1_x"]\noutputs = ["SC_Fx"]\nD = [[1.0, 1.0]]\n')
    names = {"inputs": ["TM1_x"], "outputs": ["SC_Fx"]}
    np.savez(folder / "delay.npz", **names, D=np.eye(1), delay_s=np.nan)
    np.savez(folder / "large.npz", **names, D=1e30 * np.eye(1))
    cells = {name: np.array(value, dtype=object) for name, value in names.items()}
    savemat(folder / "large.mat", cells | {"D": np.eye(1), "dt_s": 1e20})
    np.savez(folder / "complex.npz", **names, D=1j * np.eye(1))
    with untouched(folder):
        satellite.run("build-dynamics").refused(code, *pieces)


def test_leading_zeros_of_a_transfer_function(satellite: Project) -> None:
    """They say nothing: 0 s³ + n(s) is n(s)."""
    loop = '[[controller.loop]]\nname = "TM1_x"\nnumerator = [{}3.0]\ndenominator = [1e-3, 1.0]\n'
    said = []
    for zeros in ("", "0.0, 0.0, 0.0, "):
        configure(satellite, loop.format(zeros))
        said.append(satellite.run("build-dynamics").err)
    assert said[0] == said[1]
    assert "internal" not in said[1]


@pytest.mark.parametrize(
    ("text", "code", "pieces"),
    [
        ('[[noise.source]]\nname = "sun_Fz"\ntable = "narrow.csv"\n', 4, ["small/narrow.csv", "0.001 to 0.01 Hz"]),
        (
            '[[requirement]]\nname = "lpf_acceleration"\noutputs = ["delta_h"]\napplies_to = "differential"\n',
            3,
            ["dynamics.toml: requirement[0].outputs", "no output 'delta_h'"],
        ),
    ],
)
def test_refused_by_simulate(satellite: Project, text: str, code: int, pieces: list[str]) -> None:
    (satellite.folder / "narrow.csv").write_text("frequency_hz,amplitude\n1e-3,1e-9\n1e-2,1e-9\n")
    configure(satellite, text)
    satellite.run("build-dynamics").ok()
    with untouched(satellite.folder):
        satellite.run("simulate", "3").refused(code, *pieces)


@pytest.mark.parametrize(
    ("text", "piece"),
    [
        ("requirement = []\n", "no requirement applies"),
        ("[time]\nrate_hz = 1e-4\n", "time.rate_hz: 0.0001 Hz"),
        ("[time]\nsamples = 100000\n", "time.samples: 100,000 at 0.5 Hz are too few for a spectrum from 0.0001 Hz"),
    ],
)
def test_nothing_to_realise(satellite: Project, text: str, piece: str) -> None:
    configure(satellite, text)
    satellite.run("build-dynamics").ok()
    with untouched(satellite.folder):
        satellite.run("simulate", "3", "--time").refused(4, "dynamics.toml", piece)


def test_missing_and_stale_files(satellite: Project) -> None:
    configure(satellite, "")
    fix = "tedm build-dynamics"
    with untouched(satellite.folder):  # dynamics.h5 is of the defaults
        satellite.run("simulate", "3").refused(4, "dynamics.h5", "stale", hint=fix)
    satellite.run("build-dynamics").ok()
    configure(satellite, "# other\n")
    satellite.run("simulate", "3").refused(4, "dynamics.h5", "stale", hint=fix)
    configure(satellite, "")
    for name in ("sensitivity.h5", "optics.h5"):
        kept = (satellite.build / name).read_bytes()
        with edited(satellite.build / name) as file:
            file.attrs["title"] = "another"
        satellite.run("simulate", "3").refused(4, "dynamics.h5", name, hint=fix)
        (satellite.build / name).write_bytes(kept)
    satellite.run("simulate", "3").ok()
    (satellite.build / "dynamics.h5").unlink()
    with untouched(satellite.folder):
        satellite.run("simulate", "3").refused(4, "dynamics.h5: no such file", hint=fix)


def test_a_layout_turned_against_the_test_masses(satellite: Project) -> None:
    """About y, which leaves the symmetry plane where it is. The rounding of a drawing is told of, more is refused."""
    layout = satellite.folder / "optics.toml"
    lines = [line for line in layout.read_text().splitlines() if line.startswith(("frame", "axes"))]
    assert len(lines) == 1, "the layout says its axes in one line"
    text, start = layout.read_text(), lines[0].index("axes")

    def turn(angle: float) -> None:
        c, s = np.cos(angle), np.sin(angle)
        turned = f"axes = [[{c}, 0.0, {-s}], [0.0, 1.0, 0.0], [{s}, 0.0, {c}]]"
        end = " }" if lines[0].rstrip().endswith("}") else ""
        layout.write_text(text.replace(lines[0], lines[0][:start] + turned + end))

    turn(0.01)
    with untouched(satellite.folder):
        satellite.run("build-optics").refused(3, "element[0].axes: x, y, z of TM1 are along (0.99995, 0, -0.009999833)")
    turn(5e-5)
    assert "5e-05 rad (0.00286 deg) apart" in satellite.run("build-optics").ok().out
    satellite.run("build-dynamics").ok()


def test_what_simulate_prints(satellite: Project, tmp_path: Path) -> None:
    configure(satellite, "")
    satellite.run("build-dynamics", "-q").ok()
    here = tmp_path / "elsewhere.h5"
    done = satellite.run("simulate", "3", "--json", "-o", here, "--fail-on-violation")
    assert done.code == 5
    assert "requirements are violated in case 3" in done.err
    (case,) = json.loads(done.out)
    assert case["file"] == str(here)
    assert here.is_file()
    with h5py.File(here) as file:
        assert [v["ratio"] for v in case["verdicts"]] == file["verdict/ratio"][()].tolist()
    assert case["passed"] is all(v["passed"] for v in case["verdicts"]) is False
    assert satellite.run("simulate", "3", "-q").ok().out == ""
    said = satellite.run("simulate", "3").ok().out
    assert "in the case that decides" not in said
    for v in case["verdicts"]:
        (line,) = [line for line in said.splitlines() if line.startswith(f"{v['output']}, {v['requirement']}: ")] or [
            ""
        ]
        if v["passed"]:
            assert not line
        elif v["factor_alone"]:
            assert all(f"{group} at " in line for group in v["factor_alone"])
            assert "no group alone" not in line
        else:
            assert len(v["together"]["groups"]) > 1
            assert all(group in line for group in ["no group alone", *v["together"]["groups"]])
    satellite.run("simulate").refused(2, "name a case, or all")
    satellite.run("simulate", "3", "2", "-o", here).refused(2, "--output names one file")


def test_a_realisation_is_as_loud_as_expected(satellite: Project) -> None:
    configure(satellite, FAST)
    satellite.run("build-dynamics").ok()
    satellite.run("simulate", "3", "--time").ok()
    with h5py.File(satellite.build / "simulation03.h5") as file:
        r = {name: file[f"realisation/{name}"][()] for name in ("psd", "exact", "degrees_of_freedom", "samples")}
    assert r["samples"] == 16384
    independent = r["degrees_of_freedom"].sum() / 2.0
    mean = (r["psd"] / r["exact"]).mean(axis=1)
    assert np.abs(mean - 1.0).max() < 0.01 + 6.0 / np.sqrt(independent)


def test_a_realisation_is_begun_at_any_rate(satellite: Project) -> None:
    """Shapes that sources share are fitted once, as far as estimates see: a slow one is not fitted for minutes."""
    configure(satellite, "[time]\nrate_hz = 1e-3\nsamples = 2048\n")
    satellite.run("build-dynamics").ok()
    done = satellite.run("simulate", "3", "--time").ok()
    assert "realised in time, 2,048 samples at 0.001 Hz; mean of estimate over exact: delta_g " in done.out


def test_coordinates_are_let_go(satellite: Project, tmp_path: Path) -> None:
    """What is printed is what is in the file; everything is back in the end."""
    configure(satellite, FAST)
    satellite.run("build-dynamics").ok()
    for text, piece in (
        ("TM1_w=1", "no coordinate is called 'TM1_w'"),
        ("TM1_x", "'TM1_x' is no coordinate with a number"),
        ("TM1_x=1e9", "offset 1e+09 is outside"),
        ("TM1_x=1,TM1_x=2", "names TM1_x twice"),
    ):
        satellite.run("simulate", "--release", text).refused(2, piece)
    satellite.run("simulate", "3", "--release", "TM1_x=1e-6").refused(2, "--release runs in place of cases")
    satellite.run("simulate", "--release", "TM1_x=1e-6", "--time").refused(2, "takes no --time")
    said = json.loads(satellite.run("simulate", "--release", "TM1_x=1e-6, SC_phi=-1e-7", "--json").ok().out)
    with h5py.File(satellite.build / "release.h5") as file:
        series = {o["output"]: file[f"series/{o['output']}"][()] for o in said["outputs"]}
        time = file["time"][()]
    assert (series["TM1_x"][0], series["SC_phi"][0], series["TM2_x"][0]) == (1e-6, -1e-7, 0.0)
    for o in said["outputs"]:
        values = np.abs(series[o["output"]])
        assert o["peak"] == values.max()
        small = np.append(np.flatnonzero(values > 0.01 * o["peak"]), -1)[:-1]
        after = small[-1] + 1 if len(small) else 0
        assert (o["settled_s"] is None) == (after == len(time))
        assert o["settled_s"] is None or o["settled_s"] == time[after]
    assert {o["output"]: o["settled_s"] for o in said["outputs"]}["TM1_x"] < 100.0
    assert "peak 1e-06 m" in tedm("show", satellite.build / "release.h5").ok().out


def problem_file(folder: Path, problem: dict[str, Any]) -> Path:
    path = folder / "problem.json"
    path.write_text(json.dumps(problem))
    return path


def test_a_problem_is_solved_as_with_fifty_digits() -> None:
    done = tedm("simulate", "--problem", EXAMPLE, "--json").ok()
    ours, wanted = json.loads(done.out), example()["result"]
    assert set(ours) == {"output", "frequency_hz", "psd_total", "psd", "stability"}
    np.testing.assert_allclose(ours["psd_total"], wanted["psd_total"], rtol=1e-9)
    assert done.err == ""


def spoil(*path: Any, value: Any) -> dict[str, Any]:
    """The worked example with one value changed."""
    problem = copy.deepcopy({k: v for k, v in example().items() if k not in ("result", "matrices", "free_response")})
    at: Any = problem
    for key in path[:-1]:
        at = at[key]
    at[path[-1]] = value
    return problem


@pytest.mark.parametrize(
    ("path", "value", "code", "piece"),
    [
        (("frequency_hz",), [0.0, 1e-3], 3, "frequency_hz"),
        (("frequency_hz",), [], 3, "frequency_hz"),
        (("temperature",), None, 3, "needs both sensitivity and temperature"),
        (("source", 0, "group"), "thermal", 3, "is of the temperatures"),
        (("test_mass", 0, "mass_kg"), "heavy", 3, "test_mass[0].mass_kg"),
        (("controller", "loops", "x12", "crossover_hz"), 1.0, 5, "unstable"),
        (("stiffness", "mutual"), [[0.0]], 4, "stiffness.mutual is 1 x 1"),
        (("source", 0, "input"), {"w_foo": 1.0}, 4, "w_foo"),
        (("nonsense",), 1, 3, "nonsense: unknown key"),
    ],
)
def test_problems_that_are_refused(tmp_path: Path, path: tuple[Any, ...], value: Any, code: int, piece: str) -> None:
    file = problem_file(tmp_path, spoil(*path, value=value))
    done = tedm("simulate", "--problem", file, "--json")
    assert done.out == ""
    done.refused(code, "problem.json", piece)


def test_test_masses_at_one_x(tmp_path: Path) -> None:
    problem = spoil("title", value="")
    first, second = (tm["position_m"] for tm in problem["test_mass"])
    problem["test_mass"][1]["position_m"] = [first[0], second[1] + 0.3, second[2]]
    tedm("simulate", "--problem", problem_file(tmp_path, problem)).refused(5, "problem.json", "they are at one x")


def test_problems_take_no_case_and_write_no_file(tmp_path: Path) -> None:
    tedm("simulate", "3", "--problem", EXAMPLE).refused(2, "takes no case")
    tedm("simulate", "--problem", EXAMPLE, "-o", tmp_path / "x.h5").refused(2, "takes no --output")
    tedm("simulate", "--problem", EXAMPLE, "--time").refused(2, "takes no --time")
    (tmp_path / "x.json").write_text("{")
    tedm("simulate", "--problem", tmp_path / "x.json").refused(4, "x.json: is not JSON")


def test_one_test_mass_has_no_simulations(satellite: Project) -> None:
    model = satellite.model
    text = model.read_text()
    second = text.index('[[test_mass]]\nname = "TM2"')
    gravity = text[text.index("[gravity]", second) :].replace(', TM2 = ["IS2"]', "")
    model.write_text(text[:second] + gravity.replace('name = "lpf"', 'name = "lpf"\napplies_to = "single"'))
    satellite.run("make-rules").ok()
    assert "simulation" not in (satellite.build / "rules.mk").read_text()
    satellite.run("build-sensitivity").ok()
    with untouched(satellite.folder):
        satellite.run("build-dynamics").refused(3, "model.toml", "this project has 1")
        satellite.run("simulate", "--figure-6.2").refused(3, "model.toml", "figure 6.2 is of two test masses")


def test_the_end_of_the_chain_with_one_test_mass(satellite: Project) -> None:
    """Everything that make all runs: no loop, and a report that says so."""
    model, cases = satellite.model, satellite.folder / "cases.toml"
    text = model.read_text()
    second = text.index('[[test_mass]]\nname = "TM2"')
    gravity = text[text.index("[gravity]", second) :].replace(', TM2 = ["IS2"]', "")
    model.write_text(text[:second] + gravity.replace('name = "lpf"', 'name = "lpf"\napplies_to = "single"'))
    text = cases.read_text().replace('"TM1_a_x", "TM2_a_x"', '"TM1_a_x"')
    cases.write_text(text[: text.index("[[case]]", text.index("\n[[case]]") + 9)])
    for name in ("dynamics.h5", "simulation03.h5"):
        (satellite.build / name).unlink()
    builds = ("build-distortion", "build-sensitivity", "build-optics", "build-adjoint")
    made = ("ingest", *builds, "run-case", "plot", "report")
    for command in made:
        satellite.run(command, *(["all"] if command == "run-case" else [])).ok()
    assert not [p for p in (satellite.build / "figures").iterdir() if p.name.startswith(("loop", "budget", "closed"))]
    said = (satellite.build / "report.md").read_text(encoding="utf-8")
    assert "The drag-free loop needs two test masses; with 1 test mass there is no loop." in said
    assert "## Evidence: closed loop" not in said


@pytest.mark.parametrize(("command", "name"), [("build-dynamics", "dynamics.h5"), ("simulate", "simulation03.h5")])
def test_killed_writers(satellite: Project, tmp_path: Path, command: str, name: str) -> None:
    satellite.run("build-dynamics").ok()
    target = satellite.build / name
    target.unlink(missing_ok=True)
    before, calls, original = snapshot(satellite.folder), 0, store.Writer._make
    words = [command, "3"] if command == "simulate" else [command]

    def make(self: store.Writer, *args: Any) -> Any:
        nonlocal calls
        calls += 1
        if calls == 20:
            os.kill(os.getpid(), signal.SIGKILL)
        return original(self, *args)

    def act() -> None:
        with mock.patch.object(store.Writer, "_make", make):
            sys.exit(satellite.run(*words).code)

    status = in_child(act, tmp_path / "log")
    assert os.WIFSIGNALED(status), (tmp_path / "log").read_text()
    after = snapshot(satellite.folder)
    assert {n: v for n, v in after.items() if Path(n).name[0] != "."} == before
    satellite.run(*words).ok()
    assert target.is_file()
    assert not list(satellite.build.glob(".*"))
