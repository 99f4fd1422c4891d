"""A good chain: the same bytes every time, files that other programs open, and hashes of what was read."""

from __future__ import annotations

import hashlib
import json
import shutil
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xarray
from border_tools import STAGES, Project, edited, replace, snapshot, tedm, untouched
from label_scales import is_scale_alone

from tedm_cli.contracts import KINDS

FILES = sorted(STAGES.values())
INPUTS = {
    "unit_loads.h5": {"model.toml", "unit_loads.bdf", "unit_loads.op2", "ltp_small_areas.csv"},
    "distortion.h5": {"optics.toml", "unit_loads.h5"},
    "sensitivity.h5": {"model.toml", "unit_loads.h5", "distortion.h5"},
    "optics.h5": {"optics.toml", "distortion.h5"},
    "adjoint.h5": {
        *("model.toml", "optics.toml", "unit_loads.bdf"),
        *("unit_loads.h5", "distortion.h5", "sensitivity.h5", "optics.h5"),
    },
    "case03.h5": {"cases.toml", "sensitivity.h5", "optics.h5"},
}


def datasets(path: Path) -> dict[str, dict[str, Any]]:
    """Attributes of all datasets of a file but the provenance and the dimension scales."""
    found: dict[str, dict[str, Any]] = {}

    def visit(name: str, item: object) -> None:
        if isinstance(item, h5py.Dataset) and not name.startswith("provenance/") and not is_scale_alone(item):
            found["/" + name] = dict(item.attrs)

    with h5py.File(path) as file:
        file.visititems(visit)
    return found


