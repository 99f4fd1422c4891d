"""build-sensitivity --no-store: results read once, against results that are stored, and against parts."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest
from border_tools import tedm
from parts_project import FILES, parts_project
from shared_folder import shared

from tedm_cli import columns
from tedm_cli.arrays import FloatArray
from tedm_cli.columns import Reduction, reduced
from tedm_cli.config.project import Project, load_project
from tedm_cli.distortion import RigidFit
from tedm_cli.progress import silent
from tedm_cli.stages.gravity.sensitivity import build_sensitivity
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import ingest

NAMES = ("unit_loads.h5", "distortion.h5", "sensitivity.h5")


def no_store(folder: Path) -> Project:
    """The eight files joined to one by their order in the list, none of them ingested."""
    project = parts_project(folder)
    done = tedm("build-sensitivity", "--no-store", "-c", project.file.path, "-d", project.build_dir)
    assert done.code == 0, done.err
    assert "unit_loads.h5: of 8 result files; displacements of grids are not kept" in done.out
    return project


@pytest.fixture(scope="module")
def passed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project after one pass. Not to be changed."""
    return shared(tmp_path_factory, "one_pass", no_store)


def values(path: Path) -> dict[str, np.ndarray]:
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda n, o: found.update({n: o[()]}) if isinstance(o, h5py.Dataset) else None)
    return {name: data for name, data in found.items() if data.dtype.kind in "iuf"}


def test_the_same_numbers_as_stored_results(passed: Path, tmp_path: Path) -> None:
    """S_SG, its changes, tied masses, optical motions and what is checked: to 1e-14 of the largest of each."""
    shutil.copytree(passed, tmp_path / "p", ignore=shutil.ignore_patterns("build"))
    stored = load_project(tmp_path / "p" / "tedm.toml", tmp_path / "p" / "build")
    for stage in (ingest, build_distortion, build_sensitivity):
        stage(stored, None, silent)
    for name in NAMES:
        ours, wanted = values(passed / "build" / name), values(stored.build_dir / name)
        kept = {"translation", "rotation", "D/translation", "D/rotation"}
        assert not kept & set(ours)
        assert len(ours) > 10
        for path in ours:
            scale = np.nanmax(np.abs(wanted[path]), initial=0.0)
            np.testing.assert_allclose(ours[path], wanted[path], rtol=0, atol=1e-14 * scale, err_msg=f"{name}/{path}")


def test_the_same_bits_as_parts(passed: Path, tmp_path: Path) -> None:
    """Each file is reduced by itself in either case."""
    shutil.copytree(passed, tmp_path / "p", ignore=shutil.ignore_patterns("build"))
    where = ["-c", tmp_path / "p" / "tedm.toml", "-d", tmp_path / "p" / "build"]
    for name in FILES:
        assert tedm("build-sensitivity", "--partial", tmp_path / "p" / name, *where).code == 0
    assert tedm("merge", *where).code == 0
    for name in NAMES:
        ours, wanted = values(passed / "build" / name), values(tmp_path / "p" / "build" / name)
        assert set(ours) == set(wanted)
        for path in ours:
            np.testing.assert_array_equal(ours[path], wanted[path], err_msg=f"{name}/{path}")


def test_a_file_that_is_missing_or_cut_off_leaves_nothing(passed: Path, tmp_path: Path) -> None:
    shutil.copytree(passed, tmp_path / "p", ignore=shutil.ignore_patterns("build"))
    command = ["build-sensitivity", "--no-store", "-c", tmp_path / "p" / "tedm.toml", "-d", tmp_path / "p" / "build"]
    last = tmp_path / "p" / FILES[-1]
    last.write_bytes(last.read_bytes()[:-4000])
    cut = tedm(*command)
    assert (cut.code, "batch8.op2" in cut.err) == (4, True)
    last.unlink()
    missing = tedm(*command)
    assert (missing.code, "batch8.op2" in missing.err) == (4, True)
    assert not list((tmp_path / "p" / "build").glob("*.h5"))


@pytest.mark.parametrize("other", [["--partial", "a.op2"], ["--scheduler", "tcp://a:1"], ["-o", "a.h5"]])
def test_ways_exclude_each_other(passed: Path, other: list[str], tmp_path: Path) -> None:
    done = tedm("build-sensitivity", "--no-store", *other, "-c", passed / "tedm.toml", "-d", tmp_path)
    assert done.code == 2
    assert "--no-store, --partial, --scheduler and --output exclude each other" in done.err


@pytest.mark.parametrize("held", [1, 3, 8, 50])
def test_columns_do_not_depend_on_how_many_areas_are_held(held: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Twenty areas, of which some are gradients, against sums that are written out; 9,000 grids are three blocks."""
    rng = np.random.default_rng(5)
    n, levers, optics = 9_000, np.array([3, 4_100, 8_999]), np.array([0, 5_000])
    position, mass = rng.normal(size=(n, 3)), rng.uniform(1.0, 2.0, n)
    by = Reduction(
        operator=rng.normal(size=(24, n, 3)),
        rotation=rng.normal(size=(24, 3, 3)),
        levers=levers,
        optics=optics,
        blocks=(),
        fit=RigidFit(position, mass, mass @ position / mass.sum()),
    )
    moves, turns, load = rng.normal(size=(20, n, 3)), rng.normal(size=(20, n, 3)), rng.uniform(0.5, 2.0, 20)
    mean = np.arange(20) % 4 != 0

    def motions() -> Iterator[tuple[float, bool, FloatArray, FloatArray]]:
        for area in range(20):
            yield float(load[area]), bool(mean[area]), moves[area], turns[area]

    monkeypatch.setattr(columns, "_AREAS", held)
    found, sums = reduced(motions(), by)
    d, turned = moves / load[:, None, None], turns / load[:, None, None]
    wanted = -np.einsum("rni,ani->ra", by.operator, d) - np.einsum("rli,ali->ra", by.rotation, turned[:, levers])
    np.testing.assert_allclose(found.columns, wanted, rtol=0, atol=1e-14 * np.abs(wanted).max() * np.sqrt(n))
    np.testing.assert_array_equal(found.optical_translation, d[:, optics])
    np.testing.assert_array_equal(found.optical_rotation, turned[:, optics])
    np.testing.assert_allclose(found.largest, np.linalg.norm(d, axis=2).max(axis=1), rtol=1e-15)
    np.testing.assert_allclose(sums.total, d[mean].sum(axis=0), rtol=0, atol=1e-14)
    np.testing.assert_allclose(sums.size, np.linalg.norm(d[mean], axis=2).sum(axis=0), rtol=1e-14)
    # The rigid motion is that of least squares: what is left has no resultant and no moment.
    for area in (0, 7, 19):
        arm = position - mass @ position / mass.sum()
        left = d[area] - found.rigid_translation[area] - np.cross(found.rigid_rotation[area], arm)
        assert np.abs(mass @ left).max() < 1e-10
        assert np.abs(mass @ np.cross(arm, left)).max() < 1e-10
