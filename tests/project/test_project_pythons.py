"""The Pythons that are promised: which one Make takes, and pyNastran where a plain installation leaves it out."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from tedm_cli.errors import InputError
from tedm_cli.nastran import library
from tedm_cli.nastran.op2.walk import walked
from tedm_cli.nastran.reading import read_deck

ROOT = Path(__file__).parents[2]
PROMISED = ["3.11", "3.12", "3.13"]


@pytest.fixture
def path_of(tmp_path: Path):
    """A function that makes a search path on which the given names are Pythons that run, or do not."""

    def make(**runs: bool) -> Path:
        for name, running in runs.items():
            program = tmp_path / name.replace("_", ".")
            program.write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n' if running else "#!/bin/sh\nexit 127\n")
            program.chmod(0o755)
        for tool in ("make", "find", "sh", "test", "touch"):
            where = shutil.which(tool)
            if where is None:
                pytest.skip(f"needs {tool}")
            (tmp_path / tool).symlink_to(where)
        return tmp_path

    return make


def make(path: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    environment = {"PATH": str(path), "HOME": os.environ.get("HOME", "/")}
    command = [str(path / "make"), "--no-print-directory", "-n", *arguments]
    return subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)


def chosen(path: Path) -> str:
    return re.search(r"PYTHON=(\S*?),", make(path, "help").stdout)[1]  # type: ignore[index]


@pytest.mark.parametrize(
    ("runs", "taken"),
    [
        ({"python3_11": True, "python3_12": True, "python3": True}, "python3.11"),
        ({"python3_11": False, "python3_13": True, "python3": True}, "python3.13"),
        ({"python3_11": False, "python3_12": False, "python3": True}, "python3"),
        ({"python3_11": False, "python3": False}, None),
    ],
)
def test_make_takes_the_first_python_that_runs(path_of, runs: dict[str, bool], taken: str | None) -> None:
    path = path_of(**runs)
    assert chosen(path) == (str(path / taken) if taken else "")


def test_make_without_a_python_says_what_it_needs(path_of, tmp_path: Path) -> None:
    path = path_of(python3=False)
    command = [str(path / "make"), f"VENV={tmp_path / 'venv'}", str(tmp_path / "venv" / ".tedm-installed")]
    done = subprocess.run(command, cwd=ROOT, env={"PATH": str(path)}, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "tedm needs Python 3.11, 3.12 or 3.13" in done.stderr
    assert not (tmp_path / "venv").exists()


def test_the_promise_is_the_same_everywhere() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["requires-python"] == ">=3.11,<3.14"
    for text in ("README.md", "docs/how-to/install.md", ".ci/run", "Makefile"):
        words = (ROOT / text).read_text(encoding="utf-8")
        assert all(version in words for version in PROMISED), text


def test_without_pynastran_one_line_says_how_it_is_had(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "find_spec", lambda name: None)
    for read in (lambda: read_deck(tmp_path / "a.bdf"), lambda: walked(tmp_path / "a.op2").__enter__()):
        with pytest.raises(InputError, match="pyNastran, which reads decks and results, is not installed") as caught:
            read()
        pinned = re.search(r"(?m)^pyNastran==(\S+)$", (ROOT / "constraints.txt").read_text(encoding="utf-8"))
        assert pinned is not None
        assert caught.value.hint == f"python -m pip install --no-deps pyNastran=={pinned[1]}"


def test_the_name_that_numpy_dropped_is_put_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(np, "in1d", raising=False)
    library.restore_names()
    np.testing.assert_array_equal(vars(np)["in1d"]([1, 5, 2], [2, 1]), [True, False, True])
