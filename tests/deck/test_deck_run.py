"""solve --run: the user's own solver, as a script that behaves well or badly."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest
from deck_tools import Outcome, bricks, plain, project, tedm
from msc_hdf5_file import write_msc_hdf5

from tedm_cli.nastran.op2.reader import open_op2
from tedm_cli.nastran.result_files import open_result_file
from tedm_cli.stages.model.deck import write_deck
from tedm_cli.stages.model.solve import solve_deck

TAKEN = 'shutil.copy("../whole.op2", deck.with_suffix(".op2"))'
FATAL = """
 *** USER FATAL MESSAGE 9050 (SEKRRS)
     RUN TERMINATED DUE TO EXCESSIVE PIVOT RATIOS

 end
"""
SCRIPTS = {
    "copies": f'print("solving", deck.name, "in", Path.cwd().name)\n{TAKEN}\nf06.write_text("NO FATAL WORD HERE")',
    "capitals": 'shutil.copy("../whole.op2", deck.stem.upper() + ".OP2")',
    "silent": "",
    "returns 3": 'print("licence denied"); sys.exit(3)',
    "blank": 'f06.write_text("*ERROR  1964: PSOLID ENTRY HAD FIELD FOR IN BLANK WITH ELEMENT TYPE HEXA8")',
    "fatal": f"f06.write_text({FATAL!r})\n{TAKEN}",
    "part": 'shutil.copy("../part.op2", deck.with_suffix(".op2"))',
    "broken": 'deck.with_suffix(".op2").write_bytes(b"\\4\\0\\0\\0" + bytes(200))',
    "both": f'{TAKEN}\nshutil.copy("../whole.h5", deck.stem.upper() + ".h5")',
    "part of HDF5": 'shutil.copy("../part.h5", deck.with_suffix(".h5"))',
    "half": f"""
        {TAKEN}
        deck.with_suffix(".op2").write_bytes(deck.with_suffix(".op2").read_bytes()[:2000])
        child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
        Path("pids").write_text(f"{{os.getpid()}} {{child.pid}}")
        child.wait()
        """,
    "hangs": """
        child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
        Path("pids").write_text(f"{os.getpid()} {child.pid}")
        child.wait()
        """,
}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project with its unit-load deck in `run`, its results in `whole.op2`, and two of the three in `part.op2`."""
    folder = tmp_path_factory.mktemp("made") / "project"
    deck = write_deck(project(folder, plain(bricks())), None).path
    solve_deck(deck, folder / "whole.op2")
    text = deck.read_text()
    (folder / "part.bdf").write_text(text[: text.index("SUBCASE 3")] + text[text.index("BEGIN BULK") :])
    solve_deck(folder / "part.bdf", folder / "part.op2")
    return folder


@pytest.fixture
def folder(made: Path, tmp_path: Path) -> Path:
    """A copy of it that a test may change."""
    return Path(shutil.copytree(made, tmp_path / "project"))


def solver(folder: Path, kind: str) -> str:
    """The command that runs this solver."""
    script = folder / "my solver.py"
    script.write_text(
        "import os, shutil, subprocess, sys\nfrom pathlib import Path\n"
        f"deck = Path(sys.argv[1])\nf06 = deck.with_suffix('.f06')\n{textwrap.dedent(SCRIPTS[kind])}\n"
    )
    return f"{shlex.quote(sys.executable)} {shlex.quote(str(script))} {{deck}} scr=yes"


def solve(folder: Path, command: str, *more: str) -> Outcome:
    return tedm("solve", "-c", folder / "tedm.toml", "--run", command, *more)


def refused(outcome: Outcome, code: int, *pieces: str) -> None:
    lines = outcome.err.splitlines()
    assert outcome.code == code, outcome.err
    assert [line.split(":")[0] for line in lines] == ["error", "hint"]
    for piece in pieces:
        assert piece in outcome.err


@pytest.mark.parametrize("kind", ["copies", "capitals"])
def test_results_come_to_their_place(folder: Path, kind: str) -> None:
    """And the solver's own copy is gone."""
    done = solve(folder, solver(folder, kind))
    assert (done.code, done.err) == (0, "")
    assert "3 subcases" in done.out
    assert (folder / "results" / "unit_loads.op2").read_bytes() == (folder / "whole.op2").read_bytes()
    assert not [p for p in (folder / "run").iterdir() if p.suffix.lower() == ".op2"]


@pytest.fixture
def hdf5(folder: Path) -> Path:
    """The project with its results in HDF5 as well, whole and in part, where it is asked for."""
    with open_result_file(folder / "whole.op2") as (tables, read):
        motions = [(t.subcase, t.label, read(t)) for t in tables]
    cases = [(number, label, got.motion) for number, label, got in motions]
    write_msc_hdf5(folder / "whole.h5", motions[0][2].grid_id, cases)
    write_msc_hdf5(folder / "part.h5", motions[0][2].grid_id, cases[:2])
    toml = (folder / "model.toml").read_text()
    (folder / "model.toml").write_text(toml.replace("results/unit_loads.op2", "run/unit_loads.msc.h5"))
    return folder


