"""tedm run: what is stale and why, in which order steps run, what happens when one is refused, whose project it is."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[1] / "borders"))

from border_tools import ROOT, heed_interrupts, replace, snapshot, tedm

from tedm_cli.chain.graph import Step, leading_to
from tedm_cli.chain.stale import Queue, missing_inputs, stale_steps
from tedm_cli.cli.worker import PROGRAM
from tedm_cli.stages.chain.workers import Job, Workers


def step(name: str, inputs: str, outputs: str = "") -> Step:
    return Step((name,), tuple(map(Path, (outputs or name).split())), tuple(map(Path, inputs.split())))


#: Two branches of which the last is made, and one beside them.
CHAIN = (step("a", "x"), step("b", "a y"), step("c", "a z", "c1 c2"), step("d", "b c2"), step("e", "z"))
TIMES = dict(zip(["x", "y", "z", "a", "b", "c1", "c2", "d", "e"], (1, 2, 3, 4, 5, 5, 6, 7, 8), strict=True))


def stale(wrong: str = "", **changed: int | None) -> dict[str, tuple[str, ...]]:
    times = TIMES | changed
    found = stale_steps(CHAIN, lambda path: times[path.name], lambda path: ["wrong"] if path.name == wrong else [])
    return {step.words: reasons for step, reasons in found.items()}


def test_nothing_is_stale_that_is_no_older_than_its_inputs() -> None:
    assert stale() == {}
    assert stale(b=4) == {}, "of the same time is not older"


def test_what_is_stale_and_why() -> None:
    assert stale(y=6) == {"b": ("y is newer",), "d": ("b is rebuilt",)}
    assert stale(c2=None) == {"c": ("c2 is not there",), "d": ("c2 is rebuilt",)}
    assert stale(c1=2) == {"c": ("a is newer", "z is newer"), "d": ("c2 is rebuilt",)}, "the oldest output counts"
    assert stale(d=None) == {"d": ("d is not there",)}
    assert stale("e") == {"e": ("wrong",)}
    assert stale("a") == {"a": ("wrong",), "b": ("a is rebuilt",), "c": ("a is rebuilt",), "d": stale("a")["d"]}


def test_contents_are_looked_at_only_where_times_say_nothing() -> None:
    asked: list[str] = []

    def wrong(path: Path) -> list[str]:
        asked.append(path.name)
        return []

    stale_steps(CHAIN, lambda path: (TIMES | {"a": None})[path.name], wrong)
    assert asked == ["e"]


def test_what_leads_to_a_step() -> None:
    def leading(*wanted: str) -> list[str]:
        return [s.words for s in leading_to(CHAIN, lambda step: step.words in wanted)]

    assert leading("d") == ["a", "b", "c", "d"]
    assert leading("c") == ["a", "c"]
    assert leading("e") == ["e"]
    assert leading("c", "e") == ["a", "c", "e"]
    assert leading() == []


def test_inputs_that_nothing_makes() -> None:
    assert missing_inputs(CHAIN, lambda path: None) == [Path("x"), Path("y"), Path("z")]
    assert missing_inputs(CHAIN, lambda path: (TIMES | {"a": None})[path.name]) == []


def test_steps_wait_for_those_they_are_made_of() -> None:
    queue = Queue(CHAIN)
    first = [queue.next(), queue.next()]
    assert first == [CHAIN[0], CHAIN[4]]
    assert queue.next() is None
    queue.done(CHAIN[0])
    assert [queue.next(), queue.next(), queue.next()] == [CHAIN[1], CHAIN[2], None]
    queue.done(CHAIN[2])
    assert queue.next() is None, "d waits for b too"
    queue.done(CHAIN[1])
    assert queue.next() == CHAIN[3]


@pytest.fixture
def demo(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A new project, in whose folder commands are typed."""
    tedm("init", tmp_path / "demo").ok()
    monkeypatch.chdir(tmp_path / "demo")
    return tmp_path / "demo"


def test_a_project_is_found_from_its_subfolders(demo: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tedm("run", "ingest").ok()
    made = snapshot(demo)
    below = demo / "notes" / "of mine"
    below.mkdir(parents=True)
    monkeypatch.chdir(below)
    assert "(../../tedm.toml)\n../../build: all is up to date" in tedm("run", "ingest").ok().out
    assert "../../build/unit_loads.h5 (unit_loads): up to date" in tedm("check").ok().out
    (demo / "build" / "unit_loads.h5").unlink()
    tedm("ingest").ok()
    assert snapshot(demo) == made, "the same file, wherever the command is typed"
    (demo / "build" / "unit_loads.h5").unlink()
    tedm("run", "ingest").ok()
    assert snapshot(demo) == made
    (below / "tedm.toml").write_text('title = "nearer"\n')
    tedm("run", "-n").refused(4, "model.toml")
    assert "(../../tedm.toml)" in tedm("run", "-n", "-c", "../../tedm.toml", "-d", "../../build").ok().out


def test_without_a_project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for command in (["run"], ["ingest"], ["run-case", "3"]):
        tedm(*command).refused(4, f"{tmp_path}: there is no project", hint="begin one: tedm init demo")
    tedm("check").refused(4, "build: holds no HDF5 files", hint="`tedm run` makes them")
    assert not list(tmp_path.iterdir())


def test_the_repository_is_a_project_from_its_root_on() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "tedm_cli.cli", "check-layout"], cwd=ROOT / "docs", capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr


def test_what_cannot_be_planned(demo: Path) -> None:
    tedm("run", "build-optik").refused(2, "no stage is called 'build-optik'", hint="did you mean build-optics?")
    tedm("run", "-n", "-j", "0").refused(2, "'--jobs': 0 is less than 1")
    (demo / "unit_loads.op2").rename(demo / "kept.op2")
    tedm("run").refused(4, "unit_loads.op2: no such file", hint="the configuration names it")
    assert not (demo / "build").exists()


