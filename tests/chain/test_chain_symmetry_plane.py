"""The symmetry plane goes with the model: sides, mirror pairs and results of a model that is turned and shifted."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from turned_model import turned_project

from tedm_cli.config.cases import select_cases
from tedm_cli.config.project import Project, load_project
from tedm_cli.contracts import CASE, OPTICS, SENSITIVITY, UNIT_LOADS
from tedm_cli.errors import InputError
from tedm_cli.files.store import open_checked
from tedm_cli.progress import silent
from tedm_cli.results.areas import read_areas, read_plane
from tedm_cli.stages.gravity.sensitivity import build_sensitivity
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import ingest
from tedm_cli.stages.noise.case import run_cases
from tedm_cli.stages.noise.series import run_series
from tedm_cli.stages.optics.build import build_optics

ORIGIN = np.array([0.4, -0.7, 0.25])
AXES = Rotation.from_rotvec(np.radians(30.0) * np.array([0.0, 0.0, 1.0])).as_matrix().T  # rows
CASES = ["10", "10b"]


@pytest.fixture(scope="module")
def turned(tmp_path_factory: pytest.TempPathFactory) -> Project:
    """The chain up to the cases that need sides, on the small sample turned by 30 degrees about z, and shifted."""
    project = turned_project(tmp_path_factory.mktemp("turned") / "project", ORIGIN, AXES)
    ingest(project, None, silent)
    build_distortion(project, None, silent)
    build_sensitivity(project, None, silent)
    build_optics(project, None)
    run_cases(project, select_cases(project.cases, CASES), None, silent)
    return project


def sides(project: Project) -> list[str]:
    with open_checked(project.build_dir / "unit_loads.h5", UNIT_LOADS) as file:
        return read_areas(file).side.tolist()


def test_sides_go_with_the_model(turned: Project, small: Project) -> None:
    assert sides(turned) == sides(small)
    assert set(sides(small)) == {"+y", "-y", "mid"}
    with open_checked(turned.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        plane = read_plane(file)
        assert file.string(SENSITIVITY.PLANE_ORIGIN) == "layout"
    np.testing.assert_allclose(plane.normal, AXES[1], rtol=0, atol=1e-15)
    np.testing.assert_allclose(plane.distance(ORIGIN), 0.0, atol=1e-15)


@pytest.mark.parametrize("case", CASES)
def test_cases_with_sides_and_mirror_pairs_go_with_it(turned: Project, small: Project, case: str) -> None:
    name = f"case{case}.h5"
    with open_checked(turned.build_dir / name, CASE) as one, open_checked(small.build_dir / name, CASE) as two:
        labels = one.strings(CASE.OUTPUT_LABEL)
        assert labels == two.strings(CASE.OUTPUT_LABEL)
        for label in labels:
            found, wanted = (file.array(CASE.PSD.of(label)) for file in (one, two))
            # coherent sums cancel: rounding of single precision is that of the largest that the areas could make
            largest = two.array(CASE.BOUNDS_MAXIMUM.of(label))
            assert np.all(np.abs(found - wanted) <= 1e-6 * largest), label
        ratio, other = one.array(CASE.VERDICT_RATIO), two.array(CASE.VERDICT_RATIO)
        np.testing.assert_allclose(ratio, other, rtol=1e-6)


def test_sensitivities_go_with_it(turned: Project, small: Project) -> None:
    for name, kind, path in (
        ("sensitivity.h5", SENSITIVITY, SENSITIVITY.S),
        ("optics.h5", OPTICS, OPTICS.N.of("A")),
    ):
        with open_checked(turned.build_dir / name, kind) as one, open_checked(small.build_dir / name, kind) as two:
            found, wanted = one.array(path), two.array(path)
        np.testing.assert_array_less(np.abs(found - wanted).max(axis=1), 1e-6 * np.abs(wanted).max(axis=1))


def test_sides_of_a_plane_that_is_gone_are_refused(turned: Project, tmp_path: Path) -> None:
    """Self-gravity alone is left of the project, and without its layout the plane is basic y = 0."""
    folder = tmp_path / "project"
    shutil.copytree(turned.file.path.parent, folder)
    (folder / "optics.toml").unlink()
    cases = folder / "cases.toml"
    read_out = cases.read_text().index('[[requirement]]\nname = "lpf_readout_item"')
    after = cases.read_text().index("[[case]]", read_out)
    text = cases.read_text()[:read_out] + cases.read_text()[after:]
    warm = '[[series]]\nname = "warm"\nfile = "warm.csv"\nremove = "mean"\n\n'
    cases.write_text(text.replace("[[case]]", f"{warm}[[case]]", 1))
    project = load_project(folder / "tedm.toml", folder / "build")
    for judge in (lambda: run_cases(project, CASES, None, silent), lambda: run_series(project, ["warm"], None, silent)):
        with pytest.raises(InputError, match=r"is stale: the sides .* the symmetry plane is y = 0") as caught:
            judge()
        assert caught.value.where.endswith("sensitivity.h5")
        assert "tedm run" in caught.value.hint