def test_hdf5_comes_to_its_place_where_its_name_asks_for_it(hdf5: Path) -> None:
    """Never under the deck's own name, which is that of the file that `ingest` writes."""
    assert solve(hdf5, solver(hdf5, "both")).code == 0
    good = (hdf5 / "whole.h5").read_bytes()
    assert (hdf5 / "run" / "unit_loads.msc.h5").read_bytes() == good
    assert not (hdf5 / "run" / "unit_loads.h5").exists()
    refused(solve(hdf5, solver(hdf5, "copies")), 4, "without a new HDF5", "unit_loads.msc.h5 is from before", "MDLPRM")
    refused(solve(hdf5, solver(hdf5, "part of HDF5")), 4, "unit_loads.msc.h5.failed", "lacks 1 of 3 subcases: 3")
    assert (hdf5 / "run" / "unit_loads.msc.h5").read_bytes() == good
    assert (hdf5 / "run" / "unit_loads.msc.h5.failed").read_bytes() == (hdf5 / "part.h5").read_bytes()


def test_hdf5_beside_the_op2_that_is_asked_for(hdf5: Path) -> None:
    toml = (hdf5 / "model.toml").read_text()
    (hdf5 / "model.toml").write_text(toml.replace("run/unit_loads.msc.h5", "results/unit_loads.op2"))
    assert solve(hdf5, solver(hdf5, "both")).code == 0
    assert (hdf5 / "results" / "unit_loads.op2").read_bytes() == (hdf5 / "whole.op2").read_bytes()
    assert {p.name for p in (hdf5 / "run").iterdir()} == {"unit_loads.bdf", "unit_loads.msc.h5"}


def test_the_embedded_solver_as_another_one(folder: Path) -> None:
    """A solver that really reads the deck it is given, run from the deck's folder."""
    command = "import sys; from pathlib import Path; from tedm_cli.stages.model.solve import solve_deck;"
    command += "deck = Path(sys.argv[1]); solve_deck(deck, deck.with_suffix('.op2'))"
    assert solve(folder, f"{shlex.quote(sys.executable)} -c {shlex.quote(command)} {{deck}}").code == 0
    assert (folder / "results" / "unit_loads.op2").read_bytes() == (folder / "whole.op2").read_bytes()


def test_what_the_solver_says_is_shown_on_request(folder: Path) -> None:
    done = solve(folder, solver(folder, "copies"), "-v")
    assert re.search(r"^solving unit_loads_tedmrun\d+\.bdf in run$", done.err, re.MULTILINE)
    assert "solving" not in done.out


@pytest.mark.parametrize(
    ("kind", "pieces"),
    [
        ("returns 3", ["run/unit_loads.bdf", "exit code 3: licence denied"]),
        ("fatal", ["a FATAL message: USER FATAL MESSAGE 9050 (SEKRRS); RUN TERMINATED DUE TO EXCESSIVE PIVOT RATIOS"]),
        ("silent", ["without a new OP2", "batch=no"]),
        ("part", ["unit_loads.op2.failed", "lacks 1 of 3 subcases: 3"]),
        ("broken", ["unit_loads.op2.failed"]),
    ],
)
def test_results_that_are_not_taken(folder: Path, kind: str, pieces: list[str]) -> None:
    """One error; the results of the last good run stay."""
    assert solve(folder, solver(folder, "copies")).code == 0
    results = folder / "results" / "unit_loads.op2"
    before = results.read_bytes()
    refused(solve(folder, solver(folder, kind)), 4, *pieces)
    assert results.read_bytes() == before
    beside = {p.name for p in (folder / "run").iterdir()} - {"unit_loads.bdf", "unit_loads.f06"}
    assert beside <= {"unit_loads.op2.failed"}


def test_solids_that_mystran_refuses_are_told_how_to_be_written(folder: Path) -> None:
    """By the words of MYSTRAN; what is left, and under which name, is said of every failure."""
    outcome = solve(folder, solver(folder, "blank"))
    refused(outcome, 4, "ERROR 1964: PSOLID ENTRY HAD FIELD FOR IN BLANK")
    assert "give every PSOLID of the model IN = TWO and ISOP = FULL, as PSOLID,1,1,,TWO,,FULL; its F06" in outcome.err
    assert "left beside the deck as unit_loads.*" in outcome.err
    outcome = solve(folder, solver(folder, "fatal"))
    assert "left beside the deck as unit_loads.*" in outcome.err
    assert "PSOLID" not in outcome.err


