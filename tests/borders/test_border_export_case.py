"""Exports of cases and of their state-space form: what other programs find in the files, and what is refused."""

from __future__ import annotations

import csv
import os
import re
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io
import scipy.signal
from border_tools import ROOT, Project, replace, snapshot, tedm

TABLES = ("psd", "asd", "requirement_asd", "temperature_asd", "bound_minimum", "bound_known_blocks")
MATLAB_NAME = re.compile(r"[A-Za-z]\w{0,62}$")


def load(path: Path) -> dict[str, Any]:
    return scipy.io.loadmat(path, simplify_cells=True)


def case_psd(project: Project, case: str) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    with h5py.File(project.build / f"case{case}.h5") as file:
        return file["/frequency"][()], {name: file[f"/psd/{name}"][()] for name in file["/psd"] if name != "frequency"}


@pytest.fixture(scope="session")
def cases(chain: Project, tmp_path_factory: pytest.TempPathFactory) -> Project:
    """The built sample with cases 1, 2, 3 and 10. Not to be changed: copy it."""
    project = chain.copy(tmp_path_factory.mktemp("cases") / "small")
    project.run("run-case", "1", "2", "3", "10").ok()
    return project


@pytest.fixture
def mine(cases: Project, tmp_path: Path) -> Project:
    """A copy that a test may change."""
    return cases.copy(tmp_path / "small")


def test_case_files_in_three_formats(cases: Project, tmp_path: Path) -> None:
    for fmt in ("mat", "npz", "csv"):
        tedm("export-case", "3", "--format", fmt, "-d", cases.build, "-o", tmp_path).ok()
    mat, npz = load(tmp_path / "case03.mat"), np.load(tmp_path / "case03.npz")
    frequency, psd = case_psd(cases, "03")
    assert mat["psd"]["columns"].tolist()[0] == "frequency"
    for column, label in enumerate(mat["psd"]["columns"].tolist()[1:], start=1):
        np.testing.assert_array_equal(mat["psd"]["value"][:, column], psd[label])
        np.testing.assert_array_equal(mat["asd"]["value"][:, column], np.sqrt(psd[label]))
    np.testing.assert_array_equal(mat["psd"]["value"][:, 0], frequency)
    units = dict(zip(mat["asd"]["columns"], mat["asd"]["column_units"], strict=True))
    assert units["frequency"] == "Hz"
    assert units["TM1_a_x"] == "m s^-2/sqrt(Hz)"
    assert units["A_TM1_x"] == "m/sqrt(Hz)"
    names = [row[0] for row in mat["contents"]]
    assert set(names) <= set(mat)
    assert all(MATLAB_NAME.match(n) for n in names)
    for name in names:
        value, described = np.atleast_2d(mat[name]["value"]), mat[name]["description"]
        assert described
        np.testing.assert_array_equal(npz[name].reshape(value.shape), value)
        assert npz[f"{name}.columns"].tolist() == np.atleast_1d(mat[name]["columns"]).tolist()
        with open(tmp_path / "case03" / f"{name}.csv", newline="") as stream:
            lines = list(csv.reader(stream))
        first = 0 if "row_units" not in mat[name] and "rows" not in mat[name] else 2 if "row_units" in mat[name] else 1
        assert lines[0][first:] == np.atleast_1d(mat[name]["columns"]).tolist()
        assert lines[1][first:] == np.atleast_1d(mat[name]["column_units"]).tolist()
        read = np.array([[float(v) for v in line[first:]] for line in lines[2:]])
        np.testing.assert_array_equal(read, npz[name])
    assert set(TABLES) <= set(names)
    assert "one-sided" in mat["readme"]
    assert "safety factor" in (tmp_path / "case03" / "readme.txt").read_text()


