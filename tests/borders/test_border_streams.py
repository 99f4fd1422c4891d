"""Standard output and error that are closed, full or left by their reader; names that would steer a terminal."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from border_tools import Project, replace

from tedm_cli.cli.streams import inert


def shell(text: str, *arguments: object) -> subprocess.CompletedProcess[str]:
    """Run `tedm` (as "$@") in a line of shell."""
    command = ["bash", "-o", "pipefail", "-c", text, "bash", sys.executable, "-m", "tedm_cli.cli"]
    return subprocess.run([*command, *map(str, arguments)], capture_output=True, text=True, check=False)


def test_a_reader_who_has_left(chain: Project) -> None:
    """It is no fault of the command: it ends its work in silence, and its code says how that went."""
    done = shell('"$@" | true', "show", chain.build / "case03.h5")
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(
    ("redirection", "fact"), [(">/dev/full", "No space left on device"), (">&-", "Bad file descriptor")]
)
@pytest.mark.parametrize("arguments", [["show"], ["show", "--json"], ["--help"]])
def test_output_that_cannot_be_written(chain: Project, redirection: str, fact: str, arguments: list[str]) -> None:
    files = [chain.build / "case03.h5"] if arguments[0] == "show" else []
    done = shell(f'"$@" {redirection}', *arguments, *files)
    assert done.returncode == 4, done.stderr
    assert done.stderr == f"error: standard output: cannot be written ({fact}); finished files are kept\n"


@pytest.mark.parametrize("redirection", ["2>&-", "2>/dev/full", ">&- 2>&- <&-"])
def test_nobody_hears_the_error(chain: Project, redirection: str) -> None:
    """The code still says what happened."""
    assert shell(f'"$@" {redirection}', "show", chain.build / "none.h5").returncode == 4


def test_files_are_whole_where_streams_are_closed(chain: Project, tmp_path: Path) -> None:
    """No file takes the number of a closed stream, and gets what is meant for it."""
    project = ["-c", chain.folder / "tedm.toml", "-d", chain.build]
    done = shell('"$@" >&- 2>&- <&-', "build-distortion", "-q", *project, "-o", tmp_path / "d.h5")
    assert done.returncode == 0
    whole = shell('"$@"', "build-distortion", "-q", *project, "-o", tmp_path / "d.h5")
    assert whole.returncode == 0
    assert shell('"$@"', "show", tmp_path / "d.h5").returncode == 0


def test_output_in_a_narrow_encoding(small: Project) -> None:
    """What cannot be encoded is shown as an escape."""
    replace(small.folder / "cases.toml", 'title = "', 'title = "Жук ')
    small.stage("run-case").ok()
    done = shell('PYTHONIOENCODING=ascii "$@"', "show", small.build / "case03.h5")
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("sign", ["\x1b[31m", "\x07", "\r", "\x9b2J", "‮", "⁦", "\x00", " ", "\u200b", "\ufeff"])
def test_signs_that_steer_a_terminal(sign: str) -> None:
    shown = inert(f"a{sign}b\n")
    assert shown.isascii()
    assert shown[:-1].isprintable()
    assert inert("Ünï 漢字 עברית\n") == "Ünï 漢字 עברית\n"


def test_names_in_messages_do_not_steer_a_terminal(tmp_path: Path) -> None:
    done = shell('"$@"', "show", tmp_path / "\x1b]0;title\x07\nerror: forged.h5")
    assert done.returncode == 4
    assert done.stderr.startswith("error: ")
    assert done.stderr.count("\n") <= 2
    assert all(line.isprintable() for line in done.stderr.splitlines())


def test_a_name_that_is_no_utf8(chain: Project, tmp_path: Path) -> None:
    """What it names is written, and says so as far as it can be said."""
    name = os.fsencode(tmp_path) + b"/bad\xff.h5"
    project = ["-c", chain.folder / "tedm.toml", "-d", chain.build]
    done = shell('"$@"', "run-case", "3", "-q", *project, "-o", os.fsdecode(name))
    assert (done.returncode, done.stderr) == (0, "")
    shown = shell('"$@"', "show", os.fsdecode(name))
    assert shown.returncode == 0, shown.stderr
    assert "bad\\udcff.h5" in shown.stdout


def test_a_name_that_is_too_long(chain: Project) -> None:
    done = shell('"$@"', "check", "-d", "a" * 4000)
    assert done.returncode == 4
    # From Python 3.13 on nothing is found under such a name, where older ones say why.
    assert done.stderr.startswith(f"error: {'a' * 4000}: ")
    assert any(fact in done.stderr for fact in ("File name too long", "holds no HDF5 files"))


@pytest.mark.parametrize("length", [250, 255])
def test_the_longest_name_can_be_written(chain: Project, tmp_path: Path, length: int) -> None:
    """Temporaries do not have longer names than what they become."""
    path = tmp_path / ("x" * (length - 4) + ".npz")
    assert shell('"$@"', "export", "--format", "npz", "-d", chain.build, "-o", path).returncode == 0
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_a_full_disk_under_an_archive(chain: Project, tmp_path: Path) -> None:
    done = shell('ulimit -f 20; trap "" XFSZ; "$@"', "export", "--format", "npz", "-d", chain.build, "-o", tmp_path)
    assert done.returncode == 4
    assert len(done.stderr.splitlines()) == 1, done.stderr
    assert "no room left to write it" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written(chain: Project, tmp_path: Path) -> None:
    """/proc stands for a file system that takes no files."""
    done = shell('"$@"', "export", "--format", "npz", "-d", chain.build, "-o", "/proc/x.npz")
    assert done.returncode == 4
    assert len(done.stderr.splitlines()) == 1, done.stderr
    assert "/proc/x.npz: cannot be written" in done.stderr
