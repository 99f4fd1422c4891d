"""Files that other programs wrote, and sealed: values and parts that the contract does not know are refused."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
from border_tools import Project, edited, tedm, untouched

from tedm_cli.contracts import KINDS
from tedm_cli.contracts.unit_loads import ELEMENTS
from tedm_cli.errors import InputError
from tedm_cli.fem.shapes import CARDS
from tedm_cli.files import columns, trial
from tedm_cli.nastran.masses import elements

READER = {
    "unit_loads.h5": "build-distortion",
    "distortion.h5": "build-optics",
    "sensitivity.h5": "run-case",
    "optics.h5": "run-case",
}


def set_text(path: str, row: int, text: str) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        values = file[path].asstr()[()].tolist()
        attributes = dict(file[path].attrs)
        values[row] = text
        del file[path]
        file[path] = np.array([v.encode() for v in values], dtype=h5py.string_dtype("utf-8", 64))
        file[path].attrs["units"] = attributes["units"]

    return change


def set_number(path: str, row: int, value: int) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        file[path][row] = value

    return change


def shorten(path: str, length: int) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        values, units = file[path][:length], file[path].attrs["units"]
        del file[path]
        file[path] = values
        file[path].attrs["units"] = units

    return change


def rename(old: str, new: str) -> Callable[[h5py.File], None]:
    return lambda file: file.move(old, new)


WRONG = {
    "unknown card": ("unit_loads.h5", set_text("/element/type", 3, "CHEXI"), "/element/type is 'CHEXI' at 3"),
    "unknown shield": ("sensitivity.h5", set_text("/area/shield", 1, "insidd"), "wanted one of inside, outside"),
    "unknown side": ("distortion.h5", set_text("/area/side", 1, "+x"), "/area/side is '+x' at 1, wanted one of +y"),
    "unknown kind of area": ("optics.h5", set_text("/area/kind", 1, "slope"), "is 'slope' at 1, wanted one of mean"),
    "area without name": ("distortion.h5", set_text("/area/name", 2, ""), "/area/name has no name at 2"),
    "area twice": ("sensitivity.h5", set_text("/area/name", 2, "STRUT_1"), "/area/name has 'STRUT_1' twice"),
    "row twice": ("sensitivity.h5", set_text("/row/label", 1, "TM1_a_x"), "/row/label has 'TM1_a_x' twice"),
    "unit of a row": ("sensitivity.h5", set_text("/row/unit", 0, "rod/s^2/K"), "/row/unit is 'rod/s^2/K' at 0"),
    "unit of a read-out": ("optics.h5", set_text("/label/read_out_unit", 0, "n"), "is 'n' at 0, wanted one of m, rad"),
    "column of another element": (
        "optics.h5",
        set_text("/label/element_dof", 6, "M9_ux"),
        "/label/element_dof is 'M9_ux' at 6, wanted ",
    ),
    "unknown quantity": ("optics.h5", set_text("/label/read_out", 5, "TM2_mta"), "is 'TM2_mta' at 5, wanted an end of"),
    "unknown test mass": (
        "sensitivity.h5",
        set_text("/row/label", 5, "TN2_a_z"),
        "/row/label is 'TN2_a_z' at 5, wanted a beginning of /test_mass/name",
    ),
    "set without matrices": ("optics.h5", rename("/N/A", "/N/C"), "/N/C has no name in /set/name"),
    "set without a matrix": ("optics.h5", lambda file: file.pop("/gain/B"), "has no /gain/B"),
    "half a uniform load": (
        "unit_loads.h5",
        lambda file: file.pop("/uniform/rotation"),
        "has no /uniform/rotation, but others of its group",
    ),
    "area without number": ("sensitivity.h5", set_number("/area/id", 2, 0), "/area/id is 0 at 2, wanted at least 1"),
    "node beyond the last": (
        "unit_loads.h5",
        set_number("/element/node_index", 7, 570),
        "is 570 at 7, wanted 0 to 569",
    ),
    "node before the first": ("unit_loads.h5", set_number("/area/node_index", 0, -1), "is -1 at 0, wanted 0 to 569"),
    "mass on no node": ("unit_loads.h5", set_number("/mass/concentrated_node", 1, 9999), "is 9999 at 1"),
    "element that ends before it starts": (
        "unit_loads.h5",
        set_number("/element/node_offset", 3, 0),
        "/element/node_offset must rise from 0 to 2080",
    ),
    "area that ends elsewhere": ("unit_loads.h5", set_number("/area/node_offset", -1, 7), "must rise from 0 to 548"),
    "grids out of order": ("distortion.h5", set_number("/grid/id", 5, 1), "/grid/id does not ascend at 5"),
    "one area less": ("distortion.h5", shorten("/area/name", 27), "/area/name 27 along area, where other"),
    "one edge less": ("unit_loads.h5", shorten("/element/node_offset", 284), "284 along element_edge, wanted 285"),
    "half the rows": ("sensitivity.h5", shorten("/row/label", 6), "/row/label 6 along row, where other"),
}


@pytest.mark.parametrize("name", WRONG)
def test_values_that_cannot_be(small: Project, name: str) -> None:
    file, change, piece = WRONG[name]
    with edited(small.build / file) as opened:
        change(opened)
    with untouched(small.folder):
        small.stage(READER[file]).refused(4, file, piece, hint="make it with `tedm ")


def test_many_problems_are_counted(small: Project) -> None:
    with edited(small.build / "distortion.h5") as file:
        shorten("/area/id", 27)(file)
    outcome = small.stage("build-optics")
    outcome.refused(4, "distortion.h5: /area/name 28 along area, where other datasets have 27")
    assert outcome.err.count(" along area") == 5
    assert re.search(r"; and \d more\n", outcome.err)


@pytest.mark.parametrize(
    ("path", "value", "piece"),
    [
        ("/case/block", 28, "/case/block is 28 at 0, wanted -1 to 27"),
        ("/temperature/spectrum", 2, "/temperature/spectrum is 2 at 0, wanted 0 to 1"),
        ("/verdict/passed", 2, "/verdict/passed is 2 at 0, wanted 0 to 1"),
    ],
)
def test_numbers_of_a_case_that_cannot_be(small: Project, path: str, value: int, piece: str) -> None:
    with edited(small.build / "case03.h5") as file:
        file[path][0] = value
    tedm("export-case", "3", "-d", small.build).refused(4, "case03.h5", piece, hint="make it with `tedm run-case`")


def test_verdicts_on_what_is_not_there(small: Project) -> None:
    for path in ("/verdict/output", "/verdict/requirement", "/improvement/group"):
        shutil.copy(small.build / "case03.h5", small.build / "kept")
        with edited(small.build / "case03.h5") as file:
            set_text(path, 1, "nobody")(file)
        tedm("show", small.build / "case03.h5").refused(4, f"{path} is 'nobody' at 1, wanted one of")
        shutil.copy(small.build / "kept", small.build / "case03.h5")


def test_areas_that_two_files_tell_differently(small: Project) -> None:
    """A group is any word, so it is compared."""
    with edited(small.build / "sensitivity.h5") as file:
        set_text("/area/group", 27, "strqts")(file)
    with untouched(small.folder):
        small.stage("run-case").refused(4, "sensitivity.h5 and", "hold different thermal areas (/area/group)")


def test_cards_of_the_contract_are_those_that_are_read() -> None:
    assert set(ELEMENTS) == {*CARDS, "CPYRAM", "CBUSH", *elements._MASSLESS}


# --- data kept elsewhere ----------------------------------------------------------------------------------------------


def replace_item(name: str, put: Callable[[h5py.File, np.ndarray], None]) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        values, units = file[name][()], file[name].attrs["units"]
        del file[name]
        put(file, values)
        if file.get(name, getlink=True).__class__ is h5py.HardLink:
            file[name].attrs["units"] = units

    return change


def outside(file: h5py.File) -> Path:
    return Path(file.filename).with_name("other.h5")


def external_link(file: h5py.File, values: np.ndarray) -> None:
    with h5py.File(outside(file), "w") as other:
        other["S"] = values
        other["S"].attrs["units"] = "m/s^2/K or rad/s^2/K, see /row/unit"
    file["/S"] = h5py.ExternalLink("other.h5", "/S")


def soft_link(file: h5py.File, values: np.ndarray) -> None:
    file["/elsewhere"] = values
    file["/S"] = h5py.SoftLink("/elsewhere")


def external_storage(file: h5py.File, values: np.ndarray) -> None:
    raw = outside(file).with_suffix(".bin")
    raw.write_bytes(values.tobytes())
    file.create_dataset("/S", values.shape, "f8", external=[(str(raw), 0, values.nbytes)])


def virtual(file: h5py.File, values: np.ndarray) -> None:
    with h5py.File(outside(file), "w") as other:
        other["S"] = values
    layout = h5py.VirtualLayout(values.shape, "f8")
    layout[...] = h5py.VirtualSource(str(outside(file)), "S", values.shape)
    file.create_virtual_dataset("/S", layout)


def never_written(file: h5py.File, values: np.ndarray) -> None:
    file.create_dataset("/S", values.shape, "f8")


def half_written(file: h5py.File, values: np.ndarray) -> None:
    file.create_dataset("/S", values.shape, "f8", chunks=(1, values.shape[1]))
    file["/S"][:5] = values[:5]


ELSEWHERE = {
    "external link": (external_link, "/S is a link to another file"),
    "soft link": (soft_link, "/S is a soft link"),
    "external storage": (external_storage, "/S keeps its values in another file"),
    "virtual dataset": (virtual, "/S is a virtual dataset"),
    "never written": (never_written, "/S lacks values"),
    "half written": (half_written, "/S lacks values"),
}


@pytest.mark.parametrize("name", ELSEWHERE)
def test_data_kept_elsewhere(small: Project, name: str) -> None:
    put, piece = ELSEWHERE[name]
    with edited(small.build / "sensitivity.h5") as file:
        replace_item("/S", put)(file)
    with untouched(small.folder):
        small.stage("run-case").refused(4, "sensitivity.h5", piece, hint="remake it with `tedm build-sensitivity`")


# --- users' tables ----------------------------------------------------------------------------------------------------


def table(path: Path) -> Path:
    with h5py.File(path, "w", libver="v110") as file:
        file["time_s"] = np.arange(100.0)
        file["all"] = np.sin(np.arange(100.0))
    return path


@pytest.mark.parametrize("name", ["external link", "external storage", "virtual dataset", "half written"])
def test_tables_with_data_kept_elsewhere(tmp_path: Path, name: str) -> None:
    path = tmp_path / "table.h5"
    put, piece = ELSEWHERE[name]
    with h5py.File(path, "w") as file:
        file["time_s"] = np.arange(6.0)
        put(file, np.zeros((6, 2)) if name != "half written" else np.zeros((6, 1)))
        if name != "external link":  # a column has one dimension
            del file["/S"]
            flat = {
                "external storage": lambda: file.create_dataset("S", (6,), "f8", external=[("raw.bin", 0, 48)]),
                "virtual dataset": lambda: file.create_virtual_dataset("S", h5py.VirtualLayout((6,), "f8")),
                "half written": lambda: file.create_dataset("S", (6,), "f8", chunks=(2,)),
            }
            flat[name]()
    with pytest.raises(InputError, match=f"table.h5: {piece}"), columns.open_columns(path, "time_s"):
        pass


def test_tables_with_links_within_themselves(tmp_path: Path) -> None:
    with h5py.File(table(tmp_path / "t.h5"), "r+") as file:
        file["STRUT_1"] = h5py.SoftLink("/all")
        file["nowhere"] = h5py.SoftLink("/none")
    with columns.open_columns(tmp_path / "t.h5", "time_s") as found:
        assert found.columns == ["STRUT_1", "all", "time_s"]
        np.testing.assert_array_equal(found.read("STRUT_1", slice(3, 5)), np.sin([3.0, 4.0]))


def test_a_table_that_makes_hdf5_hang_or_fail(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another program stands for HDF5, which hangs or fails at what it does not do in every version."""
    program = tmp_path / "python"
    monkeypatch.setattr(trial.sys, "executable", str(program))
    monkeypatch.setattr(trial, "SECONDS", 0.5)
    for number, (body, fact) in enumerate(
        [
            ("sleep 60", r"cannot be read within 1 s: the file is damaged, or its disk hangs"),
            ("kill -SEGV $$", r"the file is damaged \(a process that tried ended with signal 11\)"),
            ("exit 7", r"the file is damaged \(a process that tried ended with exit code 7\)"),
        ]
    ):
        program.write_text(f"#!/bin/sh\n{'exec ' * body.startswith('sleep')}{body}\n")
        program.chmod(0o755)
        path = table(tmp_path / f"table{number}.h5")
        with pytest.raises(InputError, match=fact), columns.open_columns(path, "time_s"):
            pass


