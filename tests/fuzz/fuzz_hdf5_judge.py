"""Damaged and edited files between the stages of the small sample, each read by the next stage within a time limit.

A verdict is `same` (the stage makes the numbers of the sound file), `refused` (one clear error, by its exit code), or a
failure: `SILENT` (other numbers), `INTERNAL`, `UNCLEAR`, `SIGNAL`, `HANG`.
"""

from __future__ import annotations

import contextlib
import io
import math
import os
import re
import shutil
import signal
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from random import Random

import h5py
import numpy as np
from fuzz_hdf5 import MUTATIONS, datasets

from tedm_cli.cli import main

ROOT = Path(__file__).parents[2]
SECONDS = 60.0
FAILURES = ("SILENT", "INTERNAL", "UNCLEAR", "SIGNAL", "HANG")
CHAIN = {
    "ingest": "unit_loads.h5",
    "build-distortion": "distortion.h5",
    "build-sensitivity": "sensitivity.h5",
    "build-optics": "optics.h5",
    "run-case": "case03.h5",
}
NEXT = {
    "unit_loads.h5": ("build-distortion", "build-sensitivity"),
    "distortion.h5": ("build-optics", "build-sensitivity"),
    "sensitivity.h5": ("run-case",),
    "optics.h5": ("run-case",),
    "case03.h5": ("export-case",),
}


@dataclass(frozen=True)
class Verdict:
    number: int
    file: str
    mutation: str
    outcome: str
    detail: str

    @property
    def failed(self) -> bool:
        return self.outcome in FAILURES

    def __str__(self) -> str:
        return f"hdf5 {self.number} ({self.mutation} of {self.file}): {self.outcome} {self.detail}"


class Hdf5Judge:
    """The chain of the small sample in a folder, and what the stages make of its sound files."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.build = folder, folder / "build"
        folder.mkdir(parents=True)
        for name in ("unit_loads.bdf", "unit_loads.op2", "model.toml", "ltp_small_areas.csv"):
            shutil.copy(ROOT / "sample_models" / "small" / name, folder)
        for name in ("optics.toml", "cases.toml"):
            shutil.copy(ROOT / "configs" / name, folder)
        (folder / "tedm.toml").write_text('title = "small sample"\n')
        for command in CHAIN:
            code, text = self.run(command, self.build / CHAIN[command])
            assert code == 0, text
        self.sound = {name: (self.build / name).read_bytes() for name in NEXT}
        self.expected = {}
        for command in sorted({c for readers in NEXT.values() for c in readers}):
            code, text = self.run(command, self.made(command))
            assert code == 0, text
            self.expected[command] = self.numbers(command)

    def made(self, command: str) -> Path:
        return self.folder / "made" / ("csv" if command == "export-case" else CHAIN[command])

    def run(self, command: str, output: Path) -> tuple[int, str]:
        """Exit code and all output of a command, in this process."""
        where = ["-d", str(self.build), *([] if command == "export-case" else ["-c", str(self.folder / "tedm.toml")])]
        case = {"run-case": ["3"], "export-case": ["3", "--format", "csv"]}.get(command, [])
        sys.argv = ["tedm", command, *case, *where, "-o", str(output)]
        text = io.StringIO()
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(text):
            try:
                main()
                code = 0
            except SystemExit as exc:
                code = exc.code if isinstance(exc.code, int) else int(exc.code is not None)
        return code, text.getvalue()

    def numbers(self, command: str) -> dict[str, np.ndarray]:
        """All numbers that a command has written."""
        path = self.made(command)
        if path.is_dir():
            return {p.name: np.array(_floats(p.read_text())) for p in sorted(path.rglob("*.csv"))}
        with h5py.File(path) as file:
            return {p: file[p][()] for p in datasets(file, "if")}

    def judge(self, number: int) -> Verdict:
        """Mutations take turns with the number, which seeds the rest."""
        random = Random(f"hdf5 {number}")
        mutation = list(MUTATIONS)[number % len(MUTATIONS)]
        name = random.choice(list(NEXT))
        command = random.choice(NEXT[name])
        try:
            MUTATIONS[mutation](random, self.build / name)
            outcome, detail = self.outcome(command, name)
        finally:
            for kept, data in self.sound.items():
                (self.build / kept).write_bytes(data)
        return Verdict(number, name, mutation, outcome, f"{command}: {detail}")

    def outcome(self, command: str, name: str) -> tuple[str, str]:
        path = self.made(command)
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
        code, text = self.in_child(command)
        if code is None:
            return "HANG", f"more than {SECONDS} s"
        if code < 0:
            return "SIGNAL", str(-code)
        if code == 0:
            found, wanted = self.numbers(command), self.expected[command]
            other = sorted(
                {p for p in wanted if p not in found or not np.array_equal(found[p], wanted[p], equal_nan=True)}
                | set(found) - set(wanted)
            )
            return ("SILENT", f"{len(other)} datasets differ: {', '.join(other[:3])}") if other else ("same", "")
        lines = text.splitlines()
        if code not in (4, 5) or "internal" in text or "Traceback" in text:
            return "INTERNAL", text[-1500:]
        if len(lines) > 2 or not lines[0].startswith("error: ") or (code == 4 and name not in lines[0]):
            return "UNCLEAR", text[-1500:]
        return f"refused {code}", lines[0]

    def in_child(self, command: str) -> tuple[int | None, str]:
        """Exit code (negative: a signal, None: out of time) and the text of a run in a process of its own."""
        log = self.folder / "log"
        child = os.fork()
        if child == 0:
            code = 99
            try:
                code, text = self.run(command, self.made(command))
                log.write_text(text)
            finally:
                os._exit(code)
        begin = time.monotonic()
        while True:
            done, status = os.waitpid(child, os.WNOHANG)
            if done:
                code = os.waitstatus_to_exitcode(status)
                return code, log.read_text() if code >= 0 else ""
            if time.monotonic() - begin > SECONDS:
                os.kill(child, signal.SIGKILL)
                os.waitpid(child, 0)
                return None, ""
            time.sleep(0.01)


def _floats(text: str) -> list[float]:
    found = []
    for word in re.split(r"[,\s]+", text):
        with contextlib.suppress(ValueError):
            found.append(float(word))
    return [0.0 if math.isnan(v) else v for v in found]
