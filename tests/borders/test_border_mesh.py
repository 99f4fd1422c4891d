"""The command that writes the mesh: what it prints, writes and refuses."""

from __future__ import annotations

import csv
from pathlib import Path

import h5py
import pytest
from border_tools import Project, snapshot, tedm, untouched


def test_files_are_named_and_the_same_every_time(chain: Project, tmp_path: Path) -> None:
    asked = ("--area", "uniform", "--of", "TM1_a_x", "--case", "3", "-d", chain.build)
    out = tedm("export-vtu", *asked, "-o", tmp_path / "a" / "m.vtu").ok().out
    for name in ("m.vtu", "m_arrays.csv", "m_colours.json"):
        assert str(tmp_path / "a" / name) in out
    assert "share_TM1_a_x_case3" in out
    tedm("export-vtu", *asked, "-o", tmp_path / "b" / "m.vtu", "-q").ok()
    assert snapshot(tmp_path / "a") == snapshot(tmp_path / "b")
    assert set(snapshot(tmp_path / "a")) == {"m.vtu", "m_arrays.csv", "m_colours.json"}


@pytest.mark.parametrize(
    ("args", "code", "fact", "hint"),
    [
        (("--area", "STRUT1"), 2, "no area is called 'STRUT1'", "STRUT_1"),
        (("--of", "TM1_a"), 2, "no output is called 'TM1_a'", "TM1_a_"),
        (("--case", "4b"), 2, "no case that was run is called '4b'", "there are 3"),
        (("--output", "TM1_a_x"), 2, "TM1_a_x does not end in .vtu", "--of chooses an output"),
    ],
)
def test_refusals_write_nothing(chain: Project, args: tuple[str, str], code: int, fact: str, hint: str) -> None:
    with untouched(chain.build):
        tedm("export-vtu", *args, "-d", chain.build).refused(code, fact, hint=hint)


def test_a_folder_without_results(tmp_path: Path) -> None:
    tedm("export-vtu", "-d", tmp_path).refused(4, "unit_loads.h5: no such file", hint="tedm ingest")


def test_what_an_expanding_test_mass_makes_is_at_no_grid(small: Project, tmp_path: Path) -> None:
    """The area that carries it makes more of the read-out than its grids: the arrays say how much."""
    with h5py.File(small.build / "optics.h5") as file:
        area = str(file["/area/name"].asstr()[0])
    with open(small.folder / "optics.toml", "a", encoding="utf-8") as stream:
        stream.write(f'\n[[test_mass_expansion]]\ntest_mass = "TM1"\narea = "{area}"\nexpansion_per_K = 1.65e-5\n')
    for command in ("build-optics", "build-adjoint", "run-case"):
        small.stage(command).ok()
    asked = ("--area", area, "--of", "A_TM1_x", "--case", "3", "-d", small.build)
    tedm("export-vtu", *asked, "-o", tmp_path / "m.vtu").ok()
    with open(tmp_path / "m_arrays.csv", encoding="utf-8", newline="") as stream:
        rows = {row["array"]: row for row in csv.DictReader(stream)}
    with h5py.File(small.build / "optics.h5") as file:
        N = file["/N/A"][file["/label/read_out"].asstr()[()].tolist().index("TM1_x"), 0]
    for name, whole in ((f"contribution_A_TM1_x_{area}", N), ("share_A_TM1_x_case3", 1.0)):
        row = rows[name]
        rest = float(row["meaning"].split("; ")[1].split(" more at no grid")[0])
        assert abs(rest) > 1e-4 * abs(whole)
        assert float(row["sum"]) + rest == pytest.approx(whole, rel=1e-5, abs=0)