# --- show -------------------------------------------------------------------------------------------------------------


def test_show_of_attributes_of_any_kind(small: Project) -> None:
    path = small.build / "distortion.h5"
    with edited(path) as file:
        file.attrs["matrix"] = np.eye(2)
        file.attrs["words"] = ["a", "b"]
        file.attrs["bytes"] = np.bytes_(b"xyz")
        file.attrs["number"] = np.float32(0.5)
        file.attrs["flag"] = True
        file.attrs["empty"] = h5py.Empty("f8")
        file.attrs["group"] = file["/D"].ref
    assert "distortion" in tedm("show", path).ok().out
    shown = json.loads(tedm("show", path, "--json").ok().out)["attributes"]
    assert shown["matrix"] == [[1.0, 0.0], [0.0, 1.0]]
    assert shown["words"] == ["a", "b"]
    assert (shown["bytes"], shown["number"], shown["flag"]) == ("xyz", 0.5, True)
    assert {"empty", "group"} <= set(shown)


@pytest.mark.parametrize("name", ["schema", "schema_version", "command_line", "tedm_version"])
def test_attributes_that_are_arrays(small: Project, name: str) -> None:
    path = small.build / "distortion.h5"
    with edited(path) as file:
        file.attrs[name] = np.arange(3)
    outcome = tedm("show", path)
    if name.startswith("schema"):
        outcome.refused(4, "distortion.h5", "[0 1 2]")
    else:
        assert "[0 1 2]" in outcome.ok().out or "[0, 1, 2]" in outcome.out


