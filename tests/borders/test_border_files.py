"""Files between stages: what is not as the contract says, or not of one piece with the rest, is refused by name."""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
from border_tools import STAGES, Project, edited, in_child, replace, snapshot, tedm, untouched

from tedm_cli.files.seal import seal

# The stage that reads each file.
READER = {
    "unit_loads.h5": "build-distortion",
    "distortion.h5": "build-optics",
    "sensitivity.h5": "run-case",
    "optics.h5": "run-case",
}


def edit(path: Path, change: Callable[[h5py.File], object]) -> None:
    with edited(path) as file:
        change(file)


def delete(name: str) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        del file[name]

    return change


def set_attribute(name: str, value: object, at: str = "/") -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        file[at].attrs[name] = value

    return change


def put(name: str, value: object) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        attributes = dict(file[name].attrs)
        del file[name]
        file[name] = value
        file[name].attrs["units"] = attributes["units"]

    return change


def remove_attribute(name: str, at: str = "/") -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        del file[at].attrs[name]

    return change


BROKEN = {
    "later version": ("distortion.h5", set_attribute("schema_version", 99), "schema version 99, this tedm reads"),
    "version of another type": ("distortion.h5", set_attribute("schema_version", "one"), "schema version one"),
    "no version": ("distortion.h5", remove_attribute("schema_version"), "schema version none"),
    "no schema": ("distortion.h5", remove_attribute("schema"), "holds no tedm schema"),
    "no command": ("distortion.h5", remove_attribute("command_line"), "command_line is missing"),
    "no provenance": ("distortion.h5", delete("/provenance"), "/provenance/input_sha256 is missing"),
    "half a provenance": ("distortion.h5", delete("/provenance/input_sha256"), "/provenance/input_sha256 is missing"),
    "no matrix": ("distortion.h5", delete("/D/translation"), "has no /D/translation, but others of its group"),
    "no group": ("unit_loads.h5", delete("/area"), "/area/id is missing"),
    "no read-out": ("optics.h5", delete("/N"), "/N/{set} is missing"),
    "too few nodes": ("unit_loads.h5", put("/grid/position", np.zeros((3, 3))), "/grid/position 3 along node"),
    "too few axes": ("unit_loads.h5", put("/grid/position", np.zeros(570)), "/grid/position has 1 dimensions"),
    "two columns": ("sensitivity.h5", put("/test_mass/position", np.zeros((2, 2))), "2 along xyz"),
    "text for numbers": ("unit_loads.h5", put("/mass/total", "heavy"), "/mass/total holds object, wanted float"),
    "single precision": ("unit_loads.h5", put("/mass/total", np.int64(3)), "/mass/total holds int64, wanted float"),
    "other unit": ("unit_loads.h5", set_attribute("units", "mm", "/grid/position"), "/grid/position has units 'mm'"),
    "no unit": ("sensitivity.h5", remove_attribute("units", "/S"), "/S has no units"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_file(small: Project, name: str) -> None:
    file, change, piece = BROKEN[name]
    edit(small.build / file, change)
    with untouched(small.folder):
        small.stage(READER[file]).refused(4, file, piece, hint="make it with `tedm ")
    outcome = tedm("check", "-d", small.build)
    assert outcome.code == 4
    assert file in outcome.err
    assert piece in outcome.out


@pytest.mark.parametrize("file", READER)
def test_file_of_another_kind(small: Project, file: str) -> None:
    other = "optics.h5" if file == "sensitivity.h5" else "sensitivity.h5"
    (small.build / file).write_bytes((small.build / other).read_bytes())
    with untouched(small.folder):
        small.stage(READER[file]).refused(4, file, f"holds tedm.{other[:-3]}, wanted tedm.{file[:-3]}", hint="tedm ")


@pytest.mark.parametrize("file", READER)
def test_missing_file_says_what_makes_it(small: Project, file: str) -> None:
    (small.build / file).unlink()
    with untouched(small.folder):
        small.stage(READER[file]).refused(4, file, hint="tedm ")


@pytest.mark.parametrize("share", [0.0, 0.001, 0.5, 0.999])
def test_truncated_file(small: Project, share: float) -> None:
    path = small.build / "distortion.h5"
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    with untouched(small.folder):
        small.stage("build-optics").refused(4, "distortion.h5", hint="tedm build-distortion")
        tedm("show", path).refused(4, "distortion.h5")
    assert "distortion.h5" in tedm("check", "-d", small.build).err


def test_overwritten_bytes_are_never_the_fault_of_tedm_or_of_the_target(small: Project, tmp_path: Path) -> None:
    """Damage in HDF5's own records: it is noticed and blamed on the right file, or does no harm to what is read."""
    path = small.build / "distortion.h5"
    data = path.read_bytes()
    random = np.random.default_rng(5)
    noticed = 0

    def run() -> None:
        outcome = small.stage("build-optics")
        print(outcome.err)
        sys.exit(outcome.code)

    records = [match.start() for match in re.finditer(rb"OHDR|GCOL|FRHP|FHDB|FADB|BTHD|SNOD|TREE|HEAP", data)]
    for place in [0, 8, *random.choice(records, 12, replace=False)]:
        path.write_bytes(data[:place] + random.bytes(64) + data[place + 64 :])
        before = snapshot(small.build)
        log = tmp_path / "log"
        # In a process of its own, lest a fault inside the HDF5 library end the tests.
        code = os.waitstatus_to_exitcode(in_child(run, log))
        if code != 0:
            noticed += 1
            assert snapshot(small.build) == before
            assert code in (4, 5), log.read_text()
            assert "/distortion.h5: " in log.read_text() or code == 5, log.read_text()
    assert noticed >= 5


def test_stale_distortion_is_refused(small: Project) -> None:
    replace(small.model, "mid_half_width_m = 0.005", "mid_half_width_m = 0.006")
    small.stage("ingest").ok()
    with untouched(small.folder):
        small.stage("build-sensitivity").refused(
            4, "distortion.h5", "stale", "unit_loads.h5", hint="tedm build-distortion"
        )


def test_two_distortions_are_not_mixed(small: Project) -> None:
    replace(small.folder / "optics.toml", "title =", "# one comment more\ntitle =")
    small.stage("build-distortion").ok()
    small.stage("build-optics").ok()
    with untouched(small.folder):
        small.stage("run-case").refused(4, "sensitivity.h5", "optics.h5", "distortion.h5", hint="tedm check")


def test_check_follows_the_chain(small: Project) -> None:
    tedm("check", "-d", small.build).ok()
    replace(small.model, "mid_half_width_m = 0.005", "mid_half_width_m = 0.006")
    outcome = tedm("check", "-d", small.build)
    outcome.refused(4, "6 of 6 files")
    lines = outcome.out.splitlines()
    place = next(i for i, line in enumerate(lines) if "unit_loads.h5 (unit_loads): stale" in line)
    assert "model.toml has changed since" in lines[place + 1]
    found = {Path(c["file"]).name: c for c in json.loads(tedm("check", "--json", "-d", small.build).out)}
    assert "unit_loads.h5 is not up to date" in found["distortion.h5"]["problems"][0]
    assert not found["case03.h5"]["up_to_date"]
    for command in STAGES:
        small.stage(command).ok()
    tedm("check", "-d", small.build).ok()


@pytest.mark.parametrize("name", ["cases.toml", "optics.toml", "unit_loads.op2", "unit_loads.bdf"])
def test_check_names_the_file_and_its_input(small: Project, name: str) -> None:
    path = small.folder / name
    path.write_bytes(path.read_bytes() + b"\n")
    made_of_it = {
        "cases.toml": {"case03.h5"},
        "optics.toml": {"distortion.h5", "sensitivity.h5", "optics.h5", "adjoint.h5", "case03.h5"},
    }
    outcome = tedm("check", "--json", "-d", small.build)
    assert outcome.code == 4
    stale = {Path(c["file"]).name for c in json.loads(outcome.out) if not c["up_to_date"]}
    assert stale == made_of_it.get(name, set(STAGES.values()))
    assert f"{name} has changed since" in outcome.out
    path.unlink()
    assert f"{name} is gone" in tedm("check", "-d", small.build).out


def test_check_of_an_empty_folder(tmp_path: Path) -> None:
    tedm("check", "-d", tmp_path).refused(4, str(tmp_path), hint="tedm run")


@pytest.mark.parametrize("name", ["there/is/none.h5", "tedm.toml"])
def test_show_of_something_else(small: Project, name: str) -> None:
    tedm("show", small.folder / name).refused(4, name)


def test_show_of_a_foreign_hdf5(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "foreign.h5", "w") as file:
        file["x"] = 1.0
    tedm("show", tmp_path / "foreign.h5").refused(4, "foreign.h5", "carries no seal", hint="tedm_cli.files.seal")
    seal(tmp_path / "foreign.h5")
    tedm("show", tmp_path / "foreign.h5").refused(4, "foreign.h5", "no tedm schema", hint="unit_loads")


@pytest.mark.parametrize("command", STAGES)
def test_target_that_cannot_be_written(small: Project, command: str) -> None:
    (small.build / "taken").mkdir()
    (small.build / "file").write_text("")
    for target in (small.build / "taken", small.build / "file" / "x.h5"):
        with untouched(small.folder):
            arguments = ["3"] if command == "run-case" else []
            small.run(command, *arguments, "-o", target).refused(4, str(target), "cannot be written")
