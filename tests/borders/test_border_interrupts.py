"""Ctrl-C and requests to end: soon, whatever the command is doing, and nothing half left."""

from __future__ import annotations

import contextlib
import gc
import os
import random
import signal
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from border_tools import Project, heed_interrupts, in_child, snapshot

from tedm_cli.files.store import replacing
from tedm_cli.interrupts import Interrupts, whole

SAID = "error: interrupted; finished files are kept, the unfinished one is removed"


def interrupted(work: Callable[[], object]) -> int | None:
    """Do the work where interrupts are heeded; the signal that ended it."""
    interrupts = Interrupts()
    try:
        with interrupts:
            work()
    finally:
        interrupts.release()
    return interrupts.number


class SwallowedOnce:
    """A finaliser, out of which no exception comes."""

    def __del__(self) -> None:
        os.kill(os.getpid(), signal.SIGINT)
        for _ in range(1000):
            pass


def in_a_finaliser() -> None:
    SwallowedOnce()
    gc.collect()
    wait()


def in_a_bare_except() -> None:
    try:
        os.kill(os.getpid(), signal.SIGINT)
        wait()
    except BaseException:
        pass
    wait()


def wait() -> None:
    for _ in range(500):
        time.sleep(0.01)
    raise AssertionError("the interrupt is lost")


@pytest.mark.parametrize("work", [in_a_finaliser, in_a_bare_except])
def test_an_interrupt_that_is_swallowed_comes_again(work: Callable[[], None], tmp_path: Path) -> None:
    def act() -> None:
        assert interrupted(work) == signal.SIGINT

    assert in_child(act, tmp_path / "log") == 0, (tmp_path / "log").read_text()
    assert (tmp_path / "log").read_text() == ""


def test_what_must_stay_whole_is_done_before_an_interrupt(tmp_path: Path) -> None:
    steps: list[str] = []

    @whole
    def both() -> None:
        steps.append("first")
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(0.1)
        steps.append("second")

    def both_and_wait() -> None:
        both()
        wait()

    def act() -> None:
        assert interrupted(both_and_wait) == signal.SIGTERM
        assert steps == ["first", "second"]

    assert in_child(act, tmp_path / "log") == 0, (tmp_path / "log").read_text()


def test_an_interrupt_that_comes_through_exec(tmp_path: Path) -> None:
    """Modules make classes with it. The code is still the command's own."""
    text = """
        import os, sys
        from tedm_cli.interrupts import Interrupts
        interrupts = Interrupts()
        with interrupts:
            exec("import os, signal; os.kill(os.getpid(), signal.SIGINT)\\nwhile True: pass")
        interrupts.release()
        sys.exit(128 + interrupts.number)
    """
    (tmp_path / "script.py").write_text(textwrap.dedent(text))
    command = [sys.executable, "-m", "script"]
    assert subprocess.run(command, cwd=tmp_path, preexec_fn=heed_interrupts, check=False).returncode == 130


def test_an_ignored_interrupt_stays_ignored(tmp_path: Path) -> None:
    """As `nohup` and a shell's jobs in the background want it."""

    def act() -> None:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        assert interrupted(lambda: os.kill(os.getpid(), signal.SIGINT)) is None

    assert in_child(act, tmp_path / "log") == 0, (tmp_path / "log").read_text()


def test_a_library_that_does_not_come_back_is_left(tmp_path: Path) -> None:
    """Nothing half is left then either. A lock that waits without heed of signals stands for the library."""

    def act() -> None:
        with replacing(tmp_path / "result") as temporary:
            temporary.write_text("half")
            signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGALRM])
            interrupted(deaf)

    def deaf() -> None:
        # Here it is heeded, however long it took to come here.
        threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        while True:  # catches every interrupt, as often as it comes
            with contextlib.suppress(BaseException):
                time.sleep(60)

    begun = time.monotonic()
    assert os.waitstatus_to_exitcode(in_child(act, tmp_path / "log")) == 130
    assert time.monotonic() - begun < 20
    assert [p.name for p in tmp_path.iterdir()] == ["log"]


COMMANDS = {
    "ingest": ("u.h5",),
    "build-sensitivity": ("s.h5",),
    "build-optics": ("o.h5",),
    "run-case 3": ("c.h5",),
    "solve": ("s.op2",),
}


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_at_any_moment(small: Project, tmp_path: Path, command: str) -> None:
    """Seeded moments over the whole run: one line and the signal's code, and either the whole file or none."""
    moments = random.Random(command)
    out = tmp_path / "out"
    out.mkdir()
    (target,) = COMMANDS[command]
    project = ["-c", str(small.folder / "tedm.toml"), "-d", str(small.build), "-o", str(out / target)]
    arguments = [sys.executable, "-m", "tedm_cli.cli", *command.split(), *project]

    def start() -> subprocess.Popen[str]:
        return subprocess.Popen(
            arguments,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=heed_interrupts,
        )

    begun = time.monotonic()
    assert start().wait() == 0
    length = time.monotonic() - begun
    before, good = snapshot(small.folder), snapshot(out)
    ended = 0
    for _ in range(24):
        if ended == 3:
            break
        number = (signal.SIGINT, signal.SIGTERM)[ended % 2]
        (out / target).unlink(missing_ok=True)
        process = start()
        moment = moments.uniform(0.2, 1.1) * length  # not before there is a program to be interrupted
        begun = time.monotonic()
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(timeout=moment)
            length = time.monotonic() - begun  # it was over before: runs are shorter now, or the machine less busy
        process.send_signal(number)
        _, said = process.communicate(timeout=60)
        assert process.returncode in (0, 128 + number, -number), said  # the latter: on its way out
        print(f"{moment:.2f} of {length:.2f} s: code {process.returncode}", said)
        if process.returncode == 128 + number:
            *python, line = said.splitlines()
            assert line == SAID
            assert not python or "importlib._bootstrap" in said, said  # its locks print what they meet
            ended += 1
        else:
            assert said == ""
        assert snapshot(out) in ({}, good)
        assert snapshot(small.folder) == before
    assert ended >= 2, "no moments were within the run"
