"""[D] of loads of 1 K is a view of the displacements: the same numbers as a copy, and none where they are others."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from benchmarks import synthetic
from tedm_cli.config.project import Project
from tedm_cli.contracts import DISTORTION, UNIT_LOADS
from tedm_cli.errors import InputError
from tedm_cli.files.seal import seal
from tedm_cli.files.store import open_checked
from tedm_cli.progress import silent
from tedm_cli.stages.gravity.sensitivity import build_sensitivity
from tedm_cli.stages.model.distortion import build_distortion

D = DISTORTION.D_TRANSLATION


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Project:
    where = synthetic.project(tmp_path_factory.mktemp("made"), "lumped")
    synthetic.write_unit_loads(where, synthetic.block((6, 5, 4)), 5)
    build_distortion(where, None, silent)
    return where


@pytest.fixture
def copy(made: Project, tmp_path: Path) -> Path:
    """A folder with the two files."""
    for name in ("unit_loads.h5", "distortion.h5"):
        shutil.copy(made.build_dir / name, tmp_path)
    return tmp_path


def numbers(path: Path) -> dict[str, np.ndarray]:
    with open_checked(path, DISTORTION) as file:
        return {name: file.array(name) for name, d in DISTORTION.datasets.items() if d.dtype in ("float", "real")}


def test_a_view_and_a_copy_have_the_same_numbers(made: Project, tmp_path: Path) -> None:
    """A file in another folder than the displacements is a copy of them."""
    build_distortion(made, tmp_path / "distortion.h5", silent)
    with h5py.File(made.build_dir / "distortion.h5") as view, h5py.File(tmp_path / "distortion.h5") as plain:
        assert (view[D].is_virtual, plain[D].is_virtual) == (True, False)
        assert view[D].dtype == plain[D].dtype == np.float32
        assert dict(view[D].attrs.items()).keys() == dict(plain[D].attrs.items()).keys()
        assert view[D].dims[1][0].name == "/D/node"
        np.testing.assert_array_equal(view[D][()], plain[D][()])  # as other programs read them
    one, other = numbers(made.build_dir / "distortion.h5"), numbers(tmp_path / "distortion.h5")
    assert one[D].any(axis=(1, 2)).all()
    for name, values in one.items():
        np.testing.assert_array_equal(values, other[name], err_msg=name)


def test_what_the_disk_holds_once(made: Project, tmp_path: Path) -> None:
    build_distortion(made, tmp_path / "distortion.h5", silent)
    with open_checked(made.build_dir / "unit_loads.h5", UNIT_LOADS) as unit:
        size = unit.dataset(UNIT_LOADS.TRANSLATION).held(...).nbytes
    less = (tmp_path / "distortion.h5").stat().st_size - (made.build_dir / "distortion.h5").stat().st_size
    assert less > 0.9 * size


def test_sensitivities_of_either_have_the_same_bits(made: Project, copy: Path) -> None:
    found = {}
    for folder in ("view", "plain"):
        out = copy / folder
        project = Project(**{**vars(made), "build_dir": out})
        out.mkdir()
        shutil.copy(copy / "unit_loads.h5", out)
        build_distortion(made, copy / "distortion.h5", silent)
        shutil.copy(made.build_dir / "distortion.h5" if folder == "view" else copy / "distortion.h5", out)
        with h5py.File(out / "distortion.h5") as file:
            assert file[D].is_virtual is (folder == "view")
        build_sensitivity(project, None, silent)
        with h5py.File(out / "sensitivity.h5") as file:
            found[folder] = file["/S"][()]
    np.testing.assert_array_equal(found["view"], found["plain"])


def test_a_moved_folder_and_links_to_the_files_are_read(copy: Path) -> None:
    wanted = numbers(copy / "distortion.h5")[D]
    copy.rename(copy.with_name("moved"))
    moved = copy.with_name("moved")
    copy.mkdir()
    for name in ("unit_loads.h5", "distortion.h5"):
        os.symlink(moved / name, copy / name)
    for folder in (moved, copy):
        np.testing.assert_array_equal(numbers(folder / "distortion.h5")[D], wanted)


def test_loads_of_other_steps_are_divided_and_kept(made: Project, copy: Path) -> None:
    with h5py.File(copy / "unit_loads.h5", "r+") as file:
        file[UNIT_LOADS.AREA_LOAD_K][...] = 4.0
        file[UNIT_LOADS.UNIFORM_LOAD_K][...] = 4.0
    seal(copy / "unit_loads.h5")
    build_distortion(Project(**{**vars(made), "build_dir": copy}), None, silent)
    with h5py.File(copy / "distortion.h5") as file, h5py.File(copy / "unit_loads.h5") as unit:
        assert not file[D].is_virtual
        np.testing.assert_array_equal(file[D][()], unit[UNIT_LOADS.TRANSLATION][()].astype(np.float64) / 4.0)


def gone(folder: Path) -> None:
    (folder / "unit_loads.h5").unlink()


def another(folder: Path) -> None:
    """Whole and sealed, and of another run."""
    with h5py.File(folder / "unit_loads.h5", "r+") as file:
        file[UNIT_LOADS.TRANSLATION][0, 0, 0] += 1e-9
    seal(folder / "unit_loads.h5")


def written_through(folder: Path) -> None:
    """Another program writes into [D], and HDF5 into the displacements."""
    with h5py.File(folder / "distortion.h5", "r+") as file:
        file[D][1] *= 2.0
    seal(folder / "distortion.h5")


def truncated(folder: Path) -> None:
    data = (folder / "unit_loads.h5").read_bytes()
    (folder / "unit_loads.h5").write_bytes(data[:-5000])


CHANGED = {
    "gone": (gone, r"distortion\.h5: /D/translation is a view of unit_loads\.h5, which is not beside it"),
    "another": (another, r"distortion\.h5: is stale: /D/translation is a view of .*unit_loads\.h5, which is not as it"),
    "written through": (written_through, r"unit_loads\.h5: (is damaged|carries no seal)"),
    "truncated": (truncated, r"unit_loads\.h5: carries no seal"),
}


@pytest.mark.parametrize("name", CHANGED)
def test_no_numbers_of_a_file_that_is_another(copy: Path, name: str) -> None:
    """HDF5 itself would read zeros, or the other numbers."""
    change, fact = CHANGED[name]
    change(copy)
    with open_checked(copy / "distortion.h5", DISTORTION) as file:
        assert np.abs(file.array(DISTORTION.D_OPT_TRANSLATION)).max() > 0.0  # is in the file itself
        with pytest.raises(InputError, match=fact) as caught:
            file.array(D)
    assert "tedm build-distortion" in str(caught.value.hint)


def other_file(source: h5py.File, layout: h5py.VirtualLayout, shape: tuple[int, ...]) -> None:
    layout[...] = h5py.VirtualSource("/etc/unit_loads.h5", "/translation", shape)


def other_numbers(source: h5py.File, layout: h5py.VirtualLayout, shape: tuple[int, ...]) -> None:
    layout[...] = h5py.VirtualSource("unit_loads.h5", "/rotation", shape)


def a_part(source: h5py.File, layout: h5py.VirtualLayout, shape: tuple[int, ...]) -> None:
    layout[:3] = h5py.VirtualSource("unit_loads.h5", "/translation", shape)[:3]


def nothing(source: h5py.File, layout: h5py.VirtualLayout, shape: tuple[int, ...]) -> None:
    pass


@pytest.mark.parametrize("put", [other_file, other_numbers, a_part, nothing])
def test_a_view_of_anything_else_is_refused(
    copy: Path, put: Callable[[h5py.File, h5py.VirtualLayout, tuple[int, ...]], None]
) -> None:
    with h5py.File(copy / "distortion.h5", "r+") as file:
        shape, units = file[D].shape, file[D].attrs["units"]
        del file[D]
        layout = h5py.VirtualLayout(shape, "f4")
        put(file, layout, shape)
        file.create_virtual_dataset(D, layout)
        file[D].attrs["units"] = units
    seal(copy / "distortion.h5")
    fact = r"/D/translation is a virtual dataset of other data than /translation of unit_loads\.h5, whole"
    with pytest.raises(InputError, match=fact), open_checked(copy / "distortion.h5", DISTORTION):
        pass