def test_kelvins_of_a_gradient(small: Project) -> None:
    with edited(small.build / "distortion.h5") as file:
        set_text("/area/kind", 1, "gradient")(file)
    small.stage("build-optics").refused(4, "distortion.h5: /area/unit: FLANGE_1 is in K, wanted K/m", hint="again with")


def test_no_dataset_by_area_is_of_kelvins_alone() -> None:
    """Areas may be under a gradient: a unit says both, or is left to /area/unit."""
    by_area = [
        (p, d.units) for kind in KINDS.values() for p, d in kind.datasets.items() if "area" in d.dims and d.units
    ]
    assert len(by_area) > 20
    assert [(p, u) for p, u in by_area if "/K" in u and not u.endswith(" of gradients")] == []


def test_units_that_are_an_array(small: Project) -> None:
    with edited(small.build / "distortion.h5") as file:
        file["/D/translation"].attrs["units"] = np.arange(3)
    small.stage("build-optics").refused(4, "/D/translation has units '[0 1 2]', wanted 'm/K; ")


@pytest.mark.parametrize(
    ("name", "path", "label", "wrong", "right"),
    [
        ("optics.h5", "/label/read_out_unit", "TM1_x", "rad", "m"),
        ("sensitivity.h5", "/row/unit", "TM1_a_x", "rad/s^2/K", "m/s^2/K"),
    ],
)
def test_a_unit_that_is_not_of_its_row(
    small: Project, name: str, path: str, label: str, wrong: str, right: str
) -> None:
    """The requirements of the cases file would not fit, and be blamed."""
    with edited(small.build / name) as file:
        set_text(path, 0, wrong)(file)
    small.stage("run-case").refused(4, f"{name}: {path}: {label} is in {wrong}, wanted {right}", hint="make it again")


def test_a_test_mass_that_is_told_of_twice(chain: Project, tmp_path: Path) -> None:
    out = tmp_path / "figure_6_2.h5"
    chain.run("simulate", "--figure-6.2", "-o", out).ok()
    with edited(out) as file:
        names = file["/row/test_mass"].asstr()[()].tolist()
        row = len(names) - 1
        assert names[row - 1 :] == ["TM1", "TM2"]
        set_text("/row/test_mass", row, "TM1")(file)
    tedm("show", out).refused(
        4, "figure_6_2.h5: /row/test_mass: TM1 of ", "is there twice", hint="simulate --figure-6.2"
    )