@pytest.mark.parametrize("kind", ["fatal", "part", "silent", "copies"])
def test_a_solver_that_writes_where_the_results_belong(folder: Path, kind: str) -> None:
    """As when deck and op2 share folder and name. A failed run must not stand in for the last good one."""
    toml = (folder / "model.toml").read_text()
    (folder / "model.toml").write_text(toml.replace("results/unit_loads.op2", "run/unit_loads.op2"))
    results = folder / "run" / "unit_loads.op2"
    good = (folder / "whole.op2").read_bytes()
    results.write_bytes(good)
    assert solve(folder, solver(folder, kind)).code == (0 if kind == "copies" else 4)
    assert results.read_bytes() == good
    assert not (folder / "run" / "unit_loads.op2.before").exists()
    assert (folder / "run" / "unit_loads.op2.failed").exists() == (kind in ("fatal", "part"))


def test_results_from_before_the_run(folder: Path) -> None:
    """An old OP2 and an old F06 with a FATAL message beside the deck are not those of this run."""
    solve(folder, solver(folder, "copies"))
    old = folder / "run" / "unit_loads.op2"
    (folder / "results" / "unit_loads.op2").rename(old)
    (folder / "run" / "unit_loads.f06").write_text(" *** USER FATAL MESSAGE 1 (OLD)\n")
    refused(solve(folder, solver(folder, "silent")), 4, "without a new OP2", f"{old} is from before the run")
    assert not (folder / "results" / "unit_loads.op2").exists()
    assert solve(folder, solver(folder, "capitals")).code == 0
    with open_op2(folder / "results" / "unit_loads.op2") as (tables, _):
        assert len(tables) == 3


@pytest.mark.parametrize(
    ("command", "piece"),
    [
        ("nastran scr=yes", "does not name the deck"),
        ("no_such_nastran {deck}", "no program 'no_such_nastran'"),
        ("nastran '{deck}", "No closing quotation"),
        ("", "does not name the deck"),
    ],
)
def test_commands_that_cannot_be_run(folder: Path, command: str, piece: str) -> None:
    outcome = solve(folder, command)
    assert outcome.code == 2
    assert piece in outcome.err


def test_no_shell_sees_the_command(folder: Path) -> None:
    solve(folder, solver(folder, "silent") + " ; touch broken")
    assert not (folder / "run" / "broken").exists()


def gone(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except FileNotFoundError:
        return True


def hanging(folder: Path, kind: str) -> tuple[subprocess.Popen[str], list[int]]:
    """tedm with a solver that does not end, and the processes of the solver."""
    arguments = ["solve", "-c", str(folder / "tedm.toml"), "--run", solver(folder, kind)]
    ours = subprocess.Popen(
        [sys.executable, "-m", "tedm_cli.cli", *arguments],
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # even where the tests' caller ignores it
    )
    pids = folder / "run" / "pids"
    deadline = time.monotonic() + 60
    while not (pids.exists() and len(pids.read_text().split()) == 2):
        assert time.monotonic() < deadline
        assert ours.poll() is None
        time.sleep(0.05)
    return ours, [int(word) for word in pids.read_text().split()]


def all_gone(pids: list[int]) -> bool:
    deadline = time.monotonic() + 30
    while not all(gone(pid) for pid in pids):
        if time.monotonic() > deadline:
            return False
        time.sleep(0.05)
    return True


proc = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks at processes through /proc")


@proc
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupt_ends_the_solver_and_what_it_started(folder: Path, number: int, code: int) -> None:
    ours, started = hanging(folder, "hangs")
    os.kill(ours.pid, number)
    _, err = ours.communicate(timeout=60)
    assert ours.returncode == code
    assert "Traceback" not in err
    assert all_gone(started)
    assert not (folder / "results").exists()
    assert {p.name for p in (folder / "run").iterdir()} == {"unit_loads.bdf", "pids"}


@proc
def test_a_killed_run_leaves_the_last_good_results(folder: Path) -> None:
    """As when deck and op2 share folder and name: half an OP2 never has the name, nor does the next failing run."""
    toml = (folder / "model.toml").read_text()
    (folder / "model.toml").write_text(toml.replace("results/unit_loads.op2", "run/unit_loads.op2"))
    results = folder / "run" / "unit_loads.op2"
    assert solve(folder, solver(folder, "copies")).code == 0
    good = results.read_bytes()

    ours, started = hanging(folder, "half")
    ours.kill()
    ours.communicate()
    assert all_gone(started)
    assert results.read_bytes() == good

    assert solve(folder, solver(folder, "part")).code == 4
    assert results.read_bytes() == good
    left = {p.name for p in (folder / "run").iterdir()}
    assert left == {"unit_loads.bdf", "unit_loads.f06", "unit_loads.op2", "unit_loads.op2.failed", "pids"}


@proc
def test_a_killed_first_run_leaves_no_results(folder: Path) -> None:
    """Make would take them for built."""
    toml = (folder / "model.toml").read_text()
    (folder / "model.toml").write_text(toml.replace("results/unit_loads.op2", "run/unit_loads.op2"))
    ours, started = hanging(folder, "half")
    ours.kill()
    ours.communicate()
    assert all_gone(started)
    assert not (folder / "run" / "unit_loads.op2").exists()
