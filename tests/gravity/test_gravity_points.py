"""The command on point sources: what it says is the kernel's field, and what it refuses it names by line."""

from __future__ import annotations

import csv
import doctest
import importlib
import json
from pathlib import Path

import numpy as np
import pytest

from tedm_cli import cli
from tedm_cli.config.project import Project, load_project
from tedm_cli.errors import InputError, UsageError
from tedm_cli.gravity.constants import G_CODATA_2018
from tedm_cli.stages.gravity.self_gravity import point_self_gravity

SMALL = Path(__file__).parents[2] / "sample_models" / "small" / "tedm.toml"
HEADER = "x_m,y_m,z_m,mass_kg\n"


@pytest.fixture
def project(tmp_path: Path) -> Project:
    return load_project(SMALL, tmp_path)


@pytest.fixture
def points(tmp_path: Path) -> Path:
    path = tmp_path / "sources.csv"
    path.write_text(HEADER + "0.3,0.2,-0.1,2.0\n\n-0.188,0.0,0.04,0.25\n 1e3 , 0 , 0 , 5e6 \n", encoding="utf-8")
    return path


@pytest.mark.parametrize("module", ["kernel", "field"])
def test_examples_of_the_array_functions_run(module: str) -> None:
    result = doctest.testmod(importlib.import_module(f"tedm_cli.gravity.{module}"))
    assert result.attempted > 2
    assert result.failed == 0


def test_a_distant_source_is_a_point_to_a_point(project: Project, points: Path) -> None:
    done = point_self_gravity(project, points, per_source=True, output=None)
    assert done.by_source is not None
    assert done.sources.line == [2, 4, 5]
    for tm, field in zip(done.test_masses, done.by_source, strict=True):
        r = 1e3 - tm.position_m[0]
        # the first term beyond the point mass is 0.073 (L/r)^4, here 3e-19
        assert field.acceleration[2, 0] == pytest.approx(G_CODATA_2018 * 5e6 / r**2, rel=1e-13)
        assert field.gamma_lin[2, 0, 0] == pytest.approx(2 * G_CODATA_2018 * 5e6 / r**3, rel=1e-13)


def test_sources_add_up_and_action_is_reaction(project: Project, points: Path) -> None:
    done = point_self_gravity(project, points, per_source=True, output=None)
    assert done.by_source is not None
    for tm, total, parts in zip(done.test_masses, done.total, done.by_source, strict=True):
        for name in ("acceleration", "angular_acceleration", "gamma_lin", "omega_lin", "gamma_ang", "omega_ang"):
            whole, each = getattr(total, name), getattr(parts, name)
            assert np.abs(each.sum(axis=0) - whole).max() <= 4e-16 * np.abs(each).sum(axis=0).max(), name
        # one source exerts no torque about itself: T = R x F
        r = done.sources.position - tm.position_m
        torque = parts.angular_acceleration * np.diag(tm.inertia_kg_m2)
        force = parts.acceleration * tm.mass_kg
        scale = np.linalg.norm(r, axis=1) * np.linalg.norm(force, axis=1)
        assert (np.abs(np.cross(r, force) - torque).max(axis=1) < 1e-15 * scale + 1e-12 * np.abs(torque).max()).all()


def test_json_and_csv_files_hold_what_is_printed(
    project: Project, points: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "field.json"
    arguments = ["self-gravity", "-c", str(SMALL), "--points", str(points), "--per-source", "--json", "-o", str(out)]
    monkeypatch.setattr("sys.argv", ["tedm", *arguments])
    with pytest.raises(SystemExit) as left:
        cli.main()
    assert not left.value.code
    printed = json.loads(capsys.readouterr().out)
    assert json.loads(out.read_text(encoding="utf-8")) == printed
    table = tmp_path / "field.csv"
    done = point_self_gravity(project, points, per_source=True, output=table)
    assert done.by_source is not None
    with open(table, newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [(r["line"], r["test_mass"]) for r in rows] == [(n, t) for n in ("2", "4", "5") for t in ("TM1", "TM2")]
    assert float(rows[3]["gamma_lin_xz_1_s2"]) == done.by_source[1].gamma_lin[1, 0, 2]
    assert printed["per_source"][1]["test_masses"][1]["gamma_lin_1_s2"] == done.by_source[1].gamma_lin[1].tolist()
    totals = tmp_path / "totals.csv"
    point_self_gravity(project, points, per_source=False, output=totals)
    with open(totals, newline="", encoding="utf-8") as stream:
        found = {(r["test_mass"], r["quantity"], r["component"]): float(r["value"]) for r in csv.DictReader(stream)}
    assert found["TM2", "force", "y"] == printed["test_masses"][1]["force_N"][1]
    assert found["TM1", "omega_ang", "yz"] == printed["test_masses"][0]["omega_ang_1_s2_rad"][1][2]


@pytest.mark.parametrize(
    ("text", "place", "fact"),
    [
        (HEADER + "0,0,1,1\n0,nan,1,1\n", ":3", "y_m must be a finite number, found 'nan'"),
        (HEADER + "0,0,1,1\n\n0,0,inf,1\n", ":4", "z_m must be a finite number"),
        (HEADER + "0,0,1_0,1\n", ":2", "z_m must be a finite number"),
        (HEADER + "0,0,1,0\n", ":2", "mass_kg: mass 0 is outside 1e-20 to 1e+31 kg"),
        (HEADER + "0,0,1,-2\n", ":2", "mass_kg: mass -2 is outside 1e-20 to 1e+31 kg"),
        (HEADER + "0,0,1\n", ":2", "3 fields, wanted 4"),
        ("x_m,y_m,mass_kg\n0,0,1\n", ":1", "misses z_m"),
        ("x_m,y_m,z_m,mass_kg,name\n0,0,1,1,a\n", ":1", "must begin with the header x_m,y_m,z_m,mass_kg"),
        ("", ":1", "must begin with the header"),
        (HEADER, "", "holds a header and nothing else"),
        (HEADER + "0,0,1,1\n0.18,0.0,0.0,1\n", ":3", "lies inside or on test mass 'TM2'"),
        (HEADER + "-0.165,0,0,1\n", ":2", "lies inside or on test mass 'TM1'"),
    ],
)
def test_refused_with_the_line(project: Project, tmp_path: Path, text: str, place: str, fact: str) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text, encoding="utf-8")
    target = tmp_path / "kept.csv"
    target.write_text("old", encoding="utf-8")
    with pytest.raises(InputError) as caught:
        point_self_gravity(project, path, per_source=False, output=target)
    assert caught.value.where == f"{path}{place}"
    assert fact in caught.value.fact
    assert target.read_text(encoding="utf-8") == "old"


def test_output_needs_a_known_suffix(project: Project, points: Path, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"\.json or \.csv"):
        point_self_gravity(project, points, per_source=False, output=tmp_path / "field.txt")