def test_a_stage_that_is_refused_stops_the_chain(demo: Path) -> None:
    """With its own message and code; what was made is kept, and the chain goes on from there."""
    good = (demo / "optics.toml").read_bytes()
    replace(demo / "optics.toml", "grid = 900001", "grid = 987654")
    outcome = tedm("run", "build-optics", "-j", "2")
    outcome.refused(3, "987654")
    assert re.findall(r"(?m)^\[\d/\d\] (\S+):", outcome.out) == ["ingest", "build-distortion"]
    assert not (demo / "build" / "distortion.h5").exists()
    (demo / "optics.toml").write_bytes(good)
    outcome = tedm("run", "build-optics")
    assert re.findall(r"(?m)^\[\d/2\] (.+)", outcome.ok().out) == [
        "build-distortion: distortion.h5 is not there",
        "build-optics: optics.h5 is not there",
    ]
    tedm("check").ok()


def test_a_copy_whose_files_have_other_times_says_so(demo: Path) -> None:
    """The halves of the chain have not changed, and are not said to; nor are files named that no user knows."""
    tedm("run", "build-optics").ok()
    for name in ("halves", "symmetry_plane", "ties"):
        os.utime(demo / "build" / name, (4e9, 4e9))
    out = tedm("run", "-n").ok().out
    assert "ingest " in out
    assert "the times of the build folder have changed (cp -p keeps them in a copy)" in out
    assert "the figures are not there" in out
    assert not any(word in out for word in ("halves", "symmetry", "tied to", "figures.stamp"))
    (demo / "build" / "halves").write_text("others\n")
    assert "the halves of the chain have changed" in tedm("run", "-n").ok().out


def test_your_own_solver_is_told_to_solve_alone(demo: Path) -> None:
    for name in ("unit_loads.bdf", "unit_loads.op2"):
        replace(demo / "model.toml", f'"{name}"', f'"{{build_dir}}/{name}"')
    outcome = tedm("run", "ingest", "-j", "2", "--nastran", "no_such_solver {deck}")
    outcome.refused(2, "there is no program 'no_such_solver'")
    assert re.findall(r"(?m)^\[\d/3\] (\S+):", outcome.out) == ["write-deck", "solve"]


def test_results_of_a_solver_may_be_hdf5_of_its_own(demo: Path) -> None:
    """Which says nothing of what it was made of: times alone tell."""
    replace(demo / "model.toml", '"unit_loads.bdf"', '"{build_dir}/unit_loads.bdf"')
    replace(demo / "model.toml", '"unit_loads.op2"', '"{build_dir}/unit_loads.msc.h5"')
    (demo / "build").mkdir()
    for name in ("unit_loads.bdf", "unit_loads.msc.h5"):
        (demo / "build" / name).touch()
    assert "all is up to date (2 steps)" in tedm("run", "-n", "solve").ok().out
    os.utime(demo / "build" / "unit_loads.msc.h5", (0, 0))
    assert "solve  unit_loads.bdf is newer\n" in tedm("run", "-n", "solve").ok().out


def test_a_process_that_dies_is_told_of() -> None:
    program = (sys.executable, "-c", "import os; input(); os.kill(os.getpid(), 9)")
    with Workers(program, 1) as workers:
        workers.begin(Job(("check",), 3), [])
        job, answer = workers.wait()
    assert job == Job(("check",), 3)
    assert answer.code == 1
    assert re.search(r"^error: .*`tedm check` ended by signal 9 \(SIGKILL\); the system", answer.err)
    assert "the next run goes on from there" in answer.err


def test_an_interrupt_is_passed_on(tmp_path: Path) -> None:
    """To a command that would not end by itself, and that has time to clean up."""
    script = (
        "import signal, sys, time; signal.signal(signal.SIGTERM, lambda *_: (open('ended', 'w'), sys.exit()));"
        "input(); open('begun', 'w'); time.sleep(600)"
    )
    with contextlib.chdir(tmp_path), pytest.raises(KeyboardInterrupt), Workers((sys.executable, "-c", script), 1) as of:
        of.begin(Job(("check",)), [])
        while not (tmp_path / "begun").exists():
            time.sleep(0.01)
        raise KeyboardInterrupt
    assert (tmp_path / "ended").exists()


def test_a_worker_ends_with_whoever_started_it(tmp_path: Path) -> None:
    """Killed without a chance to say so: its pipe closes."""
    process = subprocess.Popen(PROGRAM, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=tmp_path)
    assert process.communicate(timeout=60)[0] == b""
    assert process.returncode == 0


def test_files_of_a_project_are_not_imported(demo: Path) -> None:
    """It may hold a signal.py, or a numpy.py."""
    for name in ("signal.py", "json.py", "numpy.py"):
        (demo / name).write_text("raise SystemExit('imported')\n")
    tedm("run", "ingest").ok()


def test_an_interrupt_reaches_all_processes(demo: Path) -> None:
    """By a signal to `tedm run` alone, as `kill` sends it: soon, in one line, and with no process left."""
    program = [sys.executable, "-m", "tedm_cli.cli", "run", "-j", "2"]
    with subprocess.Popen(
        program, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=heed_interrupts
    ) as process:
        assert process.stdout is not None
        while "ingest" not in process.stdout.readline():
            pass
        time.sleep(0.3)
        begun = time.monotonic()
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)  # ends when no process holds its streams
    assert process.returncode == 130
    assert said == "error: interrupted; finished files are kept, the unfinished one is removed\n"
    assert time.monotonic() - begun < 20
    assert {name for name in os.listdir(demo / "build") if name[0] == "."} == set()
