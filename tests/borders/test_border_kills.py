"""Runs that end badly: killed, interrupted, out of space. The old file stays, and no part of a new one does."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
from pathlib import Path
from unittest import mock

import pytest
from border_tools import STAGES, Project, in_child, snapshot

from tedm_cli.contracts import KINDS, FileKind
from tedm_cli.files import store


def write_until(project: Project, command: str, number: int) -> None:
    """Run a stage that sends itself signal `number` when half of its datasets are on disk."""
    counted = len(kinds_of(command).datasets) // 2
    calls = 0
    original = store.Writer._make

    def make(self: store.Writer, *args: object) -> object:
        nonlocal calls
        dataset = original(self, *args)  # type: ignore[arg-type]
        calls += 1
        if calls == counted:
            self._file.flush()
            os.kill(os.getpid(), number)
        return dataset

    with mock.patch.object(store.Writer, "_make", make):
        outcome = project.stage(command)
    print(outcome.err, file=sys.stderr)
    sys.exit(outcome.code)


def kinds_of(command: str) -> FileKind:
    return next(kind for kind in KINDS.values() if kind.made_by == f"tedm {command}")


def leftovers(project: Project) -> list[Path]:
    return sorted(project.build.glob(".*"))


@pytest.mark.parametrize("had_file", [True, False], ids=["over an old file", "without an old file"])
@pytest.mark.parametrize("command", STAGES)
def test_killed_writer(small: Project, tmp_path: Path, command: str, had_file: bool) -> None:
    target = small.build / STAGES[command]
    if not had_file:
        target.unlink()
    before = snapshot(small.folder)

    status = in_child(lambda: write_until(small, command, signal.SIGKILL), tmp_path / "log")

    assert os.WIFSIGNALED(status), (tmp_path / "log").read_text()
    assert os.WTERMSIG(status) == signal.SIGKILL
    assert len(leftovers(small)) == 1, "the writer was killed before it wrote anything"
    after = snapshot(small.folder)
    assert {name: after[name] for name in after if Path(name).name[0] != "."} == before

    small.stage(command).ok()
    assert leftovers(small) == []
    assert target.is_file()


@pytest.mark.parametrize("command", STAGES)
def test_interrupted_writer(small: Project, tmp_path: Path, command: str) -> None:
    before = snapshot(small.folder)
    log = tmp_path / "log"
    status = in_child(lambda: write_until(small, command, signal.SIGINT), log)
    assert os.waitstatus_to_exitcode(status) == 130, log.read_text()
    assert log.read_text().strip() == "error: interrupted; finished files are kept, the unfinished one is removed"
    assert snapshot(small.folder) == before


def limit_file_size(size: int) -> None:
    """A write beyond this many bytes fails as on a full disk (EFBIG in place of ENOSPC)."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


@pytest.mark.parametrize("command", STAGES)
@pytest.mark.parametrize("share", [0.02, 0.999])
def test_no_room(small: Project, tmp_path: Path, command: str, share: float) -> None:
    before = snapshot(small.folder)
    size = (small.build / STAGES[command]).stat().st_size
    log = tmp_path / "log"

    def run() -> None:
        limit_file_size(int(share * size))
        outcome = small.stage(command)
        outcome.refused(4, STAGES[command], "no room left")
        sys.exit(outcome.code)

    status = in_child(run, log)
    assert os.waitstatus_to_exitcode(status) == 4, log.read_text()
    assert snapshot(small.folder) == before


def test_no_room_in_a_process_of_its_own(small: Project) -> None:
    """Nothing more is said, and no other code is given, when the interpreter and the HDF5 library shut down."""
    before = snapshot(small.folder)
    arguments = ["build-distortion", "-c", str(small.folder / "tedm.toml"), "-d", str(small.build)]
    done = subprocess.run(
        [sys.executable, "-m", "tedm_cli.cli", *arguments],
        preexec_fn=lambda: limit_file_size(10_000),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 4, done.stderr
    assert len(done.stderr.splitlines()) == 1, done.stderr
    assert "distortion.h5: no room left to write it" in done.stderr
    assert snapshot(small.folder) == before


def test_a_temporary_of_a_process_that_no_one_has_asked_for_its_end(tmp_path: Path) -> None:
    """Its number is still taken, but it does not run: of a killed chain the first process of the machine is late."""
    ended = os.fork()
    if ended == 0:
        os._exit(0)
    os.waitid(os.P_PID, ended, os.WEXITED | os.WNOWAIT)
    os.kill(ended, 0)  # as if it ran
    left = tmp_path / f".table.csv.{ended}.tmp"
    left.write_text("half")
    with store.replacing(tmp_path / "table.csv") as temporary:
        temporary.write_text("whole")
    os.waitpid(ended, 0)
    assert [p.name for p in tmp_path.iterdir()] == ["table.csv"]


def test_a_foreign_temporary_of_a_living_process_stays(small: Project) -> None:
    """Another run may be writing the same target: only what dead processes left is removed."""
    alive = small.build / f".distortion.h5.{os.getppid()}.tmp"
    alive.write_text("")
    small.stage("build-distortion").ok()
    assert leftovers(small) == [alive]
