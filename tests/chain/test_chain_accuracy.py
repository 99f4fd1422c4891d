"""The accuracy command: data and figure of each study, the same bytes every time."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from tedm_cli.cli.printing.gravity import accuracy_lines
from tedm_cli.config.project import Project, load_project
from tedm_cli.errors import ConfigError, UsageError
from tedm_cli.stages.gravity.accuracy import accuracy

ROOT = Path(__file__).parents[2]
BLOCK = """
[[compensation_mass]]
name = "CM1"
centre_m = [-0.15, 0.0, 0.0]
size_m = [0.01, 0.02, 0.02]
density_kg_m3 = 19300.0
"""


@pytest.fixture
def project(tmp_path: Path) -> Project:
    return load_project(ROOT / "sample_models" / "small" / "tedm.toml", tmp_path)


def columns(path: Path) -> tuple[list[str], dict[str, np.ndarray]]:
    lines = path.read_text(encoding="utf-8").splitlines()
    notes = [line for line in lines if line.startswith("# ")]
    rows = list(csv.DictReader(lines[len(notes) :]))
    return notes, {name: np.array([float(r[name] or "nan") for r in rows]) for name in rows[0]}


@pytest.mark.parametrize(
    ("number", "column", "size"),
    [("7.2", "error_percent", 50 * 64), ("7.8", "error_percent", 25 * 64), ("8.1", "error_percent", 40 * 80)],
)
def test_study_writes_data_and_figure(project: Project, number: str, column: str, size: int) -> None:
    done = accuracy(project, number, None)
    assert done.data == project.build_dir / "accuracy" / f"figure_{number.replace('.', '_')}.csv"
    first = done.data.read_bytes(), done.figure.read_bytes()
    notes, data = columns(done.data)
    assert notes[0].startswith(f"# Figure {number}: ")
    assert "test mass TM1: edges 0.046, 0.046, 0.046 m" in notes[1]
    assert data[column].size == size
    assert (data[column] >= 0).all()
    assert b"<svg" in first[1]
    again = accuracy(project, number, None)
    assert (again.data.read_bytes(), again.figure.read_bytes()) == first


def test_printed_values(project: Project) -> None:
    text = "\n".join(accuracy_lines(accuracy(project, "7.2", None)))
    assert "5           0.006 %" in text
    assert "10         0.00015 %" in text
    assert "25         3.2e-08 %" in text


@pytest.mark.parametrize(("number", "far_percent"), [("7.3", 7.29), ("7.9", 21.9)])
def test_element_size_study_holds_all_shapes(project: Project, tmp_path: Path, number: str, far_percent: float) -> None:
    notes, data = columns(accuracy(project, number, tmp_path / "elsewhere").data)
    assert (tmp_path / "elsewhere" / f"figure_{number.replace('.', '_')}.svg").exists()
    shapes = ["centre: cube to its centre", "corners: cube to eight corners", "slab: slab, 0.1 d thick, to its centre"]
    assert notes[2:5] == [f"# {shape}" for shape in shapes]
    far = (data["distance_m"] > 0.2) & (data["size_m"] > 0.01)
    ratio = (data["size_m"][far] / data["distance_m"][far]) ** 4
    np.testing.assert_allclose(data["centre_percent"][far], far_percent * ratio, rtol=0.03)
    np.testing.assert_allclose(data["corners_percent"][far], 14.0 * data["centre_percent"][far], rtol=0.02)
    assert (data["slab_percent"][far] > 5.0 * data["corners_percent"][far]).all()


def test_mesh_of_the_compensation_masses(project: Project, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"figure 6\.4 meshes the compensation masses"):
        accuracy(project, "6.4", None)
    folder = tmp_path / "configs"
    folder.mkdir()
    (folder / "tedm.toml").write_text('title = "with a block"\n', encoding="utf-8")
    model = project.model.read_text(encoding="utf-8")
    (folder / "model.toml").write_text(model + BLOCK, encoding="utf-8")
    notes, data = columns(accuracy(load_project(folder / "tedm.toml", tmp_path), "6.4", None).data)
    assert "compensation masses: 1, 0.0772 kg" in notes[1]
    assert (np.diff(data["nodes"]) >= 0).all()
    assert 5e4 < data["nodes"][-1] <= 1.2e5
    # one element 5 mm from a test mass is percents out, the finest mesh is not
    assert data["error_percent"][0] > 1.0
    assert data["error_percent"][-1] < 1e-5


def test_unknown_study(project: Project) -> None:
    with pytest.raises(UsageError, match=r"no accuracy study '7.4'"):
        accuracy(project, "7.4", None)