def test_same_inputs_give_same_bytes_in_any_place(
    chain: Project, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same commands, twice in one folder and once in another at another depth."""
    found = []
    for name in ("here", "here", "some/where/else"):
        folder = tmp_path / name
        ignored = shutil.ignore_patterns("build")
        shutil.copytree(chain.folder, folder, ignore=ignored, dirs_exist_ok=True)
        monkeypatch.chdir(folder)
        for command in STAGES:
            tedm(command, *(["3"] if command == "run-case" else []), "-c", "tedm.toml", "-d", "out").ok()
        found.append(snapshot(folder / "out"))
    tedm("check", "-d", "out").ok()
    assert len(found[0]) == len(STAGES)
    assert found[1] == found[0]
    assert found[2] == found[0]


def test_a_chain_moves_as_a_whole(chain: Project, tmp_path: Path) -> None:
    moved = chain.copy(tmp_path / "moved")
    tedm("check", "-d", moved.build).ok()


def test_check_through_a_link(small: Project, tmp_path: Path) -> None:
    (tmp_path / "deep" / "er").mkdir(parents=True)
    link = tmp_path / "deep" / "er" / "build"
    link.symlink_to(small.build)
    tedm("check", "-d", link).ok()


@pytest.mark.parametrize("name", FILES)
def test_units_meaning_and_frame(chain: Project, name: str) -> None:
    kind = next(kind for kind in KINDS.values() if STAGES[kind.made_by.removeprefix("tedm ")] == name)
    found = datasets(chain.build / name)
    assert set(kind.datasets) - set(found) <= {p for p, d in kind.datasets.items() if "{" in p or d.optional}
    for path, attributes in found.items():
        assert attributes["units"], path
        assert attributes["long_name"], path
        with h5py.File(chain.build / name) as file:
            scales = attributes.get("DIMENSION_LIST", [])
            dims = [file[references[0]].name.rpartition("/")[2] for references in scales]
            assert len(dims) == file[path].ndim or attributes["CLASS"] == b"DIMENSION_SCALE"
            if "xyz" in dims and file[path].dtype.kind == "f" and path not in ("/test_mass/side", "/compensation/size"):
                assert attributes["frame"], path


@pytest.mark.parametrize("name", FILES)
def test_opens_in_xarray(chain: Project, name: str) -> None:
    path = chain.build / name
    groups = sorted({p.rsplit("/", 1)[0] or "/" for p in datasets(path)})
    for group in groups:
        with xarray.open_dataset(path, group=group, engine="h5netcdf") as opened, h5py.File(path) as file:
            for variable, values in opened.data_vars.items():
                if str(variable).startswith("n_"):
                    continue
                item = file[f"{group}/{variable}"]
                assert values.attrs["units"] == item.attrs["units"]
                for dim in values.dims:
                    assert str(dim).startswith("n_") != (dim in opened.coords), dim
                assert values.shape == item.shape
                if item.dtype.kind == "f":
                    np.testing.assert_array_equal(values.values, item[()])


def test_xarray_knows_dimensions_and_labels(chain: Project) -> None:
    """In any group, and under the name of the label where a group has that of the dimension."""
    with xarray.open_dataset(chain.build / "distortion.h5", group="/D", engine="h5netcdf") as opened:
        assert opened["translation"].dims == ("area", "node", "xyz")
        with h5py.File(chain.build / "distortion.h5") as file:
            area, node = list(file["/area/name"].asstr()[()]).index("STRUT_5"), list(file["/grid/id"]).index(12)
            wanted = file["/D/translation"][area, node, 1]
        assert opened["translation"].sel(area="STRUT_5", node=12, xyz="y").item() == wanted
    with xarray.open_dataset(chain.build / "sensitivity.h5", group="/stiffness", engine="h5netcdf") as opened:
        assert opened["gamma_lin"].dims == ("test_mass", "source", "xyz", "xyz_column")
        assert opened["source"].values.tolist() == ["structure", "other test mass"]
    with xarray.open_dataset(chain.build / "sensitivity.h5", engine="h5netcdf") as opened:
        assert opened["S"].sel(row_label="TM2_a_y", area_name="STRUT_5").item() != 0.0
    with xarray.open_dataset(chain.build / "case03.h5", group="/psd", engine="h5netcdf") as opened:
        assert opened["frequency"].attrs["units"] == "Hz"
        assert opened["TM1_a_x"].sel(frequency=1e-3, method="nearest").item() > 0.0
    with xarray.open_dataset(chain.build / "case03.h5", group="/improvement", engine="h5netcdf") as opened:
        assert opened["area"].dims == ("n_verdict", "n_rank")  # places without labels
        assert opened["silenced"].dims == ("n_verdict", "count")


@pytest.mark.parametrize("path", ["/D/area", "/D/node", "/D_opt/xyz"])
def test_a_wrong_label_of_a_dimension_is_refused(small: Project, path: str) -> None:
    """No stage reads it, but whoever opens the file elsewhere does."""
    with edited(small.build / "distortion.h5") as file:
        values = file[path][()]
        file[path][:2] = values[1::-1]
    small.run("build-sensitivity").refused(4, "distortion.h5", f"{path} labels")
    with edited(small.build / "distortion.h5") as file:
        file[path][:2] = values[:2]
    small.run("build-sensitivity").ok()


def test_a_file_without_labels_of_dimensions_is_read(small: Project) -> None:
    """As tedm wrote it before, or another program does."""
    with edited(small.build / "distortion.h5") as file:
        scales: list[str] = []
        file.visititems(lambda name, item: scales.append(name) if "CLASS" in item.attrs else None)
        assert len(scales) > 10
        for name in scales:
            del file[name]
    small.run("build-sensitivity").ok()


def test_opens_in_xarray_without_requirements(small: Project) -> None:
    """Dimensions of length zero are no trouble."""
    cases = small.folder / "cases.toml"
    tables = cases.read_text().split("[[")
    cases.write_text("[[".join(table for table in tables if not table.startswith("requirement]]")))
    small.stage("run-case").ok()
    with xarray.open_dataset(small.build / "case03.h5", group="/verdict", engine="h5netcdf") as opened:
        assert opened["ratio"].shape == (0,)
    tedm("show", small.build / "case03.h5").ok()


@pytest.mark.parametrize("name", FILES)
def test_provenance(chain: Project, name: str) -> None:
    with h5py.File(chain.build / name) as file:
        p = {key: list(value.asstr()[()]) for key, value in file["provenance"].items()}
        assert str(file.attrs["command_line"]).startswith("tedm ")
        assert not [key for key in file.attrs if "time" in key or "date" in key]
    for kind in ("config", "input"):
        for path, sha in zip(p[f"{kind}_path"], p[f"{kind}_sha256"], strict=True):
            assert not Path(path).is_absolute()
            assert hashlib.sha256((chain.build / path).read_bytes()).hexdigest() == sha
    for path, text in zip(p["config_path"], p["config_text"], strict=True):
        assert text == (chain.build / path).read_text()
    assert {Path(path).name for path in [*p["config_path"], *p["input_path"]]} == INPUTS[name]


@pytest.mark.parametrize("name", FILES)
def test_show(chain: Project, name: str) -> None:
    path = chain.build / name
    text = tedm("show", path).ok().out
    shown = json.loads(tedm("show", path, "--json").ok().out)
    assert {d["path"] for d in shown["datasets"]} == set(datasets(path))
    for dataset in shown["datasets"]:
        line = next(line for line in text.splitlines() if line.split(" ")[0] == dataset["path"])
        assert dataset["units"] in line
        assert dataset["long_name"] in line
    assert {Path(i["path"]).name for i in [*shown["inputs"], *shown["configurations"]]} == INPUTS[name]
    assert shown["main"]
    for key in shown["main"]:  # "output requirement" of a verdict, which is a row of the table
        assert f"{key}: " in text or any(line.split()[: len(key.split())] == key.split() for line in text.splitlines())


def test_check_of_a_fresh_chain(chain: Project) -> None:
    assert tedm("check", "-d", chain.build).ok().out.count("up to date") == len(FILES)
    assert all(c["up_to_date"] for c in json.loads(tedm("check", "-d", chain.build, "--json").ok().out))


def test_a_requirement_that_fails_is_a_result(small: Project) -> None:
    replace(small.folder / "cases.toml", "safety_factor = ", "safety_factor = 1000.0 # ")
    shown = json.loads(small.run("run-case", "3", "--json").ok().out)
    assert not shown[0]["passed"]
    outcome = small.run("run-case", "3", "--fail-on-violation")
    assert outcome.code == 5
    assert "case 3" in outcome.err


def test_an_optical_element_in_millimetres(small: Project) -> None:
    replace(small.folder / "optics.toml", "ref_m = [0.088, 0.096, 0.0]", "ref_m = [88.0, 96.0, 0.0]")
    with untouched(small.folder):
        small.run("build-distortion").refused(
            3, "optics.toml: element[3].ref_m: FIR is 130.1 m away from its grid 900002", hint="in metres"
        )


def test_the_length_of_a_lever_is_printed(small: Project) -> None:
    """3 mm along x and 4 mm along y are 5 mm."""
    replace(small.folder / "optics.toml", "ref_m = [0.125, 0.0, 0.0]", "ref_m = [0.128, 0.004, 0.0]")  # of a window
    assert "up to 0.005 m from" in small.run("build-optics").out


@pytest.mark.parametrize(
    ("old", "new", "fact"),
    [
        ("SPC1", "$ SPC1", "the structure is not held"),
        ("CHEXA,1,1,1,2,3,4,5,6\n,7,8", "CHEXA,1,1,5,6,7,8,1,2\n,3,4", "Jacobian that is not positive: 1"),
    ],
)
def test_what_cannot_be_solved_is_said_of_the_deck(tiny: Project, old: str, new: str, fact: str) -> None:
    replace(tiny.deck, old, new)
    replace(tiny.deck, "SPC = 1", "$ SPC = 1")
    with untouched(tiny.folder):
        tiny.run("solve").refused(5, "unit_loads.bdf: ", fact)


def test_one_block_is_one_block(small: Project) -> None:
    assert " in 1 block; ratio" in small.run("run-case", 1).ok().out