def test_case_numbers_fit_together(cases: Project, tmp_path: Path) -> None:
    """Verdicts follow from the exported spectra and requirements, contributions from shares and R."""
    tedm("export-case", "-d", cases.build, "-o", tmp_path).ok()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["case01.mat", "case02.mat", "case03.mat", "case10.mat"]
    m = load(tmp_path / "case10.mat")
    asd = dict(zip(m["asd"]["columns"], m["asd"]["value"].T, strict=True))
    limit = dict(zip(m["requirement_asd"]["columns"], m["requirement_asd"]["value"].T, strict=True))
    ratio = m["verdict"]["value"][:, m["verdict"]["columns"].tolist().index("ratio")]
    for label, value in zip(m["verdict"]["rows"], ratio, strict=True):
        requirement, output = label.split(" ")
        assert np.nanmax(2.0 * asd[output] / limit[requirement]) == pytest.approx(value, rel=1e-12, abs=0)
    h, R = m["contribution"]["value"], m["R"]["value"]
    at = dict(zip(m["contribution_frequency"]["rows"], m["contribution_frequency"]["value"][:, 0], strict=True))
    for i, label in enumerate(m["contribution"]["rows"]):
        nearest = int(np.argmin(np.abs(asd["frequency"] - at[label])))
        power = asd[label][nearest] ** 2
        assert h[i] @ R @ h[i] == pytest.approx(power, rel=1e-6, abs=1e-9 * np.sum(np.abs(h[i])) ** 2)
    np.testing.assert_allclose(m["share"]["value"].sum(axis=1), 1.0, rtol=1e-9)
    np.testing.assert_array_equal(m["areas"]["value"][:, 1] >= 0, np.diag(R) == 1.0)


def scipy_psd(m: dict[str, Any], frequency: np.ndarray) -> np.ndarray:
    """One-sided PSD of every output, by somebody who has scipy and the file."""
    A, B, C, D = (np.atleast_2d(m[k]["value"]) for k in "ABCD")
    B, C, D = B.reshape(len(A), -1), C.reshape(-1, len(A)), D.reshape(len(np.atleast_1d(m["C"]["rows"])), -1)
    total = np.zeros((len(C), len(frequency)))
    for j in range(B.shape[1]):
        noise = m["B"]["columns"][j] if B.shape[1] > 1 else m["B"]["columns"]
        here = np.array([state.startswith(f"{noise}_") for state in m["A"]["rows"]])  # scipy takes one input at a time
        for o in range(len(C)):
            unit = np.abs(C[o]).max()  # scipy takes numerators below 1e-14 for zeros
            c, d = C[o : o + 1][:, here] / unit, D[o : o + 1, j : j + 1] / unit
            system = scipy.signal.lti(A[np.ix_(here, here)], B[here, j : j + 1], c, d)
            total[o] += unit**2 * np.abs(scipy.signal.freqresp(system, 2 * np.pi * frequency)[1]) ** 2
    return total


def resolvent_psd(m: dict[str, Any], frequency: np.ndarray) -> np.ndarray:
    A, B, C, D = (m[k]["value"] for k in "ABCD")
    resolvent = 2j * np.pi * frequency[:, None, None] * np.eye(len(A)) - A
    h = C @ np.linalg.solve(resolvent, np.broadcast_to(B, (len(frequency), *B.shape))) + D
    return np.sum(np.abs(h) ** 2, axis=2).T


@pytest.mark.filterwarnings("ignore::scipy.signal.BadCoefficients")
@pytest.mark.parametrize(("case", "states"), [("1", 2), ("2", None), ("3", 4), ("10", 6)])
def test_frequency_response_of_the_file_is_the_case(
    cases: Project, tmp_path: Path, case: str, states: int | None
) -> None:
    out = cases.run("export-state-space", case, "-o", tmp_path).ok().out
    stem = f"case{int(case):02d}"
    m = load(tmp_path / f"{stem}_state_space.mat")
    frequency, psd = case_psd(cases, stem[4:])
    some = frequency[::30]
    assert m["C"]["rows"].tolist() == list(np.atleast_1d(m["G"]["rows"]))
    assert set(m["C"]["rows"]) == set(psd)
    want = np.array([psd[label][::30] for label in m["C"]["rows"]])
    found = scipy_psd(m, some) if case != "2" else resolvent_psd(m, some)
    # Outputs that nearly cancel keep what rounding of their terms leaves.
    np.testing.assert_allclose(np.sqrt(found), np.sqrt(want), rtol=1e-4, atol=0)
    A = m["A"]["value"]
    assert states in (None, len(A))
    assert np.all(np.linalg.eigvals(A).real < 0.0)
    assert f"{len(A)} states" in out
    assert f"{stem}.h5" in out
    assert "one-sided PSD 1/Hz" in m["readme"]
    assert "Noise power 0.5" in m["readme"]


