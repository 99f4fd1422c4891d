"""Run the command in this process, and say what a refusal must look like."""

from __future__ import annotations

import ast
import contextlib
import faulthandler
import hashlib
import io
import os
import shutil
import signal
import sys
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from unittest import mock

import h5py
import numpy as np

sys.path.append(str(Path(__file__).parents[1]))

from shipped_cases import cases_of_areas

from tedm_cli.cli import main
from tedm_cli.files.seal import seal
from tedm_cli.nastran.op2.writer import write_op2

ROOT = Path(__file__).parents[2]
SMALL = ROOT / "sample_models" / "small"
CONFIGS = ROOT / "configs"
STAGES = {
    "ingest": "unit_loads.h5",
    "build-distortion": "distortion.h5",
    "build-sensitivity": "sensitivity.h5",
    "build-optics": "optics.h5",
    "build-adjoint": "adjoint.h5",
    "run-case": "case03.h5",
}


@dataclass(frozen=True)
class Outcome:
    """What one run of the command left behind."""

    code: int
    out: str
    err: str

    def ok(self) -> Outcome:
        assert self.code == 0, self.err
        return self

    def refused(self, code: int, *pieces: str, hint: str = "") -> None:
        """One block of `error:` lines, then at most one `hint:`, and nothing else; all `pieces` among the errors."""
        assert self.code == code, f"exit code {self.code}\n{self.err}"
        lines = self.err.splitlines()
        errors = [line for line in lines if line.startswith("error: ")]
        hints = [line for line in lines if line.startswith("hint: ")]
        assert errors
        assert lines == errors + hints, self.err
        assert len(hints) <= 1
        assert code == 3 or len(errors) == 1, "only a configuration has several problems"
        assert "Traceback" not in self.err + self.out
        assert "internal" not in self.err
        for piece in pieces:
            assert any(piece in line for line in errors), f"{piece!r} is not in:\n{self.err}"
        assert hint in "".join(hints), f"{hint!r} is not in:\n{self.err}"


def tedm(*args: object) -> Outcome:
    """Run `tedm` with these arguments in this process."""
    out, err = io.StringIO(), io.StringIO()
    argv = ["tedm", *(str(a) for a in args)]
    with mock.patch.object(sys, "argv", argv), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main()
            code: object = 0
        except SystemExit as exc:
            code = exc.code or 0
    assert isinstance(code, int)
    return Outcome(code, out.getvalue(), err.getvalue())


@dataclass(frozen=True)
class Project:
    """A project in a folder of its own: `folder/*.toml`, `folder/unit_loads.{bdf,op2}` and `folder/build`."""

    folder: Path

    @property
    def build(self) -> Path:
        return self.folder / "build"

    @property
    def model(self) -> Path:
        return self.folder / "model.toml"

    @property
    def deck(self) -> Path:
        return self.folder / "unit_loads.bdf"

    @property
    def op2(self) -> Path:
        return self.folder / "unit_loads.op2"

    def run(self, command: str, *args: object) -> Outcome:
        return tedm(command, *args, "-c", self.folder / "tedm.toml", "-d", self.build)

    def stage(self, command: str) -> Outcome:
        """Run one stage; run-case with case 3."""
        return self.run(command, *(["3"] if command == "run-case" else []))

    def copy(self, folder: Path) -> Project:
        shutil.copytree(self.folder, folder)
        return Project(folder)


def build_chain(folder: Path) -> None:
    """The small sample and its whole chain, case 3 included; made once for all who read it, as `small`."""
    for name in ("unit_loads.bdf", "unit_loads.op2", "model.toml", "ltp_small_areas.csv"):
        shutil.copy(SMALL / name, folder)
    shutil.copy(CONFIGS / "optics.toml", folder)
    (folder / "cases.toml").write_text(cases_of_areas())
    (folder / "tedm.toml").write_text('title = "small sample"\n')
    project = Project(folder)
    for command in STAGES:
        project.stage(command).ok()


@cache
def tree(path: Path) -> ast.Module:
    """A source file as Python reads it."""
    return ast.parse(path.read_text(encoding="utf-8"))


def replace(path: Path, old: str, new: str, count: int = 1) -> None:
    """Change a text file; the text to change must be there."""
    text = path.read_text()
    assert old in text, f"{old!r} is not in {path}"
    path.write_text(text.replace(old, new, count))


