"""Effects of the user's own: rows of a table that add to self-gravity and read-outs, in everything that reads these."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest
from border_tools import Project, tedm

from tedm_cli.chain.graph import chain_of
from tedm_cli.config.project import load_project
from tedm_cli.contracts import SIMULATION
from tedm_cli.files.store import open_checked
from tedm_cli.results.outputs import read_outputs
from tedm_cli.stages.chain.project_files import chain_files
from tedm_cli.stages.dynamics.thermal import thermal_rows

TABLES = """
[[effect]]
name = "anti"
table = "anti.csv"

[[effect]]
name = "radiometer"
table = "radiometer.csv"
"""
HEAD = "output,area,value,unit\n"
RADIOMETER = (
    HEAD
    + "TM1_a_z,IS1_EH_UP,-4e-11,m/s^2/K\nTM1_a_z,IS1_EH_DOWN,3e-11, m/s²/K\nTM2_omegadot_x,IS2_EH_UP,1e-11,rad/s^2/K\n"
)
GLASS = 'name = "BS4"\ndn_dT_1_K = 8.3e-6\narea = "OB_BENCH_PLUS_Y"\n'


def rows_of(build: Path, name: str, path: str) -> tuple[list[str], np.ndarray, list[str]]:
    with h5py.File(build / name) as file:
        labels = file["/row/label" if name == "sensitivity.h5" else "/label/read_out"].asstr()[()].tolist()
        return labels, file[path][()], file["/area/name"].asstr()[()].tolist()


def anti(build: Path) -> str:
    """A table that takes away all of the acceleration TM1_a_x, and doubles the read-out A_TM1_x."""
    lines = []
    for name, path, label, as_output, factor, unit in (
        ("sensitivity.h5", "/S", "TM1_a_x", "TM1_a_x", -1.0, "m/s^2/K"),
        ("optics.h5", "/N/A", "TM1_x", "A_TM1_x", 1.0, "m/K"),
    ):
        labels, values, areas = rows_of(build, name, path)
        row = values[labels.index(label)]
        lines += [f"{as_output},{area},{float(factor * v)!r},{unit}\n" for area, v in zip(areas, row, strict=True)]
    return HEAD + "".join(lines)


@pytest.fixture(scope="module")
def own(chain: Project, tmp_path_factory: pytest.TempPathFactory) -> Project:
    """The chain with a plate that warms up and two effects, case 3 included."""
    project = chain.copy(tmp_path_factory.mktemp("effects") / "own")
    layout = project.folder / "optics.toml"
    layout.write_text(layout.read_text().replace('name = "BS4"\n', GLASS))
    with open(project.model, "a", encoding="utf-8") as stream:
        stream.write(TABLES)
    (project.folder / "radiometer.csv").write_text(RADIOMETER, encoding="utf-8")
    for command in ("ingest", "build-distortion", "build-sensitivity", "build-optics"):
        project.stage(command).ok()
    (project.folder / "anti.csv").write_text(anti(project.build))
    project.stage("run-case").ok()
    (project.build / "adjoint.h5").unlink()  # of the chain that was copied
    return project


@pytest.fixture
def radiometer(own: Project) -> Iterator[Path]:
    """A table that a test may change."""
    path = own.folder / "radiometer.csv"
    yield path
    path.write_text(RADIOMETER, encoding="utf-8")


def test_effects_add_coherently(own: Project, chain: Project) -> None:
    """What is opposite to an acceleration silences it; what is like a read-out makes its power four times as large."""
    with h5py.File(own.build / "case03.h5") as new, h5py.File(chain.build / "case03.h5") as old:
        assert old["/psd/TM1_a_x"][:].min() > 0.0
        assert not new["/psd/TM1_a_x"][:].any()
        for untouched in ("TM2_a_x", "TM1_a_y", "TM1_omegadot_x"):
            assert np.array_equal(new[f"/psd/{untouched}"], old[f"/psd/{untouched}"])
        half = new["/psd/B_TM1_x"][:]
        np.testing.assert_allclose(new["/psd/A_TM1_x"], 4.0 * half, rtol=1e-9)
        assert new["/effect/name"].asstr()[()].tolist() == ["anti", "radiometer"]
        row = dict(zip(new["/area/name"].asstr()[()], new["/effect/row/TM1_a_z"][1], strict=True))
        assert {n: v for n, v in row.items() if v} == {"IS1_EH_UP": -4e-11, "IS1_EH_DOWN": 3e-11}
        names = new["/path/name"].asstr()[()].tolist()
        assert names[-4:] == ["BS4 glass", "self-gravity", "anti effect", "radiometer effect"]
        for label in ("TM1_a_z", "A_TM1_x", "B_TM1_x", "TM2_omegadot_x"):
            for share in ("share", "band_share"):
                assert new[f"/path/{share}/{label}"][:].sum() == pytest.approx(1.0, abs=1e-9)
        assert new["/path/share/TM1_a_z"][-1] > 0.5
        half_each = dict(zip(names, new["/path/share/A_TM1_x"], strict=True))
        assert half_each["anti effect"] == pytest.approx(0.5, rel=1e-9)


TOGETHER = """
[[requirement]]
name = "lpf_readout_item"
outputs = ["A_TM1_x", "A_TM2_x"]