PRESETS = {
    "thesis": ("order = 2", "order = 1.5"),
    "white": ('preset = "thesis"', 'preset = "white"'),
    "lpf_flight": ('preset = "thesis"', 'preset = "lpf_flight"'),
    "table": ('preset = "thesis"', 'preset = "table"\ntable = "t.csv"'),
}


@pytest.mark.parametrize("preset", PRESETS)
def test_every_preset(mine: Project, preset: str) -> None:
    """With a table, areas of different spectra share noise in case 1."""
    file = mine.folder / "cases.toml"
    replace(file, *PRESETS[preset])
    if preset != "thesis":
        text = re.sub(r"^(reference_hz|order|corner_hz) = .*\n", "", file.read_text(), flags=re.M)
        if preset != "white":
            text = re.sub(r"^(outside_K|inside_K) = .*\n", "", text, flags=re.M)
        file.write_text(text)
    (mine.folder / "t.csv").write_text("frequency_hz,outside,inside\n1e-4,1e-3,1e-4\n0.1,1e-5,3e-6\n")
    for case in ("1", "3"):
        mine.run("run-case", case).ok()
        mine.run("export-state-space", case, "-q").ok()
        m = load(mine.build / "export" / f"case0{case}_state_space.mat")
        frequency, psd = case_psd(mine, f"0{case}")
        want = np.array([psd[label] for label in m["C"]["rows"]])
        states, noises = len(np.atleast_1d(m["X0"].get("rows", []))), np.atleast_1d(m["D"]["columns"])
        for name, shape in (("A", (states, states)), ("B", (states, len(noises))), ("C", (len(want), states))):
            m[name]["value"] = np.reshape(m[name]["value"], shape)
        m["D"]["value"] = np.reshape(m["D"]["value"], (len(want), len(noises)))
        off = np.abs(np.sqrt(resolvent_psd(m, frequency) / want) - 1.0)
        validity = dict(zip(m["validity"]["columns"], m["validity"]["value"], strict=True))
        assert validity["filter_deviation"] <= validity["tolerance"] == 0.01
        assert off.max() == pytest.approx(validity["output_deviation"], rel=1e-3, abs=1e-6)
        single = preset != "table" or case == "3"
        assert np.median(off) <= 0.01
        if single:
            assert off.max() <= 0.0102
        assert (states == 0) == (preset == "white")


def test_formats_and_optional_parts(cases: Project, tmp_path: Path) -> None:
    more = ("--rate-hz", "0.5", "--temperatures")
    for fmt in ("mat", "npz", "csv"):
        cases.run("export-state-space", "3", "--format", fmt, "-o", tmp_path, *more).ok()
    m, npz = load(tmp_path / "case03_state_space.mat"), np.load(tmp_path / "case03_state_space.npz")
    names = [row[0] for row in m["contents"]]
    wanted = {*"ABCDG", "C_T", "D_T", "X0", "A_d", "B_d", "C_d", "D_d", "C_T_d", "D_T_d", "rate", "validity"}
    assert set(names) == wanted
    for name in names:
        with open(tmp_path / "case03_state_space" / f"{name}.csv", newline="") as stream:
            lines = list(csv.reader(stream))
        first = 2 if lines[0][0] == "row" else 0
        read = np.array([[float(v) for v in line[first:]] for line in lines[2:]])
        np.testing.assert_array_equal(read, npz[name])
        np.testing.assert_array_equal(np.reshape(m[name]["value"], read.shape), read)
    G, C_T = m["G"]["value"], m["C_T"]["value"]
    np.testing.assert_allclose(G @ C_T, m["C"]["value"], rtol=0, atol=1e-12 * np.abs(m["C"]["value"]).max())
    A, B, X0 = m["A_d"]["value"], m["B_d"]["value"], m["X0"]["value"]
    P = X0 @ X0.T
    np.testing.assert_allclose(A @ P @ A.T + B @ B.T, P, rtol=0, atol=1e-12 * P.max())
    before = snapshot(tmp_path)
    cases.run("export-state-space", "3", "-o", tmp_path, *more).ok()
    assert snapshot(tmp_path) == before


