"""Damaged and edited files between the stages of the small sample, each read by a command that uses it.

A verdict is `same` (the command makes the numbers of the sound file), `refused` (one clear error, by its exit code), or
a failure: `SILENT` (other numbers), `INTERNAL`, `UNCLEAR`, `LITTER`, `SIGNAL`, `HANG`. Every run is a process of its
own: HDF5 is not trusted with damaged files.
"""

from __future__ import annotations

import contextlib
import io
import json
import math
import os
import re
import shutil
import signal
import sys
import time
from pathlib import Path
from random import Random

import h5py
import numpy as np
from fuzz_hdf5 import MUTATIONS, datasets
from fuzz_judge import Verdict, processor_seconds
from fuzz_users_project import small_chain

from tedm_cli.cli import main
from tedm_cli.contracts import KINDS, TRADE
from tedm_cli.files.provenance import Provenance, input_files
from tedm_cli.files.store import create
from tedm_cli.results.trade import Cell, TradedCriterion, TradedVariant, compared, write_trade

SECONDS = 60.0  # of the processor, for one command
STILL = 600.0  # of the clock, for one that waits
SERIES = '\n[[series]]\nname = "warm"\nfile = "series.csv"\nremove = "linear"\nlowest_hz = 0.02\n'
DYNAMICS = "[time]\nsamples = 4096\n"
#: Beyond the matrices, in their order: what makes each file.
MADE = {
    "adjoint.h5": ["build-adjoint"],
    "case03.h5": ["run-case", "3"],
    "series_warm.h5": ["run-series", "warm"],
    "dynamics.h5": ["build-dynamics"],
    "simulation03.h5": ["simulate", "3"],
    "simulation_warm.h5": ["simulate", "--series", "warm"],
    "release.h5": ["simulate", "--release", "TM1_x=1e-6"],
    "figure_6_2.h5": ["simulate", "--figure-6.2"],
    "thermal.h5": ["build-thermal"],
    "balance.h5": ["balance"],
    "loads.h5": ["build-loads"],
    "temperatures.h5": ["map-temperatures", "tau.csv", "-o", "build/temperatures.h5"],
    "partial_unit_loads.h5": ["build-sensitivity", "--partial", "unit_loads.op2"],
}
#: By file: the commands that read it.
READERS: dict[str, tuple[str, ...]] = {
    "unit_loads.h5": ("build-distortion", "build-sensitivity", "build-adjoint", "show unit_loads.h5"),
    "distortion.h5": ("build-optics", "build-sensitivity", "show distortion.h5"),
    "sensitivity.h5": ("run-case 3", "run-series warm", "build-adjoint", "build-dynamics", "simulate --figure-6.2"),
    "optics.h5": ("run-case 3", "run-series warm", "build-adjoint", "build-dynamics"),
    "adjoint.h5": ("build-thermal", "show adjoint.h5"),
    "case03.h5": ("export-case 3 --format csv", "show case03.h5", "view"),
    "series_warm.h5": ("show series_warm.h5", "view"),
    "dynamics.h5": (
        "simulate 3",
        "simulate --series warm",
        "export-state-space --loop --format csv",
        "show dynamics.h5",
    ),
    "simulation03.h5": ("show simulation03.h5", "view"),
    "simulation_warm.h5": ("show simulation_warm.h5", "view"),
    "release.h5": ("show release.h5",),
    "figure_6_2.h5": ("show figure_6_2.h5", "view"),
    "thermal.h5": ("show thermal.h5",),
    "balance.h5": ("show balance.h5",),
    "loads.h5": ("show loads.h5",),
    "temperatures.h5": ("show temperatures.h5",),
    "trade.h5": ("show trade.h5",),
    "partial_unit_loads.h5": ("merge", "show partial_unit_loads.h5"),
}
NO_CONFIG = ("show", "export-case")
#: What HDF5 writes into [D] it writes into the file that this is a view of, which then no longer fits its seal.
BLAMED = {"distortion.h5": ("distortion.h5", "unit_loads.h5")}