[uncertainty]
samples = 500

[[uncertainty.level]]
name = "inside"
shield = ["inside"]
relative_sigma = 0.2
source = "a test"

[[temperature.within]]
name = "bench"
areas = ["OB_BENCH_*"]
across_K = 1e-4

[[case]]
id = "3"
title = "All that may be in one"
blocks = [{ shield = ["outside"] }, { shield = ["inside"] }]
"""


def test_effects_gradients_within_areas_and_what_is_uncertain_in_one_case(own: Project, tmp_path: Path) -> None:
    """Gradients follow no effect; of what is uncertain levels act on them; all else is as without them."""
    project = own.copy(tmp_path / "together")
    (project.folder / "cases.toml").write_text(TOGETHER)
    project.stage("build-adjoint").ok()
    project.run("run-case", "3").ok()
    with h5py.File(project.build / "case03.h5") as file:
        within = np.char.find(file["/area/name"].asstr()[()].astype(str), "bench grad ") == 0
        assert within.sum() == 3
        assert not file["/effect/row/A_TM1_x"][:, within].any()
        assert file["/effect/row/A_TM1_x"][0, ~within].any()
        for label in ("A_TM1_x", "A_TM2_x", "TM1_a_z"):
            assert file[f"/path/share/{label}"][:].sum() == pytest.approx(1.0, abs=1e-9)
        np.testing.assert_allclose(file["/uncertainty/nominal"], file["/verdict/ratio"], rtol=1e-12)
        assert "/uncertainty/left_out" not in file, "levels act on gradients as well, so nothing is"
        low, high = file["/uncertainty/quantile"][:, [4, 94]].T
        assert np.all(low < file["/verdict/ratio"])
        assert np.all(high > file["/verdict/ratio"])


def test_parts_are_the_outputs(own: Project) -> None:
    outputs = read_outputs(load_project(own.folder / "tedm.toml", own.build))
    assert set(outputs.parts_of_read_outs) == set(outputs.labels)
    for label, parts in outputs.parts_of_read_outs.items():
        whole = outputs.rows[outputs.labels.index(label)]
        assert np.all(np.abs(parts.by_element.sum(axis=0) - whole) <= 1e-13 * np.abs(parts.by_element).sum(axis=0))
        assert (parts.distortion is None) == ("_a_" in label or "omegadot" in label)
    twice = outputs.parts_of_read_outs["A_TM1_x"].distortion
    once = outputs.parts_of_read_outs["B_TM1_x"].distortion
    assert twice is not None
    assert once is not None
    whole = outputs.rows[outputs.labels.index("B_TM1_x")]
    assert twice - once == pytest.approx(whole, rel=1e-9, abs=1e-9 * np.abs(whole).max())
    assert {path.name for path in outputs.sources} == {"sensitivity.h5", "optics.h5", "anti.csv", "radiometer.csv"}


def test_the_loop_feels_them(own: Project, radiometer: Path) -> None:
    project = load_project(own.folder / "tedm.toml", own.build)
    rows = thermal_rows(project, None)
    N = rows_of(own.build, "optics.h5", "/N/A")[1]
    assert not rows.acceleration[0].any()  # TM1_a_x
    assert rows.acceleration[1].any()
    assert any(np.array_equal(row, 2.0 * N[0]) for row in rows.read_out)
    own.run("build-dynamics").ok()
    own.run("simulate", "3").ok()
    with open_checked(own.build / "simulation03.h5", SIMULATION) as file:
        assert {"anti.csv", "radiometer.csv"} < {item.path.name for item in file.provenance().inputs}
    radiometer.write_text(RADIOMETER.replace("-4e-11", "-5e-11"), encoding="utf-8")
    own.run("simulate", "3").refused(4, "dynamics.h5: is stale", hint="tedm build-dynamics")
    checked = tedm("check", "-d", own.build).out
    assert checked.count("radiometer.csv has changed since") == 3, checked  # case, loop, simulation


def test_the_chain_knows_the_tables(own: Project) -> None:
    steps = chain_of(chain_files(load_project(own.folder / "tedm.toml", own.build)))
    fed = {s.stage for s in steps if any(p.name == "radiometer.csv" for p in s.inputs)}
    assert fed == {"run-case", "build-dynamics", "simulate"}
    own.run("make-rules").ok()
    rules = (own.build / "rules.mk").read_text().splitlines()
    assert f"EFFECTS := {own.folder / 'anti.csv'} {own.folder / 'radiometer.csv'}" in rules
    make = (Path(__file__).parents[2] / "Makefile").read_text().splitlines()
    fed_by_make = [make[i + 1] for i, line in enumerate(make) if "$(EFFECTS)" in line]
    assert {line.split()[1] for line in fed_by_make} == {"run-case", "run-series", "build-dynamics", "simulate"}


def test_explain_tells_of_them(own: Project) -> None:
    told = json.loads(own.run("explain", "radiometer", "--json").ok().out)
    found = {row["output"]: row for row in told["tables"]["outputs"]}
    assert set(found) == {"TM1_a_z", "TM2_omegadot_x"}
    assert found["TM1_a_z"]["size"] == pytest.approx(5e-11, rel=1e-12)
    assert found["TM1_a_z"]["most_by"] == "IS1_EH_UP"
    gravity = json.loads(own.run("explain", "TM1_a_z", "--json").ok().out)
    (moving,) = (rows for name, rows in gravity["tables"].items() if name == "moving")
    assert sum(row["share"] for row in moving) == pytest.approx(1.0, abs=1e-9)
    assert any("radiometer effect" in row.values() for row in moving)
    x = json.loads(own.run("explain", "A_TM1_x", "--top", "0", "--json").ok().out)["read_outs"][0]
    assert x["effects"]["share"] == pytest.approx(0.5, rel=1e-9)
    assert sum(x[part]["share"] for part in ("rigid", "distortion", "plates", "effects")) == pytest.approx(1.0)
    for table in ("elements", "motions", "beams"):
        assert sum(row["share"] for row in x[table]) == pytest.approx(1.0, abs=1e-9)
        assert any(row["name"] == "anti effect" for row in x[table])
    difference = json.loads(own.run("explain", "A_TM1_x-B_TM1_x", "--json").ok().out)
    assert difference["tables"]["elements"][0]["element"] == "anti effect"
    assert "anti effect" not in own.run("explain", "B_TM1_x").ok().out


def test_the_mesh_says_what_is_at_no_grid(own: Project, tmp_path: Path) -> None:
    for output in ("TM1_a_z", "A_TM1_x"):
        tedm("export-vtu", "--of", output, "--case", "3", "-d", own.build, "-o", tmp_path / "m.vtu").ok()
        with open(tmp_path / "m_arrays.csv", encoding="utf-8", newline="") as stream:
            (row,) = (r for r in csv.DictReader(stream) if r["array"] == f"share_{output}_case3")
        rest = float(row["meaning"].split("; ")[1].split(" more at no grid")[0])
        assert abs(rest) > 0.1
        assert float(row["sum"]) + rest == pytest.approx(1.0, abs=2e-5)


@pytest.mark.parametrize(
    ("line", "facts", "hint"),
    [
        ("TM1_ax,IS1_EH_UP,1e-11,m/s^2/K", (":5:", "no output is called 'TM1_ax'"), "did you mean TM1_a_x?"),
        ("TM1_a_z-TM2_a_z,IS1_EH_UP,1e-11,m/s^2/K", (":5:", "no output is called 'TM1_a_z-TM2_a_z'"), ""),
        ("TM1_a_z,IS1_EH_TOP,1e-11,m/s^2/K", (":5:", "no thermal area is called 'IS1_EH_TOP'"), "IS1_EH_UP"),
        ("TM1_a_z,IS2_EH_UP,1e-11,m/s^2", (":5:", "unit 'm/s^2': TM1_a_z by IS2_EH_UP is in m/s^2/K"), "convert"),
        ("A_TM1_x,IS2_EH_UP,1,pm/K", (":5:", "unit 'pm/K': A_TM1_x by IS2_EH_UP is in m/K"), "convert"),
        ("TM1_a_z,IS1_EH_UP,1e-11,m/s^2/K", (":5:", "stands in line 2 already"), "add the two up"),
        ("TM1_a_z,IS2_EH_UP,nan,m/s^2/K", (":5:", "value must be a finite number, found 'nan'"), ""),
        ("TM1_a_z,IS2_EH_UP,1e9,m/s^2/K", (":5:", "value: value of an effect 1e+09 is outside"), ""),
        ("TM1_a_z,IS2_EH_UP,1e-11", (":5:", "3 fields, wanted 4"), ""),
    ],
)
def test_tables_that_are_wrong(own: Project, radiometer: Path, line: str, facts: tuple[str, ...], hint: str) -> None:
    before = (own.build / "case03.h5").read_bytes()
    radiometer.write_text(RADIOMETER + line + "\n", encoding="utf-8")
    own.stage("run-case").refused(4, "radiometer.csv", *facts, hint=hint)
    own.run("explain", "TM1_a_z").refused(4, "radiometer.csv", *facts, hint=hint)
    assert (own.build / "case03.h5").read_bytes() == before


def test_a_table_that_is_gone_or_has_another_header(own: Project, radiometer: Path) -> None:
    radiometer.write_text(RADIOMETER.replace("output,", "row,"), encoding="utf-8")
    own.stage("run-case").refused(4, "must begin with the header output,area,value,unit; misses output, has 'row'")
    radiometer.unlink()
    own.stage("run-case").refused(4, "radiometer.csv")


@pytest.mark.parametrize(
    ("tables", "facts"),
    [
        (TABLES.replace('"radiometer"', '"anti"'), ("two effects have the same name: anti, anti",)),
        (TABLES.replace('"radiometer"', '"radio meter"'), ("effect[1].name",)),
        (TABLES.replace("table = ", "tables = ", 1), ("effect[0].tables: unknown key; did you mean table",)),
    ],
)
def test_effects_that_are_wrong_in_the_model(small: Project, tables: str, facts: tuple[str, ...]) -> None:
    with open(small.model, "a", encoding="utf-8") as stream:
        stream.write(tables)
    small.stage("run-case").refused(3, *facts)


def test_half_a_chain_explains_its_own_half(own: Project, tmp_path: Path) -> None:
    """Without optics.h5 the lines on read-outs are passed over by `explain`, which tells of what is there."""
    half = own.copy(tmp_path / "half")
    (half.build / "optics.h5").unlink()
    assert "radiometer effect" in half.run("explain", "TM1_a_z").ok().out