def test_without_a_case_file_the_exact_spectra_are_compared(mine: Project) -> None:
    (mine.build / "case03.h5").unlink()
    assert "the exact spectra" in mine.run("export-state-space", "3").ok().out


def test_the_documented_example_runs(mine: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (ROOT / "docs" / "how-to" / "export.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"```python\n(.*?)```", text, flags=re.S)
    mine.run("export-state-space", "3", "--rate-hz", "1").ok()
    monkeypatch.chdir(mine.folder)
    scope: dict[str, Any] = {}
    exec(compile(example, os.fspath(ROOT / "docs" / "how-to" / "export.md"), "exec"), scope)
    X0, C = scope["m"]["X0"]["value"], scope["C"]
    sigma = np.linalg.norm(C @ X0, axis=1)
    assert set(scope["noise"]) == set(scope["m"]["C"]["rows"])
    np.testing.assert_allclose(scope["y"].std(axis=0) / sigma, 1.0, rtol=0, atol=0.35)  # a day is 100 periods or so


def test_refusals_of_case(cases: Project, tmp_path: Path) -> None:
    run = lambda *args: tedm("export-case", *args, "-d", cases.build)  # noqa: E731
    run("77").refused(4, "case77.h5: no such file", hint="tedm run-case")
    run("-o", tmp_path / "x.mat").refused(2, "cannot take 4 cases", hint="folder")
    run("3", "-o", tmp_path / "x.npz").refused(2, "cannot take a case as mat")
    tedm("export-case", "-d", tmp_path).refused(4, "holds no case file")
    tedm("export", "case", "-d", cases.build).refused(
        2, "there are no matrices to export from case", hint="export-case"
    )
    assert not list(tmp_path.iterdir())


def test_refusals_of_state_space(mine: Project) -> None:
    def run(*args: object) -> Any:
        return mine.run("export-state-space", *args)

    before = snapshot(mine.build)
    run().refused(2, "name a case, or all, or --loop")
    run("77").refused(2, "there is no case '77'")
    run("3", "--tolerance", "0").refused(2, "--tolerance 0")
    run("3", "--rate-hz", "-1").refused(2, "--rate-hz -1")
    file = mine.folder / "cases.toml"
    replace(file, "order = 2", "order = 1.5")
    run("3").refused(4, "case03.h5: is stale", hint="tedm run-case 3")
    (mine.build / "case03.h5").unlink()
    del before["case03.h5"]
    replace(file, 'id = "3"', 'id = "3"\ndelays = [{ groups = ["IS1"], delay_s = 600.0 }]')
    run("3").refused(4, "case 3", "follow each other by 600 s", hint="delays")
    with h5py.File(mine.build / "optics.h5") as source:
        a, b = (n.decode() for n in source["/area/name"][:2])
    (mine.folder / "r.csv").write_text(f"area,{a},{b}\n{a},1,0.5j\n{b},-0.5j,1\n")
    text = file.read_text()
    file.write_text(text + '\n[[case]]\nid = "20"\ntitle = "turned"\nreason = "-"\nmatrix = "r.csv"\n')
    run("20").refused(4, "correlation is complex", hint="real matrix")
    (mine.build / "optics.h5").rename(mine.folder / "optics.h5")
    run("1").refused(4, "optics.h5", hint="build-optics")
    (mine.folder / "optics.h5").rename(mine.build / "optics.h5")
    assert snapshot(mine.build) == before