class Hdf5Judge:
    """The chain of the small sample in a folder, and what commands make of its sound files."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.build, self.made = folder, folder / "build", folder / "made"
        rows = "".join(f"{2.0 * n},{293.0 + 0.01 * math.sin(0.3 * n):.6f}\n" for n in range(900))
        project = small_chain(folder, SERIES, DYNAMICS)
        (folder / "series.csv").write_text("time_s,all\n" + rows)
        for args in MADE.values():
            project.sound(args)
        write_made_up_trade(self.build / "trade.h5")
        self.sound = {name: (self.build / name).read_bytes() for name in READERS}
        assert {_kind(self.build / name) for name in READERS} == set(KINDS), "every kind of file is tried"
        self.listing = self.snapshot()
        self.expected: dict[str, dict[str, np.ndarray]] = {}
        for command in sorted({c for commands in READERS.values() for c in commands}):
            shutil.rmtree(self.made, ignore_errors=True)
            self.made.mkdir()
            code, text = self.run(command)
            assert code == 0, text
            self.expected[command] = self.numbers()

    def snapshot(self) -> dict[str, tuple[int, int]]:
        found = [p for p in self.folder.rglob("*") if p.is_file() and self.made not in p.parents]
        names = {"log", *(f"{Path(n).stem}.other" for n in READERS)}
        return {
            str(p): (p.stat().st_size, p.stat().st_mtime_ns)
            for p in found
            if p.name not in names and p.name not in self.sound
        }

    def run(self, command: str) -> tuple[int, str]:
        """Exit code and error output of a command in this process; what it makes and prints is in `made`."""
        name, *words = command.split()
        if name == "show":
            args = [name, str(self.build / words[0]), "--json"]
        else:
            project = [] if name in NO_CONFIG else ["-c", str(self.folder / "tedm.toml")]
            args = [name, *words, *project, "-d", str(self.build), "-o", str(self.made / _output(name))]
        sys.argv = ["tedm", *args]
        out, text = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(text):
            try:
                main()
                code = 0
            except SystemExit as exc:
                code = exc.code if isinstance(exc.code, int) else int(exc.code is not None)
        if name == "show" and code == 0:
            (self.made / "shown.csv").write_text(_spread(json.loads(out.getvalue())["main"]))
        return code, text.getvalue()

    def numbers(self) -> dict[str, np.ndarray]:
        """All numbers that a command has written."""
        out: dict[str, np.ndarray] = {}
        for path in sorted(p for p in self.made.rglob("*") if p.is_file()):
            if path.suffix == ".h5":
                with h5py.File(path) as file:
                    out |= {f"{path.name}{p}": file[p][()] for p in datasets(file, "if")}
            elif path.suffix == ".html":
                out[path.name] = np.array([len(path.read_bytes()) > 0])
            else:
                out[path.name] = np.array(_floats(path.read_text(encoding="utf-8")))
        return out

    def judge(self, name: str, number: int) -> Verdict:
        """Mutations of a file take turns with the number, which seeds the rest."""
        random = Random(f"{name} {number}")
        mutation = list(MUTATIONS)[number % len(MUTATIONS)]
        command = random.choice(READERS[name])
        path = self.build / name
        try:
            MUTATIONS[mutation](random, path)
            outcome, detail = self.outcome(command, name)
        finally:
            path.write_bytes(self.sound[name])
            for blamed in BLAMED.get(name, ()):
                (self.build / blamed).write_bytes(self.sound[blamed])
        if self.snapshot() != self.listing:
            outcome, detail = "LITTER", str(sorted(set(self.snapshot()) ^ set(self.listing)))
        return Verdict(name, number, mutation, outcome, f"{command}: {detail}")

    def outcome(self, command: str, name: str) -> tuple[str, str]:
        shutil.rmtree(self.made, ignore_errors=True)
        self.made.mkdir()
        code, text = self.in_child(command)
        if code is None:
            return "HANG", f"more than {SECONDS} s"
        if code < 0:
            return "SIGNAL", str(-code)
        if code == 0:
            found, wanted = self.numbers(), self.expected[command]
            other = sorted(
                {p for p in wanted if p not in found or not np.array_equal(found[p], wanted[p], equal_nan=True)}
                | set(found) - set(wanted)
            )
            return ("SILENT", f"{len(other)} datasets differ: {', '.join(other[:3])}") if other else ("same", "")
        lines = text.splitlines()
        if code not in (4, 5) or "internal" in text or "Traceback" in text:
            return "INTERNAL", text[-1500:]
        if (
            len(lines) > 2
            or not lines[0].startswith("error: ")
            or (code == 4 and not any(n in lines[0] for n in BLAMED.get(name, (name,))))
        ):
            return "UNCLEAR", text[-1500:]
        if list(self.made.iterdir()):
            return "LITTER", f"refused, and left {[p.name for p in self.made.iterdir()]}"
        return f"refused {code}", lines[0]

    def in_child(self, command: str) -> tuple[int | None, str]:
        """Exit code (negative: a signal, None: out of time) and the text of a run in a process of its own."""
        log = self.folder / "log"
        child = os.fork()
        if child == 0:
            code = 99
            try:
                code, text = self.run(command)
                log.write_text(text)
            finally:
                os._exit(code)
        begin = time.monotonic()
        while True:
            done, status = os.waitpid(child, os.WNOHANG)
            if done:
                code = os.waitstatus_to_exitcode(status)
                return code, log.read_text() if code >= 0 else ""
            if processor_seconds(child) > SECONDS or time.monotonic() - begin > STILL:
                os.kill(child, signal.SIGKILL)
                os.waitpid(child, 0)
                return None, ""
            time.sleep(0.002)


def write_made_up_trade(path: Path) -> None:
    """Two variants and a third that failed, by three criteria, of which one is lacked."""
    criteria = [
        TradedCriterion(name, "noise_ratio", "a ratio", "1", goal, limit, 1.0, "part of ratio²")
        for name, goal, limit in (("read-out", "min", 1.0), ("frequency", "max", None), ("mass", "min", 9.0))
    ]
    values: list[list[float | None]] = [[1.5, 60.0, 8.0], [0.5, 40.0, None], [None] * 3]
    cells = [
        [
            Cell(None, "lacks it") if v is None else Cell(v, "", "of case 3", v <= 1.0, {"A": 2.0 * v, "B": -v})
            for v in row
        ]
        for row in values
    ]
    failure = ("", "", "singular")
    variants = [TradedVariant(f"v{n}", "title", "differs", f"variants/v{n}", why) for n, why in enumerate(failure)]
    with create(path, TRADE, Provenance((), input_files([]), "tedm trade")) as writer:
        write_trade(writer, compared("made up", variants, criteria, cells))


def _kind(path: Path) -> str:
    with h5py.File(path) as file:
        return str(file.attrs["schema"]).removeprefix("tedm.")


def _output(command: str) -> str:
    """Where a command writes: a folder, a page, or an HDF5 file."""
    return {"export-case": "csv", "export-state-space": "csv", "view": "view.html", "merge": "merged"}.get(
        command, "made.h5"
    )


def _spread(main: object) -> str:
    """The main numbers that `show` prints, a line each."""
    if isinstance(main, dict):
        return "".join(_spread(v) for v in main.values())
    return "".join(_spread(v) for v in main) if isinstance(main, list) else f"{main}\n"


def _floats(text: str) -> list[float]:
    """Numbers of a text, but for hashes."""
    found = []
    for word in re.split(r"[,\s|()]+", re.sub(r"\b[0-9a-f]{64}\b", "", text)):
        with contextlib.suppress(ValueError):
            found.append(float(word))
    return [0.0 if math.isnan(v) else v for v in found]
