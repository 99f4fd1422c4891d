"""The command that writes the mesh: what it prints, writes and refuses."""

from __future__ import annotations

from pathlib import Path

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