@contextlib.contextmanager
def edited(path: Path) -> Iterator[h5py.File]:
    """A file between the stages, to be changed as another program may that knows how to seal it."""
    with h5py.File(path, "r+") as file:
        yield file
    seal(path)


@contextlib.contextmanager
def untouched(folder: Path) -> Iterator[None]:
    """All files of a folder are the same before and after, and no file has been added or left behind."""
    before = snapshot(folder)
    yield
    assert snapshot(folder) == before


def snapshot(folder: Path) -> dict[str, str]:
    """SHA-256 of every file in a folder."""
    return {
        p.relative_to(folder).as_posix(): hashlib.sha256(p.read_bytes()).hexdigest()
        for p in sorted(folder.rglob("*"))
        if p.is_file()
    }


def heed_interrupts() -> None:
    """For a new process: an interrupt counts even where the tests' caller ignores it (`nohup`, background jobs)."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def in_child(action: Callable[[], object], log: Path) -> int:
    """Run `action` in a forked process with its output in `log`; its wait status, as `os.waitpid` gives it."""
    child = os.fork()
    if child == 0:
        code = 99
        try:
            faulthandler.dump_traceback_later(300, exit=True)  # what hangs is to fail
            heed_interrupts()
            handle = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
            os.dup2(handle, 1)
            os.dup2(handle, 2)
            sys.stdout, sys.stderr = open(1, "w", closefd=False), open(2, "w", closefd=False)  # noqa: SIM115
            try:
                action()
                code = 0
            except SystemExit as exc:
                code = exc.code if isinstance(exc.code, int) else 1
            except Exception:
                traceback.print_exc()
            sys.stdout.flush()
            sys.stderr.flush()
        finally:
            os._exit(code)
    return os.waitpid(child, 0)[1]


# --- a model of two bricks, for the many ways in which ingest can fail -----------------------------------------------

GRIDS = 12
LEFT, RIGHT = range(1, 9), range(9, 13)
MODEL_TOML = """\
[model]
bdf = "model.bdf"
areas_csv = "areas.csv"
deck = "unit_loads.bdf"
op2 = ["unit_loads.op2"]

[areas]
rule = [
    { match = "LEFT", group = "bricks", shield = "inside" },
    { match = "RIGHT", group = "bricks", shield = "outside" },
]

[[test_mass]]
name = "TM1"
position_m = [0.1, 0.2, 0.0]
side_m = 0.046
mass_kg = 1.96
"""


def tiny_project(folder: Path) -> Project:
    """Two aluminium bricks, 0.2 m long, with results made up but consistent: the areas sum to the uniform load."""
    folder.mkdir(parents=True)
    lines = ["SOL 101", "CEND", "SPC = 1", "BEGIN BULK"]
    for i, x in enumerate((0.0, 0.1, 0.2)):
        for j, (y, z) in enumerate(((0.0, 0.0), (0.1, 0.0), (0.1, 0.1), (0.0, 0.1))):
            lines.append(f"GRID,{4 * i + j + 1},,{x},{y},{z}")
    lines += [
        "CHEXA,1,1,1,2,3,4,5,6",
        ",7,8",
        "CHEXA,2,1,5,6,7,8,9,10",
        ",11,12",
        "PSOLID,1,1",
        "MAT1,1,7.+10,,.33,2700.,2.3-5",
        "SPC1,1,123,1,2,3,4",
        "ENDDATA",
    ]
    (folder / "model.bdf").write_text("\n".join(lines) + "\n")
    rows = [f"{i},LEFT" for i in LEFT] + [f"{i},RIGHT" for i in RIGHT]
    (folder / "areas.csv").write_text("\n".join(["node_id,area", *rows]) + "\n")
    (folder / "model.toml").write_text(MODEL_TOML)
    (folder / "cases.toml").write_text(cases_of_areas())
    (folder / "tedm.toml").write_text('title = "two bricks"\n')
    project = Project(folder)
    project.run("write-deck").ok()
    write_op2(project.op2, tiny_ids(), [(n, label, motion) for n, label, motion in tiny_motions()])
    project.run("ingest").ok()
    return project


def tiny_ids() -> np.ndarray:
    return np.arange(1, GRIDS + 1)


def tiny_motions() -> list[tuple[int, str, np.ndarray]]:
    """Subcase, label and motion [12, 6] of the three unit loads."""
    random = np.random.default_rng(1)
    left, right = random.normal(scale=1e-7, size=(2, GRIDS, 6))
    return [(1, "LEFT", left), (2, "RIGHT", right), (3, "UNIFORM", left + right)]
